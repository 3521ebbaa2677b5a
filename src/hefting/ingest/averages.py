"""Averages: motion and wrench of a conditioned recording, averaged where the sensor is
fast."""

from dataclasses import replace

import numpy as np

from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, in_sensor_axes
from hefting.ingest.blocks import Blocks, within_blocks
from hefting.ingest.conditioned import Conditioned
from hefting.motion import Measured, measure
from hefting.motion.measure import Source


def measured_blocks(
    recording: Recording, found: Conditioned, motion: Source, *, drift: bool = True
) -> tuple[Measured, Array, Array]:
    """Corrected motion and wrench, averaged over blocks where the sensor is fast.

    Parameters
    ----------
    recording : as recorded.
    found : its conditioning.
    motion : where the motion comes from.
    drift : whether to remove the drift of the bias.

    Returns
    -------
    The measurements, the number of samples averaged in each row (K,), and the
    covariance (6, 6) of the wrench within the averages.
    """
    corrected = found.corrected(recording, drift)
    wrench = corrected["wrench"]
    smooth = (
        not recording.static
        and motion in ("auto", "smooth")
        and found.curves is not None
    )
    smooth = smooth and (
        recording.has("position") or not recording.has("accelerometer")
    )
    # by the recorded times: shifted ones may round to another block
    recorded = recording["wrench"].time[found.kept]
    blocks = Blocks.of(recorded, wrench.values, smooth=smooth)
    if blocks.starts is None:
        measured = measure(corrected, found.gravity, motion, found.curves)
        return measured, np.ones(len(measured.measurements)), np.zeros((6, 6))
    blocks = replace(blocks, time=blocks.time - found.offset)
    averaged = Stream(blocks.time, blocks.wrench, np.arange(1, len(blocks) + 1))
    averaged_log = replace(corrected, streams={**corrected.streams, "wrench": averaged})
    measured = measure(
        averaged_log, found.gravity, motion, found.curves, counts=blocks.count
    )
    assert measured.rows is not None
    rows = measured.rows - 1
    measured = _averaged_motion(measured, found, blocks.variance[rows])
    return (
        measured,
        blocks.count[rows],
        within_blocks(blocks, wrench.time, wrench.values),
    )


def _averaged_motion(
    measured: Measured, found: Conditioned, variance: Array
) -> Measured:
    """The motion averaged over samples whose times have this variance (K,) [s²].

    It is the mean of the motion one standard deviation earlier and later, which is
    exact to third order.
    """
    motion, z, curves = measured.motion, measured.measurements, found.curves
    if motion is None or curves is None:
        return measured
    apart = np.sqrt(variance)
    inside = (z.time - apart >= curves.poses.first) & (
        z.time + apart <= curves.poses.last
    )
    apart = np.where(inside, apart, 0.0)
    sides = [
        curves.poses.at(z.time + side * apart, spread=False) for side in (-1.0, 1.0)
    ]
    known = [np.isfinite(side.angular_acceleration).all(axis=1) for side in sides]
    usable = (known[0] & known[1] & inside)[:, None]

    def mean(before: Array, after: Array, now: Array) -> Array:
        return np.where(usable, 0.5 * (before + after), now)

    before, after = sides
    gravity = [in_sensor_axes(side.orientation, found.gravity) for side in sides]
    changes = {"gravity": mean(gravity[0], gravity[1], z.gravity)}
    if measured.source != "orientation":
        changes |= {
            name: mean(getattr(before, name), getattr(after, name), getattr(z, name))
            for name in (
                "linear_acceleration",
                "angular_velocity",
                "angular_acceleration",
            )
        }
    return replace(measured, measurements=replace(z, **changes))


def residual_size(residual: Array, counts: Array, within: Array) -> Array:
    """(2,) root mean square of force and torque, of one axis and one sample of the log,
    from the residual (K, 6) of averages over so many samples (K,) and the covariance
    (6, 6) `within` them."""
    square = counts @ residual**2 / max(float(counts.sum()), 1e-300) + within.diagonal()
    return np.sqrt(square.reshape(2, 3).mean(axis=1))

"""Estimate and motion -> Prediction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.estimate import Answered, Estimate, doubts_of, estimate_given
from hefting.core.estimate_json import numbers_in, subtracted_tool
from hefting.core.gravity import ON_EARTH, Gravity
from hefting.core.magnitudes import LARGEST_GRAVITY
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import full_rows, motion_features, predict_wrench
from hefting.core.sensor_accuracy import EXACT, SensorAccuracy
from hefting.core.spatial import PARAMETERS, WRENCH, Array, Mask, frozen
from hefting.core.undetermined import Covariance
from hefting.estimators import METHODS
from hefting.ingest.ingest import Ingested, ingest
from hefting.ingest.mended_times import with_mended_times
from hefting.ingest.tool import load_tool, with_tool
from hefting.logs.given import as_recording
from hefting.motion import Motion, measure
from hefting.motion.measure import TWIST, Source
from hefting.motion.state import acceleration_variances, effect_of_acceleration_errors
from hefting.prediction.result import Agreement, Peak, Prediction, agreement

MOST = 500_000
"""Largest number of predicted instants, all held in memory: eight minutes at 1 kHz."""
ANOTHER_GRAVITY = 0.01
"""Difference of the estimate's gravity from the given one, relative to its size, above
which a warning is given: half a degree."""


def predict(
    estimate: Estimate | Answered | str | Path,
    trajectory: Recording | str | Path,
    *,
    gravity: Gravity | ArrayLike = ON_EARTH,
    tool: Estimate | Answered | str | Path | None = None,
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
    sensor_accuracy: SensorAccuracy | str | None = None,
) -> Prediction:
    """The wrench that an identified object needs along a motion, at each instant of its
    poses.

    Parameters
    ----------
    estimate : an estimate, the result of `hefting.identify`, or a file of one; its
        parameters are in the axes of the sensor that moves.
    trajectory : poses of the sensor, planned or recorded: a recording, the path of a
        log, or a table in memory (`hefting.as_recording`). Without time: static poses.
        A wrench is optional; ``Prediction.agreement`` compares it with the predicted
        one.
    gravity : (3,) in world axes [m/s²], or `Gravity.at` a latitude. The band does not
        include the uncertainty of its size, which cancels where the estimate was made.
    tool : a tool of `hefting.calibrate` that the sensor bears too: the wrench is that of
        both. An estimate made with `tool` is of the object alone.
    motion : source of velocities and accelerations, see
        `hefting.motion.measure.measure`.
    start, duration : part of the motion to use [s].
    sensor_accuracy : accuracy of the sensor that bears the object, as in
        ``0.5% 0.3N 0.01Nm``: the band is then that of its reading, without noise and
        bias.

    Poses without noise are hardly changed by smoothing. At 100 Hz the wrench of smooth
    motion is off by less than 1e-5 of its size (root mean square), that of moves whose
    jerk jumps by 3e-4; a jump of the acceleration is rounded off.

    Raises `InputError` for an estimate or motion that cannot be used and for more than
    `MOST` instants.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv").estimate
    >>> prediction = hefting.predict(found, "demo/log.csv")
    >>> prediction.agreement is not None
    True
    """
    alone = estimate = estimate_given(estimate)
    if tool is not None:
        estimate = with_tool(alone, load_tool(tool))
    trajectory = as_recording(trajectory, wrench_needed=False)
    if start or duration is not None:
        trajectory = trajectory.slice(start, duration)
    trajectory = with_mended_times(trajectory, motion)
    longest = max(len(stream) for stream in trajectory.streams.values())
    if longest > MOST:
        what = f"holds {longest:,} samples of one kind, more than {MOST:,}"
        raise InputError(what, trajectory.source, "take a part: `start`, `duration`")
    accuracy = SensorAccuracy.of(sensor_accuracy)
    spread = None if estimate.covariance is None else Covariance.of(estimate.covariance)
    ingested, agreed, refusal = _compare(
        trajectory, estimate, spread, gravity, accuracy, motion
    )
    measured = measure(
        _wrenchless(trajectory, motion),
        gravity,
        motion,
        ingested.conditioned.curves if ingested else None,
        of="instant",
    )
    z = measured.measurements
    with np.errstate(over="ignore", invalid="ignore"):  # refused below if not finite
        wrench = predict_wrench(z, estimate.parameters.vector)
        reading = (accuracy or EXACT).reading_std(wrench)
        std = None if spread is None else np.hypot(spread.of_wrench(z), reading)
        if not np.isfinite(wrench).all() or (std is not None and np.isnan(std).any()):
            what = "the predicted wrench is not finite: no object is as heavy"
            raise InputError(what, trajectory.source)
        peaks = {
            name: _peak(z, wrench, spread, reading, part)
            for name, part in PARTS.items()
        }
    return Prediction(
        trajectory=trajectory.source,
        method=estimate.method,
        static=trajectory.static,
        time=z.time,
        wrench=wrench,
        std=std,
        peaks=peaks,
        gravity=frozen(gravity),
        source=measured.source,
        motion_std=_motion_spread(estimate.parameters.vector, measured.motion),
        agreement=agreed,
        warnings=(
            *trajectory.warnings,
            *measured.warnings,
            *_doubts(alone, frozen(gravity), borne=tool is not None),
            *_open_warning(spread, std),
            *refusal,
            *(agreed.warnings if agreed else ()),
        ),
        notes=(*trajectory.notes, *measured.notes, *_reading_note(std, accuracy)),
    )


PARTS = {"force": slice(0, 3), "torque": slice(3, 6)}


def _wrenchless(recording: Recording, motion: Source) -> Recording:
    """The recording with a wrench of zeros at every pose whose motion is known, as
    `measure` needs a wrench."""
    poses = recording["orientation"]
    if motion in ("auto", "columns") and recording.has(*TWIST) and not recording.static:
        first = max(recording[name].time[0] for name in TWIST)
        last = min(recording[name].time[-1] for name in TWIST)
        covered = (poses.time >= first) & (poses.time <= last)
        if not covered.any():
            what = "velocities, accelerations and poses have no time in common"
            raise InputError(what, recording.source)
        poses = poses[covered]
    zeros = Stream(poses.time, np.zeros((len(poses), 6)), poses.rows)
    return replace(recording, streams={**recording.streams, "wrench": zeros})


def _compare(
    recording: Recording,
    estimate: Estimate,
    spread: Covariance | None,
    gravity: Gravity | ArrayLike,
    accuracy: SensorAccuracy | None,
    motion: Source,
) -> tuple[Ingested | None, Agreement | None, tuple[Message, ...]]:
    """The recording as ingested and its agreement with the estimate, None without a
    wrench; a warning if it cannot be ingested."""
    if not recording.has("wrench") or not recording["wrench"].values.any():
        return None, None, ()
    try:
        found = ingest(recording, gravity=gravity, bias="estimate", motion=motion)
        return found, agreement(estimate, spread, found, accuracy), ()
    except InputError as error:
        what = f"not compared with the measured wrench: {error}"
        return None, None, (warning("wrench-not-compared", what),)


def _peak(
    z: Measurements,
    wrench: Array,
    spread: Covariance | None,
    reading: Array,
    part: slice,
) -> Peak:
    """The largest force or torque, columns `part` of a predicted wrench (K, 6). To first
    order its standard deviation is that of the component along its direction, from the
    covariance of the parameters and the deviations `reading` (K, 6) of the sensor."""
    magnitude = np.linalg.norm(wrench[:, part], axis=1)
    k = int(np.argmax(magnitude))
    std = None
    if spread is not None:
        direction = (
            wrench[k, part] / magnitude[k] if magnitude[k] > 0.0 else np.zeros(3)
        )
        own = float(
            spread.std(direction @ full_rows(motion_features(z[k : k + 1]))[0, part])
        )
        std = float(np.hypot(own, np.linalg.norm(direction * reading[k, part])))
    return Peak(float(magnitude[k]), float(z.time[k]), std)


def _motion_spread(vector: Array, motion: Motion | None) -> Array | None:
    """(2,) root mean square of one axis of the errors of force [N] and torque [N m] of a
    body of parameters `vector` (10,), by the standard deviations of a smoothed motion.
    None if the log gave the motion, or these are not finite."""
    if motion is None:
        return None
    spread = np.sqrt(
        effect_of_acceleration_errors(vector)
        @ acceleration_variances(motion).mean(axis=1)
        / 3.0
    )
    return spread if np.isfinite(spread).all() else None


def _doubts(estimate: Estimate, gravity: Array, *, borne: bool) -> Iterator[Message]:
    yield from doubts_of(estimate)
    if estimate.covariance is None:
        others = " and ".join(
            name for name, kind in reversed(METHODS.items()) if kind.gives_covariance
        )
        what = f"the estimate ({estimate.method}) has no covariance, so there is no band: {others} give one"
        yield warning("no-band", what)
    if not estimate.physically_consistent:
        what = f"no body has the estimate's parameters: {estimate.consistency}"
        yield warning("not-physical", what)
    tool = subtracted_tool(estimate.provenance)
    if tool is not None and not borne:
        what = (
            f"a tool of {tool[0]:.4g} kg was subtracted for the estimate: the sensor "
            "bears its wrench as well, see `tool`"
        )
        yield warning("tool-subtracted", what, "tool")
    assumed = numbers_in(estimate.provenance, "gravity", 3, LARGEST_GRAVITY)
    far = ANOTHER_GRAVITY * np.linalg.norm(gravity)
    if assumed is not None and np.linalg.norm(assumed - gravity) > far:
        x, y, z = assumed
        what = f"the estimate was made with gravity ({x:.4g}, {y:.4g}, {z:.4g}) m/s²; see `gravity`"
        yield warning("another-gravity", what, "gravity")


def _reading_note(
    std: Array | None, accuracy: SensorAccuracy | None
) -> Iterator[Message]:
    """A note if the band is that of a sensor's reading."""
    if std is not None and accuracy is not None:
        what = f"the band is that of the reading of a sensor of {accuracy}"
        yield note("band-of-reading", what, "sensor_accuracy")


def _open_warning(spread: Covariance | None, std: Array | None) -> Iterator[Message]:
    if spread is None or std is None or not spread.open.any():
        return
    infinite: Mask = np.isinf(std)
    names = ", ".join(np.array(PARAMETERS)[spread.open])
    if not infinite.any():
        what = f"the estimate leaves {names} open, which this motion does not need"
        yield warning("open-not-needed", what)
        return
    touched = ", ".join(np.array(WRENCH)[infinite.any(axis=0)])
    share = f"{100.0 * infinite.any(axis=1).mean():.3g} %"
    what = f"the estimate leaves {names} open: no band for {touched}, at {share} of the instants"
    yield warning("band-open", what)

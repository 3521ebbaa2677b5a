"""Weights of the samples, and the noise of their motion. Accelerations of a sensor of
unknown position are not modelled, and resemble many a mistake."""

import numpy as np

from hefting.core.measurements import Measurements, MotionNoise
from hefting.core.messages import Message, warning
from hefting.core.quantity import significant
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array, lengths
from hefting.estimators.raw_motion import white_motion_noise, white_noise
from hefting.ingest.conditioned import Conditioned
from hefting.motion import Measured
from hefting.motion.state import Motion, sample_weights

REACH = 1.0
"""[m] Largest distance to its axis of a sensor of unknown position that only turns."""
LEVER = 0.3
"""[m] Typical distance."""
SLOW = 1.0
"""[m/s²] Acceleration that such a sensor may have without turning."""
AT_REST = 0.9
"""Weight above which a sample is at rest: its acceleration is a third of the noise."""
LEAST_REST, FEWEST_RESTS = 0.1, 10
"""Least share and number of samples at rest for these alone to be used."""
ENOUGH_SPREAD, NO_SPREAD = 0.25, 1e-6
"""Least variance of gravity along the sensor's axes at rest, over that of all samples,
for these alone to be used; and share of the largest variance that counts as none, as
about a single axis gravity has two. In 15 simulated recordings that stop and go the
mass is held in 14, to 1 % in twelve; with the moves ten are useless."""
LEAST_NOISE = 0.02
"""[m/s²] Lower bound of the force's noise over the mass."""
SMALLEST_NOISE = 1e-12
"""[N, N m] Smallest noise, against division by zero."""
LARGEST_SHARE = 0.04
"""Acceleration over gravity up to which 95 % intervals of the mass hold: it is 0.02 to
0.04 in simulated sinusoids of 1 rad/s, and 0.05 in those of 2 rad/s, whose intervals
fail slightly."""


def weights_of(found: Conditioned, measured: Measured, counts: Array) -> Array | None:
    """Weights (K,), one on average, by the number of samples averaged and the errors of
    the smoothed motion; None if the motion is exact and nothing was averaged."""
    motion = measured.motion
    if motion is None or len(counts) < 2:
        return None if (counts == 1.0).all() else counts / counts.mean()
    if measured.source == "orientation":
        z, mass = measured.measurements, abs(float(found.parameters[0]))
        noise = white_noise(z).force
        weights = counts * weights_at_rest(motion, z.gravity, mass, noise)
    else:
        weights = counts * weights_by_motion(found, motion, float(counts.mean()))
    return weights / weights.mean()


def weights_by_motion(found: Conditioned, motion: Motion, count: float = 1.0) -> Array:
    """Weights (K,) by the errors of the motion beside the noise of averages of `count`
    samples; parameters that are open count as zero."""
    phi = np.where(np.isfinite(found.covariance.diagonal()), found.parameters, 0.0)
    noise = np.maximum((found.noise.force, found.noise.torque), SMALLEST_NOISE)
    return sample_weights(phi, motion, *(noise / max(count, 1.0) ** 0.5))


def motion_noise_of(measured: Measured) -> MotionNoise | None:
    """Errors of the accelerations: those of smoother or filter, or for logged
    accelerations by differences."""
    motion = measured.motion
    if motion is None:
        if measured.source == "columns":
            return white_motion_noise(measured.measurements)
        return measured.measurements.motion_noise
    if motion.linear_acceleration_std is None:
        return None
    return motion.noise


def may_be_acceleration(recording: Recording, found: Conditioned) -> bool:
    """Whether the residuals may be accelerations of a sensor of unknown position, which
    resemble many a mistake."""
    path, curves = found.path, found.curves
    if path is None or path.kind != "orientation" or curves is None:
        return False
    turning = _turning(curves.poses.at(recording["orientation"].time))
    fastest = max(SLOW, REACH * float(np.sqrt(np.nanmean(turning**2))))
    return _acceleration(found) < fastest


def weights_at_rest(motion: Motion, gravity: Array, mass: float, noise: float) -> Array:
    """Weights (K,) by the acceleration of a sensor at `LEVER` from its axis, from
    gravity (K, 3) in sensor axes, the mass and the noise of the force. Samples at rest
    are used alone if gravity varies enough among them."""
    noise = max(noise, LEAST_NOISE * mass, SMALLEST_NOISE)
    weights = 1.0 / (1.0 + (mass * LEVER * _turning(motion) / noise) ** 2)
    rests = weights > AT_REST
    if rests.sum() < max(LEAST_REST * len(rests), FEWEST_RESTS):
        return weights
    spread, all_of_it = (
        np.linalg.eigvalsh(np.cov(g.T)) for g in (gravity[rests], gravity)
    )
    none = NO_SPREAD * all_of_it[-1]
    alone = (spread + none >= ENOUGH_SPREAD * all_of_it).all()
    return np.where(rests, weights, 0.0) if alone else weights


def _turning(motion: Motion) -> Array:
    """(K,) [1/s²] Acceleration of a point over its distance from the axis."""
    return np.hypot(
        lengths(motion.angular_acceleration), lengths(motion.angular_velocity) ** 2
    )


def acceleration_message(
    found: Conditioned, z: Measurements, motion: Motion | None = None
) -> Message | None:
    """A warning if accelerations that are not modelled may be large, by the residual or
    by what of them the `motion` of the samples would hide in the mass, and moving samples
    count."""
    if found.path is None or found.path.kind != "orientation":
        return None
    if z.weights is not None and not np.all(z.weights):
        return None  # only samples at rest count
    size = _acceleration(found)
    share = size / float(np.linalg.norm(STANDARD_GRAVITY))
    if share <= LARGEST_SHARE and motion is not None:
        share = hidden_share(motion, z.gravity)
        size = LEVER * float(np.sqrt(np.nanmean(_turning(motion) ** 2)))
    if share <= LARGEST_SHARE:
        return None
    what = (
        f"without positions accelerations of some {significant(size, 1)} m/s² are not modelled, and "
        f"the mass may be off by {significant(100 * share, 1)} %: log positions or an accelerometer, "
        "or move more slowly"
    )
    return warning("accelerations-unmodelled", what)


def hidden_share(motion: Motion, gravity: Array) -> float:
    """Share of the mass that the acceleration of a sensor at `LEVER` from a fixed point
    adds or hides, in the worst direction: what of it goes with gravity (K, 3) in sensor
    axes, beside a bias. The residual does not show it."""
    speed, change = motion.angular_velocity, motion.angular_acceleration
    turned = gravity - gravity.mean(axis=0)
    hidden = [
        np.sum(
            turned * (np.cross(change, axis) + np.cross(speed, np.cross(speed, axis)))
        )
        for axis in np.eye(3)
    ]
    return LEVER * float(np.linalg.norm(hidden)) / max(float(np.sum(turned**2)), 1e-12)


def _acceleration(found: Conditioned) -> float:
    """[m/s²] Acceleration that would explain the residual force."""
    return 3**0.5 * found.noise.force / max(abs(float(found.parameters[0])), 1e-9)

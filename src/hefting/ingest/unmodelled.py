"""Accelerations of a sensor whose position nobody measured: they are not modelled, and
look like many a mistake."""

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.ingest.conditioned import Conditioned
from hefting.motion.smoothing import smooth_poses
from hefting.motion.state import Motion

REACH = 1.0
"""[m] How far from its centre a sensor of unknown position may be that only turns."""
SLOW = 1.0
"""[m/s²] Acceleration that a sensor may have without turning."""
LEVER = 0.3
"""[m] The same, as it typically is."""
WHITE = 1.0 / (0.6745 * 6.0**0.5)
"""Standard deviation of white noise over the median size of its second difference."""
AT_REST = 0.9
"""Weight from which on a sample is at rest: accelerations are a third of the noise."""
LEAST_REST = 0.1
"""Share of such samples from which on they may serve alone."""
ENOUGH_SPREAD = 0.25
"""Variance of gravity along the sensor's axes at rest over that of all samples from
which on they do. Of 15 simulated recordings that stop and go the mass of 14 is known
to some 1 %; with the moves, ten are of no use."""
LEAST_NOISE = 0.02
"""[m/s²] Noise of the force over the mass that is assumed at least."""
LARGEST_SHARE = 0.04
"""Acceleration over gravity up to which 95 % intervals of the mass hold it: simulated
sinusoids of 1 rad/s have 0.02 to 0.04, those of 2 rad/s 0.05, and miss it a little."""


def may_be_acceleration(recording: Recording, found: Conditioned) -> bool:
    """Whether what is unexplained may be the acceleration of a sensor whose position
    nobody measured: it looks like many a mistake."""
    if found.path is None or found.path.kind != "orientation":
        return False
    turning = _turning(smooth_poses(recording).poses.at(recording["orientation"].time))
    fastest = max(SLOW, REACH * float(np.sqrt(np.nanmean(turning**2))))
    return _acceleration(found) < fastest


def weights_at_rest(motion: Motion, z: Measurements, found: Conditioned) -> Array:
    """Weights (K,) by the acceleration of a sensor that is `LEVER` from the axis about
    which it turns: what rests counts most, and alone where it tells as much of gravity
    as all samples do."""
    if len(z.force) < 3:
        return np.ones(len(z.force))
    noise = WHITE * np.median(np.abs(np.diff(z.force, 2, axis=0)))
    mass = abs(float(found.parameters[0]))
    noise = max(float(noise), LEAST_NOISE * mass)
    weights = 1.0 / (1.0 + (mass * LEVER * _turning(motion) / noise) ** 2)
    rests = weights > AT_REST
    if np.mean(rests) < LEAST_REST:
        return weights
    spread, all_of_it = (
        np.linalg.eigvalsh(np.cov(gravity.T))
        for gravity in (z.gravity[rests], z.gravity)
    )
    alone = (spread >= ENOUGH_SPREAD * all_of_it).all()
    return np.where(rests, weights, 0.0) if alone else weights


def _turning(motion: Motion) -> Array:
    """(K,) [1/s²] Acceleration of a point over its distance from the axis."""
    return np.hypot(
        np.linalg.norm(motion.angular_acceleration, axis=1),
        np.linalg.norm(motion.angular_velocity, axis=1) ** 2,
    )


def acceleration_message(found: Conditioned, z: Measurements) -> Message | None:
    """A doubt where accelerations that are not modelled are not small, and count."""
    if found.path is None or found.path.kind != "orientation":
        return None
    if z.weights is not None and not np.all(z.weights):
        return None  # what rests serves alone
    size = _acceleration(found)
    share = size / float(np.linalg.norm(STANDARD_GRAVITY))
    if share <= LARGEST_SHARE:
        return None
    what = (
        f"without positions accelerations of some {size:.1g} m/s² are not modelled, and "
        f"the mass may be off by {100 * share:.1g} %: log positions or an accelerometer, "
        "or move more slowly"
    )
    return warning("accelerations-unmodelled", what)


def _acceleration(found: Conditioned) -> float:
    """[m/s²] What would explain the unexplained force."""
    return 3**0.5 * found.noise.force / max(abs(float(found.parameters[0])), 1e-9)

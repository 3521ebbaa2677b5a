"""Measurements of 1.5 s as on a robot: noisy poses and wrench, with the motion by a
Kalman filter or a smoother.

The filter is that of Farsoni et al. 2017: causal, of constant acceleration, with the
orientation as a quaternion. *Warm*, it has settled before the first observation; *cold*,
it starts there, at rest and with its stationary gains.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Self

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    Array,
    immutable,
    in_sensor_axes,
    tensor_to_vector,
)
from hefting.estimators import GEO, Estimator
from hefting.estimators.geo import weight_by_rule
from hefting.estimators.quadratic import Quadratic
from hefting.estimators.sample_state import SampleState
from hefting.ingest.free_fit import fit_freely
from hefting.motion import sample_weights
from hefting.motion.kalman import PoseFilter
from hefting.motion.spline import fit_poses
from hefting.motion.state import Motion
from hefting.reproduction.experiment import RATE, Thing
from hefting.simulation import Wielding
from hefting.simulation.faults import Six
from hefting.simulation.wield import POSE_NOISE

OBSERVATIONS = 150
"""Number of samples in a window: 1.5 s at 100 Hz."""
EARLIEST, STEP = 2.0, 1.6
"""Begin of the first window, and time between the begins of windows [s]."""


@immutable
class Observed:
    """Poses and wrench of a robot at K instants."""

    time: Array
    """(K,) [s]"""
    position: Array
    """(K, 3) of the sensor's origin in world axes [m]"""
    orientation: Array
    """(K, 4) xyzw, sensor in world"""
    wrench: Array
    """(K, 6) [N, N m], exerted by the sensor on the object"""

    @classmethod
    def of(
        cls,
        wielding: Wielding,
        wrench_noise: Six,
        seed: tuple[int, ...],
        pose_noise: tuple[float, float] = POSE_NOISE,
    ) -> Self:
        """A wielding with seeded Gaussian noise: `wrench_noise` (6,) [N, N m], and
        `pose_noise` [m], [rad] per axis."""
        from scipy.spatial.transform import Rotation

        motion, rng = wielding.motion, np.random.default_rng(seed)
        K = len(motion.time)
        turns = Rotation.from_rotvec(pose_noise[1] * rng.normal(size=(K, 3)))
        return cls(
            motion.time,
            motion.position + pose_noise[0] * rng.normal(size=(K, 3)),
            (Rotation.from_matrix(motion.rotation) * turns).as_quat(),
            wielding.measurements.wrench
            + np.array(wrench_noise) * rng.normal(size=(K, 6)),
        )

    def __getitem__(self, window: slice) -> Self:
        """The instants of a window."""
        arrays = (self.time, self.position, self.orientation, self.wrench)
        return type(self)(*(values[window] for values in arrays))

    def with_motion(self, motion: Motion) -> Measurements:
        """Measurements at the instants of a motion."""
        kept = np.isin(self.time, motion.time)
        g = in_sensor_axes(motion.orientation, STANDARD_GRAVITY)
        a, wrench = motion.linear_acceleration, self.wrench[kept]
        assert a is not None
        w, alpha = motion.angular_velocity, motion.angular_acceleration
        return Measurements(motion.time, g, a, w, alpha, wrench[:, :3], wrench[:, 3:])


def windows(duration: float) -> list[slice]:
    """All windows of a motion of `duration` [s]."""
    most = int((duration - EARLIEST) / STEP) + 1
    starts = [round(RATE * (EARLIEST + STEP * i)) for i in range(most)]
    last = round(RATE * duration) - OBSERVATIONS
    return [slice(k, k + OBSERVATIONS) for k in starts if k <= last]


def causal_filter(observed: Observed) -> PoseFilter:
    """The paper's filter, with the most likely noise and bandwidth for the motion."""
    return PoseFilter.tuned(
        observed.time,
        observed.position,
        observed.orientation,
        order="acceleration",
        lag=0.0,
    )


def motions(observed: Observed) -> dict[str, Iterator[Measurements]]:
    """Measurements of each window, by kind of motion."""
    live = causal_filter(observed)
    return {
        "warm": warm(observed, live),
        "cold": cold(observed, live),
        "smoother": smoothed(observed),
    }


def warm(observed: Observed, live: PoseFilter) -> Iterator[Measurements]:
    """Each window, by a filter that runs from the start of the motion."""
    z = _followed(observed, live)
    missing = len(observed.time) - len(z)  # before the filter settles
    for window in _windows_of(observed):
        yield z[window.start - missing : window.stop - missing]


def cold(observed: Observed, live: PoseFilter) -> Iterator[Measurements]:
    """Each window, by a filter that starts with it."""
    for window in _windows_of(observed):
        yield begun_with(observed[window], live)


def begun_with(observed: Observed, live: PoseFilter) -> Measurements:
    """All instants, by a filter that starts with the first."""
    return _followed(observed, replace(live, cold_start=True))


def _followed(observed: Observed, live: PoseFilter) -> Measurements:
    o = observed
    _, motion = live.update(live.start(), o.time, o.position, o.orientation)
    return o.with_motion(motion)


def smoothed(observed: Observed) -> Iterator[Measurements]:
    """Each window, by this project's smoother and weights from its poses alone."""
    for window in _windows_of(observed):
        part = observed[window]
        motion = fit_poses(part.time, part.position, part.orientation).at(part.time)
        z = part.with_motion(motion)
        fit = fit_freely(z, False)
        weights = sample_weights(fit.vector, motion, fit.noise.force, fit.noise.torque)
        yield replace(z, weights=weights / weights.mean())


def _windows_of(observed: Observed) -> list[slice]:
    return windows(len(observed.time) / RATE)


WEAK = 1e-3
"""Factor of the literature's weight of GEO's prior."""


def weak_geo(subject: Thing, z: Measurements) -> Estimator:
    """GEO with a negligible weight of its prior: the most likely possible body."""
    gamma = WEAK * weight_by_rule(Quadratic.of(SampleState.of(z)).A)
    return GEO(subject.shape, gamma=gamma, intervals=False)


def noise_found(subject: Thing, z: Measurements) -> Estimator:
    """GEO with the noise of least squares' residuals, increased for autocorrelation."""
    fit = fit_freely(z, False)
    factor = float(np.sqrt(fit.autocorrelation))
    return GEO(
        subject.shape,
        noise=Noise(factor * fit.noise.force, factor * fit.noise.torque),
        intervals=False,
    )


def doubled(subject: Thing, z: Measurements) -> Estimator:
    """GEO with a prior that is moved from the COM to the sensor twice, as in public code
    of the paper's authors."""
    body = subject.shape.homogeneous
    inertia = 2.0 * body.inertia_at_origin - body.inertia_at_com
    unit = np.concatenate(((1.0,), body.center_of_mass, tensor_to_vector(inertia)))
    mass = float(fit_freely(z, False).vector[0])
    return GEO(prior=InertialParameters(mass * unit), intervals=False)


SCORES = ("mass", "center_of_mass", "inertia_at_origin", "inertia_at_com", "consistent")
"""Columns of `score`."""


def score(subject: Thing, method: Estimator, z: Measurements) -> list[float]:
    """Errors [%] of mass, COM, inertia about sensor and COM, with four digits; and 1 if
    the body is possible, else 0."""
    estimate = method.fit(z)
    errors = subject.errors(estimate)
    return [
        *(float(f"{getattr(errors, name):.4g}") for name in SCORES[:4]),
        float(estimate.physically_consistent),
    ]

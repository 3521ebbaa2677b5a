"""Poses in, parameters out: the motion's errors cost little, once samples are weighted
by them."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.errors import InputError
from hefting.core.measurements import Measurements
from hefting.core.regressor import full_regressor
from hefting.core.spatial import skew, vector_to_tensor
from hefting.motion.kalman import PoseFilter
from hefting.motion.spline import smooth
from hefting.motion.state import Motion, sample_weights
from motions import Truth, box, random_smooth, stop_and_go

FORCE_NOISE, TORQUE_NOISE = 0.1, 0.005
BODY = box()


def least_squares(motion: Motion | Truth, gravity, wrench, weights=None):
    """Ten parameters, by whitened least squares."""
    a = motion.linear_acceleration
    w = motion.angular_velocity
    alpha = motion.angular_acceleration
    A = full_regressor(
        Measurements(motion.time, gravity, a, w, alpha, wrench[:, :3], wrench[:, 3:])
    )
    scale = 1.0 / np.repeat((FORCE_NOISE, TORQUE_NOISE), 3)
    scale = scale if weights is None else scale * np.sqrt(weights)[:, None]
    scale = np.broadcast_to(scale, wrench.shape)
    return np.linalg.lstsq(
        (scale[..., None] * A).reshape(-1, 10), (scale * wrench).ravel(), rcond=None
    )[0]


def errors(vector):
    """Of mass, COM and inertia about the sensor origin."""
    truth = BODY.vector()
    return (
        vector[0] - truth[0],
        np.linalg.norm(vector[1:4] / vector[0] - BODY.center),
        np.linalg.norm(vector[4:] - truth[4:]),
    )


@cache
def identify(seed, duration, rate, make, live):
    """Errors (3,) with the exact motion, with the motion from poses unweighted, and
    weighted."""
    rng = np.random.default_rng(seed)
    # a live filter is tuned on what comes before, and started cold after it
    lead = 1.5 if live else 0.0
    truth = make(np.arange(0, lead + duration + (0.2 if live else 0.0), 1 / rate), rng)
    position, orientation = truth.poses(rng)
    wrench = np.hstack(BODY.wrench(truth))
    wrench = wrench + np.repeat((FORCE_NOISE, TORQUE_NOISE), 3) * rng.normal(
        size=wrench.shape
    )
    if live:
        k = round(lead * rate)
        pose_filter = PoseFilter.tuned(truth.time[:k], position[:k], orientation[:k])
        _, motion = pose_filter.update(
            pose_filter.start(), truth.time[k:], position[k:], orientation[k:]
        )
    else:
        motion = smooth(truth.time, position, orientation)
    at = np.searchsorted(truth.time, motion.time - 1e-9)
    exact = Truth(
        truth.time[at],
        *(getattr(truth, n)[at] for n in list(truth.__dataclass_fields__)[1:]),
    )
    gravity = Rotation.from_quat(motion.orientation).inv().apply((0, 0, -9.80665))
    perfect = least_squares(exact, exact.gravity(), wrench[at])
    plain = weighted = least_squares(motion, gravity, wrench[at])
    for _ in range(2):
        weights = sample_weights(weighted, motion, FORCE_NOISE, TORQUE_NOISE)
        weighted = least_squares(motion, gravity, wrench[at], weights)
    return [errors(v) for v in (perfect, plain, weighted)]


@pytest.mark.parametrize(
    ("make", "duration", "rate", "live", "bounds"),
    [  # RMS error over that with perfect kinematics: mass, COM, inertia
        (random_smooth, 1.5, 100.0, False, (1.25, 1.8, 1.8)),
        (random_smooth, 5.0, 100.0, False, (1.15, 1.3, 1.6)),
        (random_smooth, 1.5, 1000.0, False, (1.25, 1.8, 1.8)),
        (random_smooth, 1.5, 100.0, True, (1.4, 1.8, 1.8)),
        (random_smooth, 1.5, 1000.0, True, (1.4, 1.8, 1.8)),
        (stop_and_go, 1.5, 100.0, False, (1.6, 3.5, 3.0)),
    ],
)
def test_errors_stay_near_those_of_perfect_kinematics(
    make, duration, rate, live, bounds
):
    windows = {100.0: 20, 1000.0: 8}[rate] if duration < 5 else 10
    runs = np.array(
        [identify(seed, duration, rate, make, live) for seed in range(windows)]
    )
    perfect, plain, weighted = np.sqrt(np.mean(runs**2, axis=0))
    assert np.all(weighted <= np.array(bounds) * perfect)
    # on the same windows the ratio of two RMS errors that are mostly the wrench's is
    # uncertain by a tenth
    assert np.all(weighted <= 1.25 * plain)


def test_weighting_helps_where_the_motion_is_least_certain():
    runs = np.array(
        [identify(seed, 1.5, 100.0, stop_and_go, False) for seed in range(20)]
    )
    _, plain, weighted = np.sqrt(np.mean(runs**2, axis=0))
    assert weighted[1] < 0.8 * plain[1]


def some_motion(**changes):
    K, one = 50, np.ones((50, 3))
    values = {
        "time": np.arange(K) * 0.01,
        "orientation": np.tile([0, 0, 0, 1.0], (K, 1)),
        "angular_velocity": one,
        "angular_acceleration": one,
        "angular_velocity_std": np.full(K, 0.01),
        "angular_acceleration_std": np.linspace(0.01, 1.0, K),
        "linear_acceleration": one,
        "linear_acceleration_std": np.linspace(0.01, 0.3, K),
        "bandwidth": 20.0,
    }
    return Motion(**{**values, **changes})


def test_weights_equal_the_trace_of_the_covariances():
    motion, phi = some_motion(), BODY.vector()
    lever, J = skew(phi[1:4]), vector_to_tensor(phi[4:])
    E = np.block([[phi[0] * np.eye(3), -lever], [lever, J]])
    S_w = np.diag(np.repeat((FORCE_NOISE**2, TORQUE_NOISE**2), 3))
    expected = []
    for a, alpha in zip(
        motion.linear_acceleration_std, motion.angular_acceleration_std, strict=True
    ):
        S = E @ np.diag(np.repeat((a**2, alpha**2), 3)) @ E.T * (100.0 / 20.0)
        expected.append(1 / (1 + np.trace(np.linalg.solve(S_w, S)) / 6))
    weights = sample_weights(phi, motion, FORCE_NOISE, TORQUE_NOISE)
    np.testing.assert_allclose(weights, expected, rtol=1e-12)  # rounding
    assert np.all(np.diff(weights) < 0)
    assert np.all((weights > 0) & (weights <= 1))


def test_weights_at_the_limits():
    phi = BODY.vector()
    zero, unknown = np.zeros(50), np.full(50, np.inf)
    exact = some_motion(linear_acceleration_std=zero, angular_acceleration_std=zero)
    np.testing.assert_array_equal(
        sample_weights(phi, exact, FORCE_NOISE, TORQUE_NOISE), 1.0
    )
    gap = some_motion(linear_acceleration_std=unknown, angular_acceleration_std=unknown)
    np.testing.assert_array_equal(
        sample_weights(phi, gap, FORCE_NOISE, TORQUE_NOISE), 0.0
    )
    # with the position unknown, the rotation's part is left
    alone = some_motion(linear_acceleration=None, linear_acceleration_std=None)
    part = some_motion(linear_acceleration_std=zero)
    np.testing.assert_array_equal(
        sample_weights(phi, alone, FORCE_NOISE, TORQUE_NOISE),
        sample_weights(phi, part, FORCE_NOISE, TORQUE_NOISE),
    )
    with pytest.raises(InputError, match="positive noise"):
        sample_weights(phi, exact, 0.0, TORQUE_NOISE)


def test_a_lift_shows_nothing_of_the_height_of_the_centre_of_mass():
    """What moves across the vertical there is noise of the poses alone, of which the
    information is no more: 12 of 25 *good* intervals had missed that height."""
    time, mass, com = np.arange(0, 1.3, 0.01), 2.0, np.array((0.02, -0.03, 0.12))
    u = np.clip((time - 0.3) / 1.0, 0.0, 1.0)
    height, rise = u**3 * (10 - 15 * u + 6 * u**2), 60 * u - 180 * u**2 + 120 * u**3
    force = np.outer(9.80665 + 0.15 * rise, (0.0, 0.0, mass))
    for seed in range(4):
        rng = np.random.default_rng(seed)
        noise = rng.normal(size=(len(time), 6)) * np.repeat((0.05, 0.003), 3)
        position = np.outer(0.15 * height, (0, 0, 1)) + 1e-4 * rng.normal(
            size=(len(time), 3)
        )
        found = hefting.identify(
            time=time,
            position=position,
            orientation=Rotation.from_rotvec(2e-4 * rng.normal(size=(len(time), 3))),
            wrench=np.hstack((force, np.cross(com, force))) + noise,
        )
        low, high = found.interval("center_of_mass")
        assert low[2] < com[2] < high[2]

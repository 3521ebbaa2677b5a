"""Regressors against Pinocchio, facts of the reduced one, and virtual samples against
all samples."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.core.moments import Moments
from hefting.core.regressor import (
    dynamism,
    features,
    full_model_weight,
    full_regressor,
    full_rows,
    predict_wrench,
    reduced_regressor,
    reduced_rows,
)
from hefting.core.spatial import move_wrench
from hefting.simulation import UR5, hammer, random_smooth, sinusoids, wield

FROM_PINOCCHIO = [0, 1, 2, 3, 4, 5, 7, 6, 8, 9]
"""Pinocchio has Ixx Ixy Iyy Ixz Iyz Izz, the project Jxx Jxy Jxz Jyy Jyz Jzz."""


def random_measurements(K: int, seed: int, scale: float = 1.0) -> Measurements:
    rng = np.random.default_rng(seed)
    a, w, alpha, force, torque = scale * rng.normal(size=(5, K, 3))
    g = rng.normal(size=(K, 3))
    g *= 9.81 / np.linalg.norm(g, axis=1, keepdims=True)
    return Measurements(np.arange(K) * 0.01, g, a, w, alpha, force, torque)


@pytest.fixture(scope="module")
def wielded() -> Measurements:
    """Noisy measurements of a hammer, with a constant bias."""
    exact = wield(
        UR5.motion(random_smooth(20.0, 100.0, 1.0, seed=5)), hammer().parameters
    )
    return exact.with_noise(NOISE_LEVELS["moderate"], seed=6)


# the full regressor


@pytest.mark.parametrize("scale", [1e-3, 1.0, 30.0])
def test_full_regressor_equals_pinocchios(scale):
    """Pinocchio takes spatial acceleration: linear part a - w x v of the classical a,
    for any velocity v."""
    pin = pytest.importorskip(
        "pinocchio", reason="Pinocchio is not installed (pip install 'hefting[robot]')"
    )
    measurements = random_measurements(50, seed=1, scale=scale)
    ours = full_regressor(measurements)
    velocity = scale * np.random.default_rng(2).normal(size=(50, 3))
    for k in range(50):
        w = measurements.angular_velocity[k]
        classical = measurements.linear_acceleration[k] - measurements.gravity[k]
        spatial = classical - np.cross(w, velocity[k])
        v = pin.Motion(velocity[k], w)
        a = pin.Motion(spatial, measurements.angular_acceleration[k])
        theirs = pin.bodyRegressor(v, a)[:, FROM_PINOCCHIO]
        # double rounding of sums of a dozen products of this size
        np.testing.assert_allclose(
            ours[k], theirs, atol=1e-13 * max(10.0, 4.0 * scale**2), rtol=0.0
        )


def test_wrench_equals_pinocchios_inertia():
    """Independent of Pinocchio's regressor: I a + v x* I v of its own inertia class."""
    pin = pytest.importorskip(
        "pinocchio", reason="Pinocchio is not installed (pip install 'hefting[robot]')"
    )
    body = hammer().parameters
    inertia = pin.Inertia(body.mass, body.center_of_mass, body.inertia_at_com)
    np.testing.assert_allclose(
        inertia.toDynamicParameters()[FROM_PINOCCHIO],
        body.vector,
        rtol=1e-13,
        atol=1e-15,
    )
    measurements = random_measurements(20, seed=3)
    predicted = predict_wrench(measurements, body.vector)
    for k in range(20):
        w = measurements.angular_velocity[k]
        v = pin.Motion(np.zeros(3), w)
        a = pin.Motion(
            measurements.linear_acceleration[k] - measurements.gravity[k],
            measurements.angular_acceleration[k],
        )
        expected = (inertia * a + v.cross(inertia * v)).vector
        # rounding of terms up to 10
        np.testing.assert_allclose(predicted[k], expected, atol=1e-13)


def test_wrench_of_point_masses_is_newtons():
    """A cloud of points: the sum of each point's own m (a_i - g), and of its moment."""
    rng = np.random.default_rng(4)
    positions, masses = rng.normal(scale=0.1, size=(7, 3)), rng.uniform(0.1, 1.0, 7)
    measurements = random_measurements(10, seed=5)
    predicted = predict_wrench(
        measurements, InertialParameters.from_points(positions, masses).vector
    )
    for k in range(10):
        w = measurements.angular_velocity[k]
        alpha = measurements.angular_acceleration[k]
        a = (
            measurements.linear_acceleration[k]
            + np.cross(alpha, positions)
            + np.cross(w, np.cross(w, positions))
        )
        forces = masses[:, None] * (a - measurements.gravity[k])
        # rounding of terms up to 40
        np.testing.assert_allclose(predicted[k, :3], forces.sum(axis=0), atol=1e-12)
        np.testing.assert_allclose(
            predicted[k, 3:], np.cross(positions, forces).sum(axis=0), atol=1e-12
        )


def test_regressor_follows_a_change_of_frame():
    """The wrench of a body seen from another frame is the wrench moved there."""
    measurements = random_measurements(30, seed=7)
    body = hammer().parameters
    turn = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn * np.sign(np.linalg.det(turn)), (0.3, -0.2, 0.1)
    there = measurements.moved(pose)
    predicted = predict_wrench(there, body.moved(pose).vector)
    here = predict_wrench(measurements, body.vector)
    expected = np.hstack(move_wrench(pose, here[:, :3], here[:, 3:]))
    # rounding of terms up to 20
    np.testing.assert_allclose(predicted, expected, atol=1e-12)


# the reduced regressor


def test_reduced_regressor_has_no_inertia_and_rank_four():
    reduced = reduced_regressor(random_measurements(200, seed=9))
    assert not reduced[:, :, 4:].any()
    values = np.linalg.svd(reduced.reshape(-1, 10), compute_uv=False)
    assert values[3] > 1.0
    assert values[4] < 1e-12 * values[0]


def test_reduced_equals_full_at_rest():
    moving = random_measurements(40, seed=10)
    zero = np.zeros((40, 3))
    still = Measurements(
        moving.time, moving.gravity, zero, zero, zero, moving.force, moving.torque
    )
    np.testing.assert_array_equal(full_regressor(still), reduced_regressor(still))
    np.testing.assert_array_equal(reduced_regressor(moving), reduced_regressor(still))
    assert np.abs(full_regressor(moving) - full_regressor(still)).max() > 1.0


def test_dynamism_and_weight():
    a = [[1.0, 2.0, 2.0]]
    w = [[0.5, 0.0, 0.0]]
    alpha = [[0.0, 3.0, 4.0]]
    none = [[0.0, 0.0, 0.0]]
    one = Measurements([0.0], [[0.0, 0.0, -9.8]], a, w, alpha, none, none)
    assert dynamism(one)[0] == pytest.approx(9.0 + 25.0 + 1.0)
    assert full_model_weight(one, c1=105.0)[0] == pytest.approx(np.tanh(1.0))


# virtual samples


def sums(A: np.ndarray, b: np.ndarray, ones: np.ndarray, W: np.ndarray):
    """A'WA and A'Wb over all samples, A with six columns of bias beside the ten
    parameters."""
    A = np.concatenate((A, ones[:, None, None] * np.eye(6)), axis=2)
    WA, rows = (W @ A).reshape(-1, 16), A.reshape(-1, 16)
    return rows.T @ WA, WA.T @ b.ravel(), b.ravel() @ (b @ W).ravel()


def direct(measurements: Measurements, W, reduced: bool):
    rows = reduced_regressor if reduced else full_regressor
    root = (
        np.ones(len(measurements))
        if measurements.weights is None
        else np.sqrt(measurements.weights)
    )
    return sums(rows(measurements), root[:, None] * measurements.wrench, root, W)


def virtual(moments: Moments, W, reduced: bool):
    return sums(
        moments.reduced if reduced else moments.full, moments.wrench, moments.ones, W
    )


def assert_same_sums(moments: Moments, measurements: Measurements, seed: int = 11):
    root = np.random.default_rng(seed).normal(size=(6, 6))
    W = root @ root.T
    for reduced in (False, True):
        for ours, expected in zip(
            virtual(moments, W, reduced), direct(measurements, W, reduced), strict=True
        ):
            # backward-stable factoring of 2,000 rows in double precision; the largest
            # entry sets the scale
            np.testing.assert_allclose(
                ours, expected, atol=1e-13 * np.abs(expected).max(), rtol=0.0
            )


def test_virtual_samples_give_the_same_sums(wielded):
    assert_same_sums(Moments.of(wielded), wielded)


def test_virtual_samples_with_sample_weights(wielded):
    weighted = replace(
        wielded, weights=np.random.default_rng(12).uniform(0.0, 2.0, len(wielded))
    )
    assert_same_sums(Moments.of(weighted), weighted)


def test_merge_in_any_order(wielded):
    parts = [Moments.of(wielded[i::4]) for i in range(4)]
    for order in itertools.permutations(parts):
        merged = order[0]
        for part in order[1:]:
            merged = merged.merge(part, one_bias=True)
        assert merged.samples == len(wielded)
        assert (merged.start, merged.end) == (wielded.time[0], wielded.time[-1])
        assert_same_sums(merged, wielded)


def test_sample_by_sample_and_in_blocks(wielded):
    few = wielded[:300]
    single, blocks = Moments.empty(), Moments.empty()
    for k in range(len(few)):
        single = single.fold(few[k : k + 1])
    for k in range(0, len(few), 37):
        blocks = blocks.fold(few[k : k + 37])
    for moments in (single, blocks):
        assert moments.samples == len(few)
        assert_same_sums(moments, few)


def test_fewer_samples_than_features(wielded):
    assert_same_sums(Moments.of(wielded[:3]), wielded[:3])


def test_scaled_samples(wielded):
    """PMD's two sets: samples scaled by w and by 1 - w."""
    w = full_model_weight(wielded, 300.0)
    moments = Moments.empty().fold(wielded, scale=w)
    assert_same_sums(moments, replace(wielded, weights=w**2))


def test_a_virtual_sample_is_one_factor_row(wielded):
    """Virtual samples' regressors come from the same linear map as those of real
    ones."""
    moments = Moments.of(wielded)
    np.testing.assert_array_equal(moments.full, full_rows(moments.factor))
    np.testing.assert_array_equal(moments.reduced, reduced_rows(moments.factor))
    x = features(wielded)
    R = moments.factor
    # backward stability
    np.testing.assert_allclose(R.T @ R, x.T @ x, atol=1e-13 * np.abs(x.T @ x).max())
    np.testing.assert_array_equal(R, np.triu(R))


def test_least_squares_from_virtual_samples(wielded):
    """Parameters from 22 rows equal those from 12,000 rows."""
    moments = Moments.of(wielded)
    A, b = full_regressor(wielded).reshape(-1, 10), wielded.wrench.ravel()
    expected = np.linalg.lstsq(A, b, rcond=None)[0]
    found = np.linalg.lstsq(
        moments.full.reshape(-1, 10), moments.wrench.ravel(), rcond=None
    )[0]
    scale = np.linalg.norm(A, axis=0)
    np.testing.assert_allclose(
        found * scale, expected * scale, atol=1e-12 * np.abs(expected * scale).max()
    )


def test_moments_of_nothing():
    empty = Moments.empty()
    assert (empty.samples, empty.duration) == (0, 0.0)
    assert not empty.factor.any()
    one = Moments.of(wield(UR5.motion(sinusoids(1.0, 10.0)), hammer().parameters))
    both = empty.merge(one).factor
    # rounding of sums up to 1e3
    np.testing.assert_allclose(both.T @ both, one.factor.T @ one.factor, atol=1e-12)

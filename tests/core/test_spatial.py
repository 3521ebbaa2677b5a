"""Frame changes of wrench, motion and body, and the helpers they are made of."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import (
    TENSOR_COLUMNS,
    TENSOR_ROWS,
    angle_between,
    changed_rows,
    check_pose,
    cross,
    distinct,
    freeze,
    frozen,
    interpolated,
    inverse_pose,
    move_motion,
    move_wrench,
    pose_matrix,
    quantile,
    quaternion_of,
    rotation_by,
    rotation_matrices,
    rotation_vector,
    runs_of,
    skew,
    squared_lengths,
    tensor_to_vector,
    vector_to_tensor,
)
from random_problems import random_body, random_motion, random_pose, with_wrench

ROUNDING = 1e-13
"""A dozen products of numbers of the order of one to ten."""


@pytest.fixture
def rng():
    return np.random.default_rng(1)


def test_skew_is_the_cross_product(rng):
    u, v = rng.normal(size=(2, 5, 4, 3))
    np.testing.assert_allclose(
        np.einsum("...ij,...j->...i", skew(u), v), np.cross(u, v), atol=1e-15
    )
    np.testing.assert_array_equal(skew(u), -np.swapaxes(skew(u), -1, -2))


def test_cross_products_of_vectors_whose_components_come_first(rng):
    u, v = rng.normal(size=(2, 3, 5, 4))
    expected = np.cross(u, v, axis=0)
    np.testing.assert_allclose(cross(u, v), expected, atol=ROUNDING)


def test_squared_lengths_are_of_force_and_torque(rng):
    wrenches = rng.normal(size=(4, 7, 6))
    lengths = np.linalg.norm(wrenches.reshape(4, 7, 2, 3), axis=3)
    np.testing.assert_allclose(squared_lengths(wrenches), lengths**2, rtol=ROUNDING)


@pytest.mark.parametrize("count", [1, 2, 3, 100])
def test_quantiles_and_distinct_numbers_are_numpys(rng, count):
    values = rng.integers(0, 40, count) / 7.0
    for share in (0.0, 0.1, 0.5, 0.99, 1.0):
        assert quantile(values, share) == pytest.approx(np.quantile(values, share))
    assert np.array_equal(distinct(values), np.unique(values))
    assert len(distinct([])) == 0


def test_tensor_order(rng):
    S = rng.normal(size=(5, 3, 3))
    S = S + np.swapaxes(S, 1, 2)
    v = tensor_to_vector(S)
    np.testing.assert_array_equal(vector_to_tensor(v), S)
    np.testing.assert_array_equal(
        v[0], [S[0, 0, 0], S[0, 0, 1], S[0, 0, 2], S[0, 1, 1], S[0, 1, 2], S[0, 2, 2]]
    )
    np.testing.assert_array_equal(v, S[:, TENSOR_ROWS, TENSOR_COLUMNS])


def test_rotations_are_scipys(rng):
    turns = Rotation.random(50, random_state=rng)
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(
            rotation_matrices(sign * turns.as_quat()), turns.as_matrix(), atol=1e-15
        )
    pose = pose_matrix([1.0, 2.0, 3.0, *turns[0].as_quat()])
    np.testing.assert_allclose(pose[:3, :3], turns[0].as_matrix(), atol=1e-15)
    np.testing.assert_array_equal(pose[:, 3], [1.0, 2.0, 3.0, 1.0])


@pytest.mark.parametrize(
    "numbers",
    [
        [0, 0, 0, 0, 0, 0],
        [0, 0, 0, 0, 0, 0, 2],
        [0, 0, 0, 0, 0, 0, 0],
        [np.nan, 0, 0, 0, 0, 0, 1],
    ],
)
def test_what_is_no_pose_is_refused(numbers):
    with pytest.raises(InputError, match="pose"):
        pose_matrix(numbers)


def test_what_is_no_rigid_motion_is_refused(rng):
    good = random_pose(rng)
    np.testing.assert_array_equal(check_pose(good), good)
    bad = [
        2.0 * good,
        good[:3],
        np.diag((1.0, 1.0, -1.0, 1.0)),
        np.full((4, 4), np.nan),
        good.T,
    ]
    for pose in bad:
        with pytest.raises(InputError, match="pose"):
            check_pose(pose)
    with pytest.raises(InputError, match="transpose it"):
        check_pose(good.T)


def test_a_pose_of_few_digits_becomes_the_nearest_rigid_motion(rng):
    good = random_pose(rng)
    found = check_pose(good.round(4))
    turns = found[:3, :3]
    np.testing.assert_allclose(turns @ turns.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(found, good, atol=1e-4)
    with pytest.raises(InputError, match="proper rotation"):
        check_pose(good.round(2))


def test_inverse_pose(rng):
    A, B = random_pose(rng), random_pose(rng)
    np.testing.assert_allclose(inverse_pose(A) @ A, np.eye(4), atol=1e-15)
    np.testing.assert_allclose(
        inverse_pose(A @ B), inverse_pose(B) @ inverse_pose(A), atol=1e-15
    )


def test_frozen_is_a_read_only_copy():
    values = [1, 2]
    array = frozen(values)
    assert array.dtype == float
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 0.0


def test_runs():
    mask = np.array((1, 1, 0, 1, 0, 0, 1), dtype=bool)
    assert runs_of(mask) == [(0, 2), (3, 4), (6, 7)]
    assert runs_of(~np.ones(3, dtype=bool)) == []


def test_arrays_of_a_value_are_frozen():
    body = SimpleNamespace(mass=[1.0, 2.0], other=None, left=[3.0])
    freeze(body, "mass", "other")
    assert not body.mass.flags.writeable
    assert body.other is None
    assert body.left == [3.0]


def test_values_are_read_between_samples():
    """Of a line they are on the line, and outside the first and the last."""
    time = np.array((0.0, 1.0, 4.0))
    line = np.column_stack((2.0 * time, 1.0 - time))
    found = interpolated(np.array((-1.0, 0.5, 3.0, 9.0)), time, line)
    np.testing.assert_allclose(found, [[0, 1], [1, 0.5], [6, -2], [8, -3]])


def test_angles_between_vectors():
    axis = np.array((0.0, 0.0, 2.0))
    for angle in (0.0, 1e-9, 0.3, 3.0):
        turned = 5.0 * np.array((np.sin(angle), 0.0, np.cos(angle)))
        assert angle_between(axis, turned) == pytest.approx(angle, rel=1e-12)


# moving wrench and motion


def test_power_does_not_depend_on_the_frame(rng):
    """f . v + tau . w is the same about either origin, v moving as a rigid body's
    points do."""
    for _ in range(20):
        pose = random_pose(rng)
        f, tau, v, w = rng.normal(size=(4, 7, 3))
        new_f, new_tau = move_wrench(pose, f, tau)
        R, offset = pose[:3, :3], -pose[:3, 3]
        new_w = w @ R.T
        new_v = v @ R.T + np.cross(new_w, offset)
        power = np.sum(f * v + tau * w, axis=1)
        np.testing.assert_allclose(
            np.sum(new_f * new_v + new_tau * new_w, axis=1), power, atol=ROUNDING
        )


def test_moves_compose_and_invert(rng):
    for _ in range(20):
        A, B = random_pose(rng), random_pose(rng)
        wrench = tuple(rng.normal(size=(2, 7, 3)))
        motion = tuple(rng.normal(size=(3, 7, 3)))
        for move, values in ((move_wrench, wrench), (move_motion, motion)):
            there = move(A, *values)
            for found, expected in zip(
                move(B, *there), move(B @ A, *values), strict=True
            ):
                np.testing.assert_allclose(found, expected, atol=ROUNDING)
            for found, expected in zip(
                move(inverse_pose(A), *there), values, strict=True
            ):
                np.testing.assert_allclose(found, expected, atol=ROUNDING)


def test_motion_of_another_point_is_the_second_derivative_of_its_path():
    """A body turning about a moving axis: acceleration of an offset point by central
    differences in world axes."""
    offset = np.array((0.3, -0.2, 0.5))
    pose = np.eye(4)
    # the new frame's origin lies at `offset` of the old one, with the same axes
    pose[:3, 3] = -offset
    rate = np.array((0.4, -1.1, 0.7))

    def turn(t):
        return Rotation.from_rotvec(rate * np.sin(t))

    def origin(t):
        return np.array((np.sin(2 * t), np.cos(t), t * t))

    t, h = 0.3, 1e-4
    R = turn(t).as_matrix()
    # about a fixed axis, so the same in body axes
    w, alpha = rate * np.cos(t), -rate * np.sin(t)
    a = R.T @ np.array((-4 * np.sin(2 * t), -np.cos(t), 2.0))
    path = [origin(t + k * h) + turn(t + k * h).apply(offset) for k in (-1, 0, 1)]
    expected = R.T @ (path[0] - 2 * path[1] + path[2]) / h**2
    # differences: truncation h², rounding 1e-16/h²
    np.testing.assert_allclose(move_motion(pose, a, w, alpha)[0], expected, atol=1e-6)


def test_the_wrench_law_holds_in_every_frame(rng):
    """Measurements and body moved together: the wrench predicted there is the wrench
    moved there."""
    for _ in range(20):
        body, pose = random_body(rng), random_pose(rng)
        z = with_wrench(random_motion(rng, 10), body)
        there = z.moved(pose)
        np.testing.assert_allclose(
            predict_wrench(there, body.moved(pose).vector),
            there.wrench,
            atol=10 * ROUNDING,
        )
        back = there.moved(inverse_pose(pose))
        for name in (
            "gravity",
            "linear_acceleration",
            "angular_velocity",
            "angular_acceleration",
            "force",
            "torque",
        ):
            np.testing.assert_allclose(
                getattr(back, name), getattr(z, name), atol=10 * ROUNDING
            )


@pytest.mark.parametrize("degrees", [0.0, 1e-6, 1.0, 90.0, 179.9999, 180.0])
def test_rotations_agree_with_those_of_scipy(degrees):
    """Of no turn and half a turn too, where many formulas lose digits."""
    rng = np.random.default_rng(4)
    for axis in (*np.eye(3), *-np.eye(3), *rng.normal(size=(20, 3))):
        vector = np.radians(degrees) * axis / np.linalg.norm(axis)
        turn = Rotation.from_rotvec(vector)
        np.testing.assert_allclose(rotation_by(vector), turn.as_matrix(), atol=1e-15)
        q = quaternion_of(turn.as_matrix())
        assert q[3] >= 0.0
        # either sign is the same rotation; an entry near zero has lost some digits
        assert abs(q @ turn.as_quat()) == pytest.approx(1.0, abs=1e-15)
        there = rotation_by(rotation_vector(turn.as_matrix()))
        np.testing.assert_allclose(there, turn.as_matrix(), atol=1e-14)


@pytest.mark.parametrize("width", [1, 3])
def test_rows_that_differ_from_the_one_before(width):
    """Rows of few values, so that first columns are often equal and rows sometimes."""
    rows = np.random.default_rng(5).integers(0, 2, (200, width)).astype(float)
    alike = [k > 0 and tuple(rows[k]) == tuple(rows[k - 1]) for k in range(len(rows))]
    assert 0 < sum(alike) < len(rows)
    assert changed_rows(rows).tolist() == [not same for same in alike]

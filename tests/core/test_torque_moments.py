"""Moments of joint torques against dense weighted least squares of all unknowns."""

from time import perf_counter

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.torque_moments import TorqueMoments, merged, pseudo_inverse_half
from torque_rows import folded, payload

OWN, JOINTS = 4, 7
STD = np.array((0.1, 0.12, 0.08, 0.1, 0.05, 0.05, 0.04))


def random_rows(rng, samples: int, arm: int) -> tuple[np.ndarray, np.ndarray]:
    rows = rng.standard_normal((samples, JOINTS, OWN + arm + 11))
    rows[:, :, 0] = 1.0
    return rows, np.arange(samples) / 100.0


def dense(rows: np.ndarray, used: np.ndarray, arm: int) -> np.ndarray:
    """(10,) payload by dense weighted least squares over every unknown."""
    stacked = []
    for j in range(JOINTS):
        own = rows[used[:, j], j] / STD[j]
        whole = np.zeros((len(own), JOINTS * OWN + arm + 11))
        whole[:, j * OWN : (j + 1) * OWN] = own[:, :OWN]
        whole[:, JOINTS * OWN :] = own[:, OWN:]
        stacked.append(whole)
    A = np.concatenate(stacked)
    return np.linalg.lstsq(A[:, :-1], A[:, -1], rcond=None)[0][-10:]


def solved(factor: np.ndarray) -> np.ndarray:
    return np.linalg.solve(factor[:10, :10], factor[:10, 10])


@pytest.mark.parametrize("arm", [0, 6])
def test_equal_dense_weighted_least_squares(arm):
    rng = np.random.default_rng(1)
    rows, time = random_rows(rng, 900, arm)
    used = rng.random((900, JOINTS)) < 0.8
    want = dense(rows, used, arm)
    empty = TorqueMoments.empty(JOINTS, OWN, arm)
    whole = folded(empty, rows, time, used)
    # rounding: 1e-16 times some hundred operations on well conditioned numbers
    np.testing.assert_allclose(solved(payload(whole, STD)), want, rtol=0, atol=1e-12)
    parts = np.split(np.arange(900), (1, 350, 620))
    several = [folded(empty, rows[i], time[i], used[i]) for i in parts]
    for order in ([0, 1, 2, 3], [3, 1, 0, 2]):
        joined = merged([several[i] for i in order])
        np.testing.assert_allclose(
            solved(payload(joined, STD)), want, rtol=0, atol=1e-12
        )
        assert joined.samples == 900
        assert joined.duration == pytest.approx(8.99)
        np.testing.assert_array_equal(joined.counts, used.sum(axis=0))


def test_an_empty_run_frees_the_arm():
    """Payload columns that the arm's columns explain as well are found once an empty
    run without them is merged: that is what it is for."""
    rng = np.random.default_rng(2)
    arm = 10
    loaded, time = random_rows(rng, 400, arm)
    loaded[:, :, -11:-1] = loaded[:, :, OWN : OWN + 10]  # the last link's
    bare, _ = random_rows(rng, 300, arm)
    bare[:, :, -11:-1] = 0.0
    used = np.ones((700, JOINTS), dtype=bool)
    empty = TorqueMoments.empty(JOINTS, OWN, arm)
    alone = payload(folded(empty, loaded, time), STD)
    assert np.abs(alone[:10, :10]).max() < 1e-10
    both = folded(empty, loaded, time).merge(folded(empty, bare, time[:300]))
    want = dense(np.concatenate((loaded, bare)), used, arm)
    # as above
    np.testing.assert_allclose(solved(payload(both, STD)), want, rtol=0, atol=1e-12)


def test_nuisances_that_nothing_tells_take_nothing_away():
    """A column of zeros, and one that repeats another, leave the same equations as
    without them."""
    rng = np.random.default_rng(3)
    rows, time = random_rows(rng, 300, 0)
    want = payload(folded(TorqueMoments.empty(JOINTS, OWN), rows, time), STD)
    more = np.insert(rows, 1, 0.0, axis=2)
    more = np.insert(more, 2, more[:, :, 0], axis=2)
    found = payload(folded(TorqueMoments.empty(JOINTS, OWN + 2), more, time), STD)
    # signs of rows are free: their squares are not
    np.testing.assert_allclose(found.T @ found, want.T @ want, rtol=1e-10)


def test_noise_is_chosen_after_the_samples_are_gone():
    rng = np.random.default_rng(4)
    rows, time = random_rows(rng, 300, 6)
    moments = folded(TorqueMoments.empty(JOINTS, OWN, 6), rows, time)
    want = folded(TorqueMoments.empty(JOINTS, OWN, 6), rows / STD[:, None], time)
    for found in (payload(moments, STD), payload(moments.weighed(STD))):
        np.testing.assert_allclose(
            solved(found), solved(payload(want)), rtol=0, atol=1e-12
        )


def test_shapes_are_checked():
    moments = TorqueMoments.empty(JOINTS, OWN)
    with pytest.raises(InputError, match="do not merge"):
        moments.merge(TorqueMoments.empty(6, OWN))
    for std in (0.0, -1.0, np.nan, np.append(np.ones(JOINTS - 1), np.inf)):
        with pytest.raises(InputError, match="positive and finite"):
            payload(moments, std)
    with pytest.raises(InputError, match="joints"):
        TorqueMoments(np.zeros((2, 5, 5)), 1, np.zeros(2))


def test_solving_costs_the_same_however_many_samples():
    """Of a long and a short recording, least times of several: no absolute time."""
    rng = np.random.default_rng(5)
    times = []
    for samples in (500, 4000):
        rows, time = random_rows(rng, samples, 50)
        moments = folded(TorqueMoments.empty(JOINTS, OWN, 50), rows, time)
        least = np.inf
        for _ in range(20):
            begin = perf_counter()
            payload(moments.weighed(STD))
            least = min(least, perf_counter() - begin)
        times.append(least)
    print(times)
    # the same work on the same sizes, on a machine that others use
    assert times[1] < 3.0 * times[0]


def test_a_column_of_rounding_size_is_no_unknown():
    """Of joints that stand, parameters have columns of rounding: scaled to the length of
    the others they were unknowns of 1e10, and a joint's noise was 1e5 times too large."""
    A = np.random.default_rng(4).normal(size=(50, 4)) * np.array((1e3, 1.0, 1e-2, 1e-9))
    half = pseudo_inverse_half(A)
    assert not half[3].any()
    np.testing.assert_allclose(
        (half @ half.T)[:3, :3], np.linalg.inv(A[:, :3].T @ A[:, :3]), rtol=1e-9
    )


@pytest.mark.parametrize("apart", [1.0, 1e-8, 1e-11])
def test_half_of_the_inverse_of_columns_that_are_alike(apart):
    """As by singular values, of which the third has one that leaves a direction open."""
    A = np.random.default_rng(5).normal(size=(2, 50, 4))
    A[1, :, 3] = A[1, :, 2] + apart * A[1, :, 3]
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    half, inverse = pseudo_inverse_half(A), np.linalg.pinv(A, rcond=1e-9)
    want = inverse @ np.swapaxes(inverse, 1, 2)
    np.testing.assert_allclose(
        half @ np.swapaxes(half, 1, 2), want, atol=1e-6 * want.max()
    )

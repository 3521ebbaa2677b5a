"""Joint fits of bodies beside a drifting bias: against least squares of all rows at
once, and closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from changing_cells import random_cells
from hefting.ingest.changes.bodies import (
    LARGEST_LAG,
    JointModel,
    autocorrelation,
    bias_columns,
    drift_degrees,
    lag_column,
    log_ratio,
    variance_of_any_linear_function,
)


def lasting(seconds: float):
    """Cells of such a recording."""
    cells = random_cells(np.random.default_rng(0), 20)
    time = np.linspace(0.0, seconds, 20)
    return replace(cells, time=np.sort(np.append(time[:-2], (seconds - 5.0, seconds))))


def test_the_bias_has_a_degree_more_each_24_s_up_to_twelve():
    """Twice the distance between the closest knots of a drift."""
    for more in range(1, 11):
        at = 24.0 * more
        fewer, number = drift_degrees(lasting(at - 0.01)), drift_degrees(lasting(at))
        assert (fewer, number) == (min(3 + more, 12), min(4 + more, 12))
    assert drift_degrees(lasting(6.0)) == 4


def test_columns_of_the_bias_are_polynomials_of_each_channel_over_the_recording():
    """Orthogonal over all times, +-1 at both ends; of any clock and unit of time."""
    cells = replace(
        random_cells(np.random.default_rng(0), 2001), scale=np.array((2.0, 0.5))
    )
    columns = bias_columns(cells, 4).reshape(2001, 6, 6, 4)
    unit = np.repeat((2.0, 0.5), 3)
    for c in range(6):
        own = columns[:, c, c] * unit[c]
        np.testing.assert_allclose(own[-1], 1.0, atol=1e-12)
        np.testing.assert_allclose(own[0], (1.0, -1.0, 1.0, -1.0), atol=1e-12)
        # a sum in place of an integral: to one over the number of cells
        gram = own.T @ own / len(own)
        np.testing.assert_allclose(gram, np.diag(1 / np.arange(1, 8, 2)), atol=2e-3)
        columns[:, c, c] = 0.0
    assert not columns.any()
    other = replace(cells, time=7.0 + 3.0 * cells.time)
    np.testing.assert_allclose(
        bias_columns(other, 4), bias_columns(cells, 4), atol=1e-12
    )
    assert bias_columns(cells, 0).shape == (2001, 6, 0)


def test_a_joint_fit_is_least_squares_of_all_rows_and_the_prior():
    """Two bodies in three of four intervals, one bias that drifts."""
    cells = random_cells(np.random.default_rng(5), 80, change=40)
    cells = replace(cells, scale=np.array((1.0, 2.0)))
    intervals = [(0, 20), (20, 40), (40, 55), (55, 80)]
    found = JointModel(cells, intervals, drift=2).fit([3, -1, 7, 3])
    columns = np.zeros((80, 6, 33))
    columns[40:55, :, 10:20] = cells.regressor[40:55]
    for part in (slice(0, 20), slice(55, 80)):
        columns[part, :, :10] = cells.regressor[part]
    columns[:, :, 20:32] = bias_columns(cells, 2)
    columns[:, :, 32:] = lag_column(cells, intervals)
    of_body = [1.0 / 30.0] + [1.0 / 5.0] * 3 + [1.0 / 2.0] * 6
    of_bias = [*[1 / 50.0] * 6, *[1 / 5.0] * 6]
    prior = np.diag([*of_body, *of_body, *of_bias, 1 / LARGEST_LAG])
    used = np.r_[0:20, 40:80]
    A = np.vstack((columns[used].reshape(-1, 33), prior))
    b = np.append(cells.whitened[used].ravel(), np.zeros(33))
    solution = np.linalg.lstsq(A, b)[0]
    C = np.linalg.inv(A.T @ A)
    np.testing.assert_allclose(found.bodies.ravel(), solution[:20], atol=1e-7)
    np.testing.assert_allclose(found.covariance, C[:20, :20], rtol=1e-5, atol=1e-12)
    left = cells.whitened - columns @ solution
    np.testing.assert_allclose(
        JointModel(cells, intervals, drift=2).residuals(found), left[used], atol=1e-6
    )
    leverage = np.einsum("kci,ij,kcj->kc", columns, C, columns).sum(axis=1)
    square = np.square(left).reshape(-1, 2, 3).sum(axis=2)
    for i, (begin, end) in enumerate(intervals):
        if i == 1:
            assert found.combinations[i] is None
            assert not found.squares[i].any()
            assert found.equations[i] == 0.0
            continue
        part = slice(begin, end)
        np.testing.assert_allclose(found.squares[i], square[part].sum(0), rtol=1e-6)
        # of force and torque together, half each
        free = 3.0 * (end - begin) - 0.5 * leverage[part].sum()
        assert found.equations[i] == pytest.approx(free, rel=1e-6)
    total = found.squares.sum(axis=0) / found.equations.sum()
    np.testing.assert_allclose(found.variance, total)
    apart, covariance = found.difference(0, 1)
    np.testing.assert_allclose(apart, solution[10:20] - solution[:10], atol=1e-7)
    D = np.hstack((-np.eye(10), np.eye(10)))
    np.testing.assert_allclose(covariance, D @ C[:20, :20] @ D.T, rtol=1e-4, atol=1e-12)


def test_the_ratio_of_likelihoods_counts_no_residual_below_the_noise():
    cells = random_cells(np.random.default_rng(6), 60, change=30)
    model = JointModel(cells, [(0, 30), (30, 60)], drift=1)
    one, two = model.fit([0, 0]), model.fit([0, 1])
    assert (one.variance > 1.5).all()

    def scaled(fit, force, torque):
        squares = np.array((force, torque)) * fit.equations[:, None]
        return replace(fit, squares=squares)

    count = two.equations.sum()
    ratio = log_ratio(scaled(one, 6.0, 3.0), scaled(two, 2.0, 0.1))
    # 3 of force, 3 of torque
    assert ratio == pytest.approx(2.0 * count * np.log(3.0))
    assert log_ratio(scaled(one, 0.3, 0.5), scaled(two, 0.1, 0.2)) == 0.0


def test_autocorrelation_is_that_of_noise_of_first_order():
    """(1 + r) / (1 - r), r the correlation of neighbours of all channels: one to
    twenty."""
    lag = np.array([[1.0, 2.0], [1.0, -2.0], [1.0, -2.0]])
    assert autocorrelation(lag) == pytest.approx((15.0 + 2.0) / (15.0 - 2.0))
    assert autocorrelation(np.array([[1.0], [1.0], [0.0]])) == pytest.approx(3.0)
    assert autocorrelation(np.array([[1.0], [-1.0], [1.0]])) == 1.0
    assert autocorrelation(np.zeros((5, 6))) == 1.0
    # r = (n - 1) / n of n ones: 2 n - 1
    assert autocorrelation(np.ones((10, 6))) == pytest.approx(19.0)
    assert autocorrelation(np.ones((11, 6))) == 20.0


def test_any_linear_function_leaves_what_is_none():
    """Of features, axes and a drift of the bias, by twelve, nine and four columns of 200
    rows; against `lstsq`."""
    rng = np.random.default_rng(7)
    cells = replace(random_cells(rng, 200), axes=rng.normal(size=(200, 9)))
    time = np.linspace(-1.0, 1.0, 200)
    functions = np.hstack((cells.features, cells.axes, np.vander(time, 4)))
    linear = functions @ rng.normal(size=(25, 6))
    nothing = variance_of_any_linear_function(replace(cells, wrench=linear))
    np.testing.assert_allclose(nothing, 0.0, atol=1e-20)
    noise = rng.normal(size=(200, 6)) * np.repeat((1.0, 3.0), 3)
    left = noise - functions @ np.linalg.lstsq(functions, noise)[0]
    square = np.square(left).reshape(-1, 2, 3).sum(axis=(0, 2))
    found = variance_of_any_linear_function(replace(cells, wrench=linear + noise))
    np.testing.assert_allclose(found, square / (3.0 * (200 - 25)), rtol=1e-6)
    # the same column twice takes nothing more
    twice = replace(cells, wrench=linear + noise, axes=cells.features[:, :9])
    functions = np.hstack((cells.features, np.vander(time, 4)))
    left = twice.wrench - functions @ np.linalg.lstsq(functions, twice.wrench)[0]
    square = np.square(left).reshape(-1, 2, 3).sum(axis=(0, 2))
    found = variance_of_any_linear_function(twice)
    np.testing.assert_allclose(found, square / (3.0 * (200 - 16)), rtol=1e-6)


def test_a_wrench_that_is_late_is_explained_as_one_that_is_not():
    """By up to 0.03 s, as the fit of one body to two does not find the clock offset."""
    cells = random_cells(np.random.default_rng(8), 200, change=100)
    late = cells.wrench.copy()
    for part in (slice(0, 100), slice(100, 200)):
        rate = np.gradient(cells.wrench[part], cells.time[part], axis=0)
        late[part] -= 0.03 * rate
    intervals = [(0, 100), (100, 200)]
    assert np.std(late - cells.wrench) > 3.0
    for wrench in (cells.wrench, late):
        fit = JointModel(replace(cells, wrench=wrench), intervals, drift=1).fit([0, 1])
        assert fit.variance.max() < 1.5, fit.variance

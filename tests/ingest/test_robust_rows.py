"""Robust rows: against dense least squares, and a Student t distribution fitted by
SciPy."""

import numpy as np
import pytest
from scipy.stats import multivariate_t

from hefting.ingest.fit import STUDENT_DEGREES_OF_FREEDOM
from hefting.ingest.robust_rows import (
    ALTERNATIVES_AT_A_TIME,
    fit_each,
    normal_equations,
    scaled_to_ones,
    solve_each,
)

ALTERNATIVES = 2 * ALTERNATIVES_AT_A_TIME + 3
"""More than are computed at a time, and no multiple of it."""
SAMPLES, KNOWN, UNKNOWNS = 40, 5, 4
FLOOR = np.array((1e-6, 1e-6))


@pytest.fixture
def problem():
    """Known rows with the wrench behind them, maps, weights, scales, and the dense
    design matrices (O, 6 K, p)."""
    rng = np.random.default_rng(3)
    both = rng.normal(size=(ALTERNATIVES, SAMPLES, KNOWN + 6))
    maps = rng.normal(size=(KNOWN, 6, UNKNOWNS))
    maps[:, 1, 2:] = 0.0  # a channel that does not depend on all unknowns
    weights = rng.uniform(0.1, 2.0, size=(ALTERNATIVES, SAMPLES))
    scale = rng.uniform(0.3, 3.0, size=(ALTERNATIVES, 2))
    design = np.einsum("okz,zcp->okcp", both[:, :, :KNOWN], maps)
    return both, maps, weights, scale, design


def test_normal_equations_are_those_of_the_dense_design_matrix(problem):
    both, maps, weights, scale, design = problem
    normal, right = normal_equations(both, maps, weights, scale)
    for o in range(ALTERNATIVES):
        A = design[o].reshape(-1, UNKNOWNS)
        w = (weights[o, :, None] / np.repeat(scale[o], 3) ** 2).ravel()
        np.testing.assert_allclose(normal[o], A.T @ (w[:, None] * A), rtol=1e-10)
        wrench = both[o, :, KNOWN:].ravel()
        np.testing.assert_allclose(right[o], A.T @ (w * wrench), rtol=1e-9, atol=1e-9)


def test_solutions_are_those_of_dense_least_squares(problem):
    """To what the damping changes, 1e-9 of the diagonal."""
    both, maps, weights, scale, design = problem
    found = solve_each(*normal_equations(both, maps, weights, scale))
    for o in (0, ALTERNATIVES_AT_A_TIME, ALTERNATIVES - 1):
        root = np.sqrt(weights[o, :, None]) / np.repeat(scale[o], 3)
        A = (design[o] * root[:, :, None]).reshape(-1, UNKNOWNS)
        b = (both[o, :, KNOWN:] * root).ravel()
        expected = np.linalg.lstsq(A, b, rcond=None)[0]
        np.testing.assert_allclose(found[o], expected, rtol=1e-6)


def test_unknowns_that_nothing_depends_on_are_zero():
    normal, right = np.diag((4.0, 0.0))[None], np.array([[2.0, 0.0]])
    scaled, length = scaled_to_ones(normal)
    np.testing.assert_allclose(length, [[2.0, 1.0]])
    np.testing.assert_allclose(scaled, [np.diag((1.0, 0.0))], atol=1e-8)
    np.testing.assert_allclose(solve_each(normal, right), [[0.5, 0.0]], atol=1e-8)


def noisy(outliers: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One alternative of 400 samples with noise of 0.3 N and 0.02 N m, some of them
    pushed; its maps, and the truth."""
    rng = np.random.default_rng(4)
    known, maps = rng.normal(size=(1, 400, KNOWN)), rng.normal(size=(KNOWN, 6, 4))
    truth = np.array((1.0, -0.5, 0.2, 2.0))
    wrench = known @ (maps @ truth)
    wrench += rng.normal(size=wrench.shape) * np.repeat((0.3, 0.02), 3)
    wrench[:, :outliers] += 30.0
    return np.concatenate((known, wrench), axis=2), maps, truth


@pytest.mark.parametrize("outliers", [0, 60])
def test_outliers_count_little(outliers):
    """Least squares would be wrong by some 30 N 60 / 400 of what one N changes."""
    both, maps, truth = noisy(outliers)
    fits = fit_each(both, maps, np.ones((1, 400)), FLOOR, 6)
    # ten standard deviations of what the torques' noise leaves over 400 samples
    np.testing.assert_allclose(fits.solution[0], truth, atol=0.01)
    pushed, others = fits.weights[0, :outliers], fits.weights[0, outliers:]
    assert pushed.max(initial=0.0) < 0.01 * others.min()
    residual = both[0, :, KNOWN:] - both[0, :, :KNOWN] @ (maps @ fits.solution[0])
    np.testing.assert_allclose(fits.residual[0], residual, atol=1e-12)


def test_the_likelihood_is_that_of_a_student_distribution():
    """By SciPy, less its constant."""
    both, maps, _ = noisy(0)
    fits = fit_each(both, maps, np.ones((1, 400)), FLOOR, 6)
    shape = np.diag(np.repeat(fits.scale[0] ** 2, 3))
    exact = multivariate_t.logpdf(
        fits.residual[0], shape=shape, df=STUDENT_DEGREES_OF_FREEDOM
    )
    constant = multivariate_t.logpdf(
        np.zeros(6), shape=np.eye(6), df=STUDENT_DEGREES_OF_FREEDOM
    )
    assert fits.likelihood[0] == pytest.approx(exact.mean() - constant, rel=1e-9)


def test_samples_that_are_not_used_change_nothing():
    """And where fewer than half are used there is no likelihood."""
    both, maps, _ = noisy(0)
    used = np.ones((1, 400))
    used[0, 150:] = 0.0
    assert fit_each(both, maps, used, FLOOR, 6).likelihood[0] == -np.inf
    used[0, 150:210] = 1.0
    fits = fit_each(both, maps, used, FLOOR, 12)
    both[:, 210:, KNOWN:] += 100.0
    again = fit_each(both, maps, used, FLOOR, 12)
    assert np.isfinite(fits.likelihood[0])
    # the first weights are of all: convergence to a thousandth of the deviation
    np.testing.assert_allclose(again.solution, fits.solution, atol=1e-5)


def test_scales_do_not_fall_below_the_floor():
    both, maps, _ = noisy(0)
    floor = np.array((0.5, 0.01))
    fits = fit_each(both, maps, np.ones((1, 400)), floor, 6)
    assert fits.scale[0, 0] == 0.5
    assert fits.scale[0, 1] == pytest.approx(0.02, rel=0.2)

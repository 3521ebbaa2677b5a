"""PMD against the paper's own formulation, uncompressed, through CVXPY and the conic
solver Clarabel."""

import cvxpy as cp
import numpy as np

from benchmarks.problem import shape, wielded
from benchmarks.report import Row, Section, faster
from benchmarks.timing import Party, compare
from hefting import PMD
from hefting.core.measurements import Measurements
from hefting.core.regressor import full_model_weight, full_regressor, reduced_regressor
from hefting.core.spatial import Array

TARGETS = {150: (300.0, 150.0), 3500: (5000.0, 2000.0)}
"""By the number of samples: how many times faster from the moments, and with the
samples folded in."""


def paper_matrices(
    pmd: PMD, measurements: Measurements
) -> tuple[Array, Array, Array, Array]:
    """D(1-w) Ã M and D(w) A M (6 K, n), D(1-w) b and D(w) b (6 K,) (Nadeau et al. 2022,
    problem 1)."""
    w = full_model_weight(measurements, pmd.c1)[:, None, None]
    b = measurements.wrench[:, :, None]
    M = pmd.shape.matrix
    A0 = (1.0 - w) * (reduced_regressor(measurements) @ M)
    A1 = w * (full_regressor(measurements) @ M)
    return (
        A0.reshape(-1, M.shape[1]),
        ((1.0 - w) * b).ravel(),
        A1.reshape(-1, M.shape[1]),
        (w * b).ravel(),
    )


def paper_solution(
    matrices: tuple[Array, Array, Array, Array], regularization: float
) -> tuple[float, float]:
    """State the problem and solve it: the optimum, and the time [s] that Clarabel
    itself reports."""
    A0, b0, A1, b1 = matrices
    masses = cp.Variable(A0.shape[1], nonneg=True)
    norms = (
        cp.norm(A0 @ masses - b0)
        + cp.norm(A1 @ masses - b1)
        + regularization * cp.norm(masses)
    )
    problem = cp.Problem(cp.Minimize(norms))
    problem.solve(solver=cp.CLARABEL)
    return float(problem.value), float(problem.solver_stats.solve_time)


def against_conic_solver(samples: int, rounds: int) -> Section:
    """Both parties on the same samples; the paper's matrices are given to the conic
    solver ready-made."""
    measurements = wielded(3500)[:samples]
    pmd = PMD(shape(56), intervals=False)
    matrices = paper_matrices(pmd, measurements)
    times = compare(
        {
            "conic": Party(lambda _: paper_solution(matrices, pmd.regularization)),
            "estimate": Party(
                pmd.estimate, lambda: pmd.update(pmd.start(), measurements), calls=20
            ),
            "fit": Party(lambda _: pmd.fit(measurements), calls=20),
        },
        rounds,
    )
    conic, estimate, fit = times["conic"], times["estimate"], times["fit"]
    optimum = conic.results[-1][0]
    solver = float(np.median([time for _, time in conic.results]))
    certificate = estimate.results[-1].certificate
    from_moments, with_folding = TARGETS.get(samples, (None, None))
    return Section(
        f"PMD, {pmd.shape.n} points, {samples:,} samples",
        (
            Row("the paper's formulation: CVXPY and Clarabel", conic),
            Row("  of which Clarabel itself, without CVXPY", figure=solver, unit="s"),
            faster("Hefting, from the moments", estimate, conic, from_moments),
            Row("  against Clarabel itself", figure=solver / estimate.median, unit="x"),
            faster("Hefting, folding the samples included", fit, conic, with_folding),
            Row("  against Clarabel itself", figure=solver / fit.median, unit="x"),
            Row("objective: the paper's formulation", figure=optimum, unit="N"),
            Row("objective: Hefting", figure=certificate.objective, unit="N"),
            Row(
                "  relative difference",
                figure=certificate.objective / optimum - 1.0,
                at_most=1e-6,
            ),
        ),
    )

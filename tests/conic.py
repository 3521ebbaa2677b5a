"""Independent oracle for PMD: the paper's formulation, uncompressed, through a general
conic solver."""

from dataclasses import dataclass

import clarabel
import numpy as np
from scipy import sparse


@dataclass(frozen=True)
class Problem:
    """|D(1-w)(A0 M m + beta - b)| + |D(w)(A1 M m + beta - b)| + lambda |m| over m >= 0
    and, if free, beta (6,)."""

    A0: np.ndarray
    """(K, 6, 10) reduced regressors"""
    A1: np.ndarray
    """(K, 6, 10) full regressors"""
    b: np.ndarray
    """(K, 6) wrenches"""
    w: np.ndarray
    """(K,) weight of the full model"""
    M: np.ndarray
    """(10, n)"""
    regularization: float
    free_bias: bool

    def objective(self, masses: np.ndarray, bias: np.ndarray | float) -> float:
        """Value at masses (n,) and bias (6,), sample by sample."""
        vector = self.M @ masses
        norms = [
            np.linalg.norm(weight[:, None] * (A @ vector + bias - self.b))
            for weight, A in ((1 - self.w, self.A0), (self.w, self.A1))
        ]
        return float(sum(norms) + self.regularization * np.linalg.norm(masses))

    @property
    def size(self) -> float:
        """|b| of both models together."""
        return float(
            np.sqrt(np.sum(((1 - self.w) ** 2 + self.w**2)[:, None] * self.b**2))
        )


@dataclass(frozen=True)
class Optimum:
    """What the conic solver found."""

    upper: float
    """objective, computed anew at its masses (negative ones set to zero) and bias: no
    optimum is above it"""
    dual: float
    """dual value as reported"""
    masses: np.ndarray
    solved: bool
    """whether it reached its own tolerance"""


def solve(problem: Problem) -> Optimum:
    """Solve by Clarabel, which sees every sample.

    Variables are the masses in units of one typical mass (equal masses of it make a
    wrench as large as the measured one), the bias in units that give its columns length
    one, and one bound for each norm, the data being divided by |b|: so all are of the
    order of one.
    """
    K, n = len(problem.b), problem.M.shape[1]
    weights = (1 - problem.w, problem.w)
    rows = [
        (u[:, None, None] * (A @ problem.M)).reshape(-1, n)
        for u, A in zip(weights, (problem.A0, problem.A1), strict=True)
    ]
    right = [(u[:, None] * problem.b).ravel() for u in weights]
    size = problem.size or 1.0
    mass = size / (
        np.hypot(*(np.linalg.norm(part.sum(axis=1)) for part in rows)) or 1.0
    )
    columns = (
        [np.kron(u[:, None], np.eye(6)) for u in weights]
        if problem.free_bias
        else [np.zeros((6 * K, 0))] * 2
    )
    bias = size / np.sqrt(sum(u @ u for u in weights))
    parts = [
        (np.hstack((R * mass, C * bias)) / size, b / size)
        for R, C, b in zip(rows, columns, right, strict=True)
    ]
    if problem.regularization > 0.0:
        pull = np.zeros((n, n + columns[0].shape[1]))
        pull[:, :n] = np.eye(n) * (problem.regularization * mass / size)
        parts.append((pull, np.zeros(n)))
    free = parts[0][0].shape[1]
    N = free + len(parts)
    blocks = [np.hstack((-np.eye(n), np.zeros((n, N - n))))]
    offsets = [np.zeros(n)]
    cones = [clarabel.NonnegativeConeT(n)]
    for index, (left, b) in enumerate(parts):
        block = np.zeros((len(left) + 1, N))
        block[0, free + index] = -1.0
        block[1:, :free] = -left
        blocks.append(block)
        offsets.append(np.concatenate(([0.0], -b)))
        cones.append(clarabel.SecondOrderConeT(len(left) + 1))
    cost = np.concatenate((np.zeros(free), np.ones(len(parts))))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-8
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix((N, N)),
        cost,
        sparse.csc_matrix(np.vstack(blocks)),
        np.concatenate(offsets),
        cones,
        settings,
    ).solve()
    x = np.array(solution.x)
    masses = mass * np.maximum(x[:n], 0.0)
    beta = bias * x[n:free] if problem.free_bias else 0.0
    return Optimum(
        problem.objective(masses, beta),
        size * solution.obj_val_dual,
        masses,
        str(solution.status) == "Solved",
    )

"""The convex problem of PMD, solved in the space of its dual.

    minimise   |A0 M m + B0 beta - b0| + |A1 M m + B1 beta - b1| + lambda |m|    over m >= 0 (n,) and beta

with Euclidean norms that are not squared (Nadeau et al. 2022, problem 1). Each norm has the tight quadratic bound
sqrt(q) <= q / (2 s) + s / 2. For given scales s the bounded problem has the dual

    maximise   -b'v - 1/2 v'(s0 K0 + s1 K1) v - 1/2 sigma |t|²,   t = max(-M'A'v, 0),  sigma = s2 / lambda

in as many unknowns as the factored data has rows (16; with bias 22), whatever the number of points; the masses
are m = sigma t. A semismooth Newton method solves it. The scales are the multipliers of the constraints
v'K0 v <= 1, v'K1 v <= 1 and |t| <= lambda of the original problem's dual; Newton's method on their logarithms finds
them, in two or three steps on ordinary data. Where a norm vanishes (noise-free data) its scale falls to a floor.
Any v, scaled to satisfy the three constraints, certifies the lower bound -b'v.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from hefting.errors import HeftingError
from hefting.spatial import Array

FLOOR = 1e-7
"""Smallest scale of a norm that vanishes, relative to the objective: costs half of it in accuracy."""
TOLERANCE = 1e-7
"""Gap at which to stop, relative to the objective (or to 1e-6 |b|, where the objective is smaller)."""
MAX_STEPS = 100


@dataclass(frozen=True)
class ConeProblem:
    """One instance, without its bias columns (see `hefting.estimators.pmd.compress`)."""

    A: Array
    """(r, p) rows of both norms; a row that the free bias couples belongs to both in part."""
    b: Array
    """(r,) right-hand side"""
    k0: Array
    """(r,) share of each row in the first norm: diagonal of K0"""
    k1: Array
    """(r,) share of each row in the second norm: diagonal of K1"""
    M: Array
    """(p, n) of the points, with orthonormal rows"""
    regularization: float
    """lambda >= 0"""
    size: float
    """|b| before the bias was taken out: what counts as zero is judged against it"""


@dataclass(frozen=True)
class ConeSolution:
    """What `solve` found."""

    masses: Array
    """(n,) >= 0"""
    dual: Array
    """(r,) v, scaled to be feasible"""
    scales: Array
    """(2,) the two residual norms, or the floor where they vanish"""
    bound: float
    """lower bound on the optimum"""
    iterations: int
    """linear systems solved"""


def solve(problem: ConeProblem, start: Array) -> ConeSolution:
    """Solve from any non-negative, non-zero masses `start` (n,); a good start saves steps, none is needed."""
    A, b, k0, k1 = problem.A, problem.b, problem.k0, problem.k1
    lam, size = problem.regularization, problem.size
    if float(np.abs(b).max()) <= 1e-15 * size:  # no wrench, or none that a bias does not explain: nothing is held
        zero = np.zeros(len(b))
        return ConeSolution(np.zeros(problem.M.shape[1]), zero, np.ones(2), 0.0, 0)
    K = np.vstack((k0, k1))
    r = A @ (problem.M @ start) - b
    logs = 0.5 * np.log(np.maximum(K @ (r * r), (1e-3 * size) ** 2))
    if lam > 0.0:
        logs = np.append(logs, 0.5 * np.log(start @ start) + np.log(lam))
    v = r / (np.exp(logs[:2]) @ K)
    inner = _newton if lam > 0.0 else _active_set

    total, lowest, last_logs, last_step = 0, np.inf, logs, np.zeros_like(logs)
    while True:
        s = np.exp(logs)
        d = s[:2] @ K
        v, masses, norms, W, JW, count = inner(problem, v, d, s)
        total += count
        primal = float(s @ norms)
        feasible = v / max(1.0, *norms) if lam > 0.0 else _shifted(problem, v)
        bound = max(0.0, -float(b @ feasible))
        upper = -float(b @ v) - 0.5 * float(s @ (norms * norms - 1.0))  # the bounded problem's optimum
        scale = max(primal, 1e-6 * size)
        if primal - bound <= TOLERANCE * scale or total >= MAX_STEPS:
            break
        log_norms = np.log(np.maximum(norms, 1e-30))
        floor = np.log(FLOOR * scale)
        if upper > lowest * (1.0 + 1e-12):  # Newton overshot; the fixed-point step never does
            logs, lowest = np.maximum(last_logs + last_step, floor), np.inf
            continue
        lowest, last_logs, last_step = upper, logs, np.clip(log_norms, -3.0, 3.0)
        P = (W.T @ JW) * s / np.maximum(norms * norms, 1e-60)[:, None]
        P.flat[:: len(s) + 1] += 1e-9
        for i in np.flatnonzero((logs <= floor + 1e-6) & (log_norms < 0.0)):  # a vanished norm stays where it is
            P[i], P[i, i], log_norms[i] = 0.0, 1.0, 0.0
        step = lapack.dgesv(P, log_norms)[2]
        logs = np.maximum(logs + np.clip(step, -12.0, 3.0), floor)
    return ConeSolution(masses, feasible, s[:2], bound, total)


def _newton(problem: ConeProblem, v: Array, d: Array, s: Array):
    """Dual of the bounded problem at scales `s`, lambda > 0.

    Returns v, masses, the three norms over their bounds, and W, J^-1 W that give the norms' derivatives by the scales.
    """
    A, b, M, lam = problem.A, problem.b, problem.M, problem.regularization
    sigma = s[2] / (lam * lam)  # masses = sigma t
    AT, MT = A.T, M.T
    factor = active = None
    error = np.inf
    size = float(np.abs(b).max())
    for count in range(MAX_STEPS):
        t = np.maximum(MT @ (AT @ -v), 0.0)
        c = A @ (M @ t)
        F = d * v + b - sigma * c
        last, error = error, float(np.abs(F).max())
        positive = t > 0.0
        if factor is not None and np.array_equal(positive, active) and (error < 1e-13 * size or error > 0.1 * last):
            break
        active = positive
        J = (sigma * A) @ ((M * active) @ MT) @ AT
        J.flat[:: len(d) + 1] += d
        factor, step, failed = lapack.dposv(J, F)
        if failed:
            J.flat[:: len(d) + 1] += 1e-14 * np.trace(J)
            factor, step, failed = lapack.dposv(J, F)
        v = v - step
    norms = np.sqrt(np.array((problem.k0 @ (v * v), problem.k1 @ (v * v), t @ t / (lam * lam))))
    W = np.array((problem.k0 * v, problem.k1 * v, c / (-lam * lam))).T
    return v, sigma * t, norms, W, lapack.dpotrs(factor, W)[0], count


def _active_set(problem: ConeProblem, v: Array, d: Array, s: Array):
    """The same without regularisation: non-negative least squares, as the dual has no curvature left."""
    from scipy.optimize import nnls

    A, b, M = problem.A, problem.b, problem.M
    root = np.sqrt(d)
    G, g = (A @ M) / root[:, None], b / root
    masses, _ = nnls(G, g)
    U, S, _ = np.linalg.svd(G[:, masses > 0.0], full_matrices=False)
    U = U[:, S > 1e-12 * S.max(initial=0.0)]
    r = G @ masses - g
    v = (r - U @ (U.T @ r)) / root  # exactly stationary, where r alone is so only up to the rounding of |b|
    norms = np.sqrt(np.array((problem.k0 @ (v * v), problem.k1 @ (v * v))))
    W = np.array((problem.k0 * v, problem.k1 * v)).T
    JW = W / root[:, None]
    return v, masses, norms, W, (JW - U @ (U.T @ JW)) / root[:, None], 1


def _shifted(problem: ConeProblem, v: Array) -> Array:
    """`v` moved and scaled until M'A'v >= 0 and both norms are at most one; zeros when that cannot be had."""
    e = problem.M.sum(axis=1)  # M'e = 1: adding mass everywhere alike
    excess = max(0.0, float(np.max(problem.M.T @ (problem.A.T @ -v))))
    shift = np.linalg.lstsq(problem.A.T, 2.0 * excess * e, rcond=1e-12)[0]
    moved = v + shift
    if np.max(problem.M.T @ (problem.A.T @ -moved)) > 0.0:
        return np.zeros_like(v)
    return moved / max(1.0, *np.sqrt(np.array((problem.k0 @ (moved * moved), problem.k1 @ (moved * moved)))))

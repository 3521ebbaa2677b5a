"""The convex problem of PMD, solved in the space of its dual.

    minimise   |A0 M m + B0 beta - b0| + |A1 M m + B1 beta - b1| + lambda |m|    over m >= 0 (n,) and beta

with Euclidean norms that are not squared (Nadeau et al. 2022, problem 1). Each norm has
the tight quadratic bound sqrt(q) <= q / (2 s) + s / 2. For given scales s the bounded
problem has the dual

    maximise   -b'v - 1/2 v'(s0 K0 + s1 K1) v - 1/2 sigma |t|²,   t = max(-M'A'v, 0),  sigma = s2 / lambda

in as many unknowns as the factored data has rows (16; with bias 22), whatever the
number of points; the masses are m = sigma t. A semismooth Newton method solves it. The
scales are the multipliers of the constraints v'K0 v <= 1, v'K1 v <= 1 and |t| <= lambda
of the original problem's dual; Newton's method on the inverse norms finds them, in two
or three steps on ordinary data. Where a norm vanishes (noise-free data) its scale falls
to a floor. Any v, scaled to satisfy the three constraints, certifies the lower bound
-b'v.
"""

import math
from dataclasses import dataclass

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.spatial import Array, Mask
from hefting.estimators.quadratic import nonnegative_least_squares

FLOOR = 1e-7
"""Smallest scale of a norm that vanishes, relative to the objective: costs half of it
in accuracy."""
TOLERANCE = 3e-7
"""Gap at which to stop, relative to the objective (or to 1e-6 |b|, where the objective
is smaller)."""
SMALLEST_START = 1e-3
"""Smallest scale of a residual norm to start from, relative to |b|."""
MAX_STEPS = 200
UNDAMPED_STEPS = 10
"""Newton steps taken in full at one set of scales; ordinary problems need fewer, and a
few would cycle."""


@dataclass(frozen=True, eq=False)
class ConeProblem:
    """One instance, without its bias columns (see `hefting.estimators.pmd`)."""

    A: Array
    """(r, p) rows of both norms; a row that the free bias couples belongs to both in
    part."""
    b: Array
    """(r,) right-hand side"""
    K: Array
    """(2, r) share of each row in the first and in the second norm: diagonals of K0 and
    K1"""
    M: Array
    """(p, n) of the points, with orthonormal rows"""
    regularization: float
    """lambda >= 0"""
    size: float
    """|b| before the bias was taken out: what counts as zero is judged against it"""


@dataclass(frozen=True, eq=False)
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
    """Solve from any non-negative, non-zero masses `start` (n,); a good start saves
    steps, none is needed."""
    b, K, lam, size = problem.b, problem.K, problem.regularization, problem.size
    # no wrench that a bias does not explain: nothing is held
    if float(b @ b) <= (4e-15 * size) ** 2:
        return ConeSolution(np.zeros(len(start)), np.zeros(len(b)), np.ones(2), 0.0, 0)
    r = problem.A @ (problem.M @ start) - b
    squares = (K @ (r * r)).tolist()
    bounded: _Newton | _ActiveSet
    if lam > 0.0:
        squares.append(lam * lam * float(start @ start))
        bounded = _Newton(problem, start > 0.0)
        near = bounded.step_from(r, np.sqrt(squares))
        if near is not None:
            return near
    else:
        bounded = _ActiveSet(problem)
    least = np.array((SMALLEST_START * size, SMALLEST_START * size, 1e-100))
    s = np.maximum(np.sqrt(squares), least[: len(squares)])

    total, lowest, length = 0, np.inf, 1.0
    base = newton = fixed = s
    while True:
        v, masses, norms, count = bounded.solve(s)
        total += count
        primal, value = float(s @ norms), float(b @ v)
        feasible = v / max(1.0, *norms.tolist()) if lam > 0.0 else _shifted(problem, v)
        bound = max(0.0, -float(b @ feasible))
        scale = max(primal, 1e-6 * size)
        if primal - bound <= TOLERANCE * scale or total >= MAX_STEPS:
            break
        # the bounded problem's optimum
        upper = 0.5 * float(s @ (1.0 - norms * norms)) - value
        # Newton overshot: go a part of the way, at last by the fixed-point step, which
        # never overshoots
        if upper > lowest * (1.0 + 1e-12):
            length *= 0.25
            if length > 0.05:
                s = base * (newton / base) ** length
            else:
                s, lowest = fixed, np.inf
            continue
        floor = FLOOR * scale
        lowest, base, length = upper, s, 1.0
        fixed = np.maximum(s * np.minimum(np.maximum(norms, 0.05), 20.0), floor)
        s = newton = _secular(s, norms, bounded.curvature(), floor)
    return ConeSolution(masses, feasible, s[:2], bound, total)


def _secular(s: Array, norms: Array, G: Array, floor: float) -> Array:
    """Scales at which all norms are one, by a Newton step on 1 / norms, where G_ij =
    -d(norms_i² / 2)/ds_j.

    A norm falls about as 1 / s, so its inverse is nearly linear. Scales that would fall
    below `floor` (their norms vanish at the optimum) are held there, and the others
    found anew.
    """
    free, step = norms > 1e-9, floor - s
    while True:
        H, right = G.copy(), norms * norms * (norms - 1.0)
        H.ravel()[:: len(s) + 1] *= 1.0 + 1e-12
        if not np.logical_and.reduce(free):
            held = ~free
            right -= G[:, held] @ step[held]
            H[held], H[:, held], right[held] = 0.0, 0.0, step[held]
            H[held, held] = 1.0
        step = lapack.dgesv(H, right)[2]
        new = s + step
        low = free & (new < floor)
        if not np.logical_or.reduce(low):
            return np.minimum(np.maximum(new, 1e-4 * s), 20.0 * s)
        step[low] = floor - s[low]
        free &= ~low


class _Newton:
    """Dual of the bounded problem at given scales, lambda > 0, by a semismooth Newton
    method.

    For one set of active points the gradient F is linear in v: a step is exact once the
    set is right. The set, and the product over its points, are kept from one solution
    to the next.
    """

    def __init__(self, problem: ConeProblem, active: Mask):
        self._problem = problem
        self._N = -(problem.A @ problem.M)  # (r, n): t = max(N'v, 0)
        self._v = self._Nt = np.zeros(len(problem.b))
        self._activate(active)

    def _activate(self, active: Mask) -> None:
        chosen = self._N[:, active]
        self._active, self._square = active.tobytes(), chosen @ chosen.T

    def step_from(self, r: Array, s: Array) -> ConeSolution | None:
        """The solution, where one step from masses that solve nearly the same problem
        leads there, else None.

        `r` (r,) are their residuals and `s` (3,) all three norms. With v = r / d and t
        = masses / sigma the dual is stationary and all norms are one; a Newton step in
        v, t and s together makes t that of v as well.
        """
        K = self._problem.K
        b = self._problem.b
        lam = self._problem.regularization
        N = self._N
        square = lam * lam
        first, second, third = s.tolist()
        if not (min(first, second) > FLOOR * self._problem.size and third > 0.0):
            return None
        sigma, d = third / square, s[:2] @ K
        v = r / d
        Nt = (r + b) / -sigma
        J = sigma * self._square
        J.ravel()[:: len(d) + 1] += d
        right = np.empty((4, len(v)))
        right[0] = sigma * (self._square @ v - Nt)
        right[1:3] = K * v
        right[3] = Nt / square
        W = right[1:]
        solved, failed = lapack.dposv(J, right.T)[1:]
        change = W @ solved  # (3, 4)
        change[2, 0] += 1.0 - float(W[2] @ v)
        ds, singular = lapack.dgesv(change[:, 1:], change[:, 0])[2:]
        s = s - ds
        if failed or singular or not min(s.tolist()) > 0.0:
            return None
        v = v - solved[:, 0] + solved[:, 1:] @ ds
        t = np.maximum(v @ N, 0.0)
        largest = max(1.0, *(K @ (v * v)).tolist(), float(t @ t) / square)
        feasible = v / math.sqrt(largest)
        masses = (float(s[2]) / square) * t
        residual = N @ masses + b
        norms = np.sqrt(K @ (residual * residual))
        primal = sum(norms.tolist()) + lam * math.sqrt(masses @ masses)
        bound = max(0.0, -float(b @ feasible))
        scale = max(primal, 1e-6 * self._problem.size)
        if primal - bound > TOLERANCE * scale:
            return None
        return ConeSolution(
            masses, feasible, np.maximum(norms, FLOOR * scale), bound, 1
        )

    def solve(self, s: Array) -> tuple[Array, Array, Array, int]:
        """v, the masses, the three norms over their bounds, and the linear systems
        solved, at scales `s` (3,)."""
        K = self._problem.K
        b = self._problem.b
        lam = self._problem.regularization
        N = self._N
        sigma = float(s[2]) / (lam * lam)  # masses = sigma t
        d = s[:2] @ K
        v = self._v
        F = d * v + b + sigma * self._Nt
        count, error, negligible = 0, np.inf, 1e-26 * float(b @ b)
        while True:
            count += 1
            J = sigma * self._square
            J.ravel()[:: len(d) + 1] += d
            factor, step, failed = lapack.dposv(J, F)
            if failed:
                J.ravel()[:: len(d) + 1] += 1e-14 * np.trace(J)
                factor, step, failed = lapack.dposv(J, F)
            damping = (
                1.0
                if count <= UNDAMPED_STEPS
                else self._damping(v, step, float(F @ step), d, sigma)
            )
            v = v - damping * step
            t = np.maximum(v @ N, 0.0)
            Nt = N @ t
            F = d * v + b + sigma * Nt
            last, error = error, float(F @ F)
            active = t > 0.0
            if active.tobytes() != self._active:
                self._activate(active)
            elif damping == 1.0 and (error < negligible or error > 0.01 * last):
                break
            if count >= MAX_STEPS:
                break
        self._v, self._Nt, self._factor = v, Nt, factor
        self._W = np.empty((3, len(v)))  # derivatives of half the squared norms by v
        self._W[:2], self._W[2] = K * v, Nt / (lam * lam)
        squares = self._W @ v
        squares[2] = float(t @ t) / (lam * lam)  # without cancellation
        return v, sigma * t, np.sqrt(squares), count

    def _damping(
        self, v: Array, step: Array, slope: float, d: Array, sigma: float
    ) -> float:
        """First of 1, 1/2, 1/4, ... by which `step` lowers the dual's convex objective;
        1 where rounding decides."""

        def objective(v: Array) -> float:
            t = np.maximum(v @ self._N, 0.0)
            return float(
                self._problem.b @ v + 0.5 * (d * v) @ v + 0.5 * sigma * (t @ t)
            )

        damping, now = 1.0, objective(v)
        if slope < 1e-12 * abs(now):
            return 1.0
        while (
            damping > 1e-12
            and objective(v - damping * step) > now - 1e-4 * damping * slope
        ):
            damping *= 0.5
        return damping

    def curvature(self) -> Array:
        """W' J^-1 W (3, 3), which turns changes of the scales into changes of the
        squared norms."""
        return self._W @ lapack.dpotrs(self._factor, self._W.T)[0]


class _ActiveSet:
    """The same without regularisation: non-negative least squares, as the dual has no
    curvature left."""

    def __init__(self, problem: ConeProblem):
        self._problem = problem
        self._AM = problem.A @ problem.M

    def solve(self, s: Array) -> tuple[Array, Array, Array, int]:
        """v, the masses, the two norms over their bounds, and one linear system, at
        scales `s` (2,)."""
        root = np.sqrt(s @ self._problem.K)
        G, g = self._AM / root[:, None], self._problem.b / root
        masses = nonnegative_least_squares(G, g)
        U, S, _ = np.linalg.svd(G[:, masses > 0.0], full_matrices=False)
        U = U[:, 1e-12 * S.max(initial=0.0) < S]
        r = G @ masses - g
        # exactly stationary; r alone is so only up to the rounding of |b|
        v = (r - U @ (U.T @ r)) / root
        W = self._problem.K * v
        self._W, self._U = W / root, U
        return v, masses, np.sqrt(W @ v), 1

    def curvature(self) -> Array:
        """W' J^-1 W (2, 2), which turns changes of the scales into changes of the
        squared norms."""
        WU = self._W @ self._U
        return self._W @ self._W.T - WU @ WU.T


def _shifted(problem: ConeProblem, v: Array) -> Array:
    """`v` moved and scaled until M'A'v >= 0 and both norms are at most one; zeros when
    that cannot be had."""
    e = problem.M.sum(axis=1)  # M'e = 1: adding mass everywhere alike
    slack = problem.M.T @ (problem.A.T @ v)
    # above rounding
    excess = max(0.0, -float(slack.min())) + 1e-14 * float(np.abs(slack).max())
    push = np.asarray(
        np.linalg.lstsq(problem.A.T, 2.0 * excess * e, rcond=1e-12)[0], dtype=float
    )
    moved = v + push
    if np.min(problem.M.T @ (problem.A.T @ moved)) < 0.0:
        return np.zeros_like(v)
    return moved / max(1.0, *np.sqrt(problem.K @ (moved * moved)).tolist())

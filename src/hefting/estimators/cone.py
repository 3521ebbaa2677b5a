"""The convex problem of PMD, solved in the space of its dual.

    minimise   |A0 m + B0 beta - b0| + |A1 m + B1 beta - b1| + lambda |m|    over m >= 0 (n,) and beta

with Euclidean norms that are not squared (Nadeau et al. 2022, problem 1). Each norm has
the tight quadratic bound sqrt(q) <= q / (2 s) + s / 2. For given scales s the bounded
problem has the dual

    maximise   b'u - 1/2 u'(s0 K0 + s1 K1) u - 1/2 sigma |t|²,   t = max(A'u, 0),  sigma = s2 / lambda²

in as many unknowns as the factored data has rows (16; with bias 22), whatever the
number of points; the masses are m = sigma t. A semismooth Newton method solves it. The
scales are the multipliers of the constraints u'K0 u <= 1, u'K1 u <= 1 and |t| <= lambda
of the original problem's dual; Newton's method on the inverse norms finds them, in two
or three steps on ordinary data. Where a norm vanishes (noise-free data) its scale falls
to a floor. Any u, scaled to satisfy the three constraints, certifies the lower bound
b'u.

On arrays as small as these `dot` takes half the time of `@`.
"""

import math

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.spatial import Array, Mask, immutable
from hefting.estimators.quadratic import nonnegative_least_squares

FLOOR = 1e-7
"""Least scale of a vanishing norm, over the objective; half is lost in accuracy."""
TOLERANCE = 3e-7
"""Gap at which the iteration ends, relative to the objective (or to 1e-6 |b|, if the
objective is smaller)."""
SMALLEST_START = 1e-3
"""Smallest scale of a residual norm to start from, relative to |b|."""
MAX_STEPS = 200
UNDAMPED_STEPS = 10
"""Number of full Newton steps at one set of scales. Ordinary problems need fewer; a few
would cycle without damping."""


@immutable
class ConeProblem:
    """The problem without its bias columns (see `hefting.estimators.pmd`)."""

    A: Array
    """(r, n) rows of both norms; rows the free bias couples belong to both in part"""
    b: Array
    """(r,) right-hand side"""
    K: Array
    """(2, r) share of each row in the first and in the second norm: diagonals of K0 and
    K1"""
    regularization: float
    """lambda >= 0"""
    size: float
    """|b| before the bias was eliminated, relative to which numbers count as zero"""


@immutable
class ConeSolution:
    """Result of `solve`."""

    masses: Array
    """(n,) >= 0"""
    scales: Array
    """(2,) the two residual norms, or the floor where they vanish"""
    bound: float
    """lower bound on the optimum"""
    iterations: int
    """number of linear systems solved"""


def solve(problem: ConeProblem, start: Array) -> ConeSolution:
    """Solve from masses `start` (n,) >= 0, not all zero; a good start saves steps."""
    b, K, lam, size = problem.b, problem.K, problem.regularization, problem.size
    # a bias explains all of the wrench: nothing is held
    if b.dot(b) <= (4e-15 * size) ** 2:
        return ConeSolution(np.zeros(len(start)), np.ones(2), 0.0, 0)
    r = b - problem.A.dot(start)
    norms = np.sqrt(K.dot(r * r))
    bounded: _Newton | _ActiveSet
    if lam > 0.0:
        third = lam * math.sqrt(start.dot(start))
        norms = np.array((*norms.tolist(), third))
        bounded = _Newton(problem, start > 0.0)
        near = bounded.step_from(r, norms)
        if near is not None:
            return near
    else:
        bounded = _ActiveSet(problem)
    least = np.array((SMALLEST_START * size, SMALLEST_START * size, 1e-100))
    s = np.maximum(norms, least[: len(norms)])

    total, lowest, length = 0, np.inf, 1.0
    base = newton = fixed = s
    while True:
        u, masses, norms, count = bounded.solve(s)
        total += count
        primal, value = float(s @ norms), float(b @ u)
        feasible = u / max(1.0, *norms.tolist()) if lam > 0.0 else _shifted(problem, u)
        bound = max(0.0, float(b @ feasible))
        scale = max(primal, 1e-6 * size)
        if primal - bound <= TOLERANCE * scale or total >= MAX_STEPS:
            break
        # optimum of the bounded problem
        upper = 0.5 * float(s @ (1.0 - norms * norms)) + value
        # Newton's step overshot: shorten it, or take the fixed-point step, which never does
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
    return ConeSolution(masses, s[:2], bound, total)


def _secular(s: Array, norms: Array, G: Array, floor: float) -> Array:
    """Scales at which all norms are one, by a Newton step on 1 / norms, with G_ij =
    -d(norms_i² / 2)/ds_j.

    A norm is about proportional to 1 / s, so its inverse is nearly linear. Scales that
    would fall below `floor`, whose norms vanish at the optimum, are fixed there.
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

    For one set of active points the gradient F is linear in u: a step is exact once the
    set is right. The set, and the product over its points, are kept from one solution
    to the next.
    """

    def __init__(self, problem: ConeProblem, active: Mask):
        self._problem = problem
        self._u = self._At = np.zeros(len(problem.b))
        self._activate(active)

    def _activate(self, active: Mask) -> None:
        chosen = self._problem.A.compress(active, axis=1)
        self._active, self._square = active.tobytes(), chosen.dot(chosen.T)

    def _system(self, d: Array, sigma: float) -> Array:
        """Minus the derivative (r, r) of F by u: D + sigma A A' of active points."""
        J = sigma * self._square
        diagonal = J.ravel()[:: len(d) + 1]
        diagonal += d
        return J

    def step_from(self, r: Array, s: Array) -> ConeSolution | None:
        """The solution, if one step from the masses of a similar problem reaches it, else
        None.

        `r` (r,) is the residual of these masses, and `s` (3,) are all three norms. With
        u = r / d and t = masses / sigma the dual is stationary and all norms are one; a
        Newton step in u, t and s together makes t = max(A'u, 0) as well.
        """
        A, b, K = self._problem.A, self._problem.b, self._problem.K
        lam, size = self._problem.regularization, self._problem.size
        square = lam * lam
        first, second, third = s.tolist()
        if not (min(first, second) > FLOOR * size and third > 0.0):
            return None
        d = s[:2].dot(K)
        u = r / d
        right = np.empty((4, len(b)))
        right[0] = b
        np.multiply(K, u, out=right[1:3])
        np.divide(b - r, third, out=right[3])
        solved, failed = lapack.dposv(self._system(d, third / square), right.T)[1:]
        # W u for a norm of one, to first order
        q0, q1 = right[1:3].dot(u).tolist()
        ones = np.array((0.5 + 0.5 * q0, 0.5 + 0.5 * q1, 1.0))
        found = right[1:].dot(solved)
        ds, singular = lapack.dgesv(found[:, 1:], ones - found[:, 0])[2:]
        scales = (s - ds).tolist()
        if failed or singular or not min(scales) > 0.0:
            return None
        u = solved[:, 0] + solved[:, 1:].dot(ds)
        t = np.maximum(u.dot(A), 0.0)
        length = math.sqrt(t.dot(t))
        largest = max(1.0, *K.dot(u * u).tolist(), length * length / square)
        bound = max(0.0, float(b.dot(u)) / math.sqrt(largest))
        sigma = scales[2] / square
        masses = sigma * t
        left = b - A.dot(masses)
        norms = np.sqrt(K.dot(left * left))
        primal = sum(norms.tolist()) + lam * sigma * length
        scale = max(primal, 1e-6 * size)
        if primal - bound > TOLERANCE * scale:
            return None
        return ConeSolution(masses, np.maximum(norms, FLOOR * scale), bound, 1)

    def solve(self, s: Array) -> tuple[Array, Array, Array, int]:
        """u, the masses, the three norms over their bounds, and the linear systems
        solved, at scales `s` (3,)."""
        A, b, K = self._problem.A, self._problem.b, self._problem.K
        square = self._problem.regularization**2
        sigma = float(s[2]) / square  # masses = sigma t
        d = s[:2].dot(K)
        u = self._u
        F = b - d * u - sigma * self._At
        count, error, negligible = 0, np.inf, 1e-26 * float(b.dot(b))
        while True:
            count += 1
            J = self._system(d, sigma)
            factor, step, failed = lapack.dposv(J, F)
            if failed:
                J.ravel()[:: len(d) + 1] += 1e-14 * np.trace(J)
                factor, step, failed = lapack.dposv(J, F)
            damping = 1.0
            if count > UNDAMPED_STEPS:
                damping = self._damping(u, step, float(F.dot(step)), d, sigma)
            u = u + damping * step
            t = np.maximum(u.dot(A), 0.0)
            At = A.dot(t)
            F = b - d * u - sigma * At
            last, error = error, float(F.dot(F))
            active = t > 0.0
            if active.tobytes() != self._active:
                self._activate(active)
            elif damping == 1.0 and (error < negligible or error > 0.01 * last):
                break
            if count >= MAX_STEPS:
                break
        self._u, self._At, self._factor = u, At, factor
        self._W = np.empty((3, len(u)))  # derivatives of half the squared norms by u
        self._W[:2], self._W[2] = K * u, At / square
        squares = self._W.dot(u)
        squares[2] = float(t.dot(t)) / square  # without cancellation
        return u, sigma * t, np.sqrt(squares), count

    def _damping(
        self, u: Array, step: Array, slope: float, d: Array, sigma: float
    ) -> float:
        """The first of 1, 1/2, 1/4, ... for which `step` decreases the dual's convex
        objective; 1 where rounding decides."""

        def objective(u: Array) -> float:
            t = np.maximum(u @ self._problem.A, 0.0)
            return float(
                0.5 * (d * u) @ u + 0.5 * sigma * (t @ t) - self._problem.b @ u
            )

        damping, now = 1.0, objective(u)
        if slope < 1e-12 * abs(now):
            return 1.0
        while (
            damping > 1e-12
            and objective(u + damping * step) > now - 1e-4 * damping * slope
        ):
            damping *= 0.5
        return damping

    def curvature(self) -> Array:
        """W' J^-1 W (3, 3): changes of the squared norms by changes of the scales."""
        return self._W @ lapack.dpotrs(self._factor, self._W.T)[0]


class _ActiveSet:
    """Dual of the bounded problem without regularisation. It has no curvature, so that
    the problem is non-negative least squares."""

    def __init__(self, problem: ConeProblem):
        self._problem = problem

    def solve(self, s: Array) -> tuple[Array, Array, Array, int]:
        """u, the masses, the two norms over their bounds, and one linear system, at
        scales `s` (2,)."""
        root = np.sqrt(s @ self._problem.K)
        G, g = self._problem.A / root[:, None], self._problem.b / root
        masses = nonnegative_least_squares(G, g)
        U, S, _ = np.linalg.svd(G[:, masses > 0.0], full_matrices=False)
        U = U[:, 1e-12 * S.max(initial=0.0) < S]
        r = g - G @ masses
        # exactly stationary; r alone is so only up to the rounding of |b|
        u = (r - U @ (U.T @ r)) / root
        W = self._problem.K * u
        self._W, self._U = W / root, U
        return u, masses, np.sqrt(W @ u), 1

    def curvature(self) -> Array:
        """W' J^-1 W (2, 2): changes of the squared norms by changes of the scales."""
        WU = self._W @ self._U
        return self._W @ self._W.T - WU @ WU.T


def _shifted(problem: ConeProblem, u: Array) -> Array:
    """`u` moved and scaled so that A'u <= 0 and both norms are at most 1; or zeros."""
    over = problem.A.T @ u
    # above rounding
    excess = max(0.0, float(over.max())) + 1e-14 * float(np.abs(over).max())
    less = np.full(len(over), -2.0 * excess)  # for mass everywhere alike
    moved = u + np.linalg.lstsq(problem.A.T, less, rcond=1e-12)[0]
    if np.max(problem.A.T @ moved) > 0.0:
        return np.zeros_like(u)
    return moved / max(1.0, *np.sqrt(problem.K @ (moved * moved)).tolist())

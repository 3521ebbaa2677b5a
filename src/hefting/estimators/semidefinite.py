"""Quadratics over bodies that can exist: positive semidefinite 4 x 4 pseudo-inertias,
ten unknowns.

    minimise   |A q - b|² + gamma (tr Q - log det Q - 4)    over Q = mat(q) >= 0 (and e'q >= 0)

q (10,) are the entries of Q in an orthonormal basis. For gamma > 0 this is a point of
the central path of the problem without the logarithm, so one path-following method
serves both: primal-dual, with Nesterov & Todd's scaling (1997) and Mehrotra's predictor
and corrector, following the path down to gamma. Iterates are kept as factors Q = L L',
Z = K K', so no matrix near the boundary is ever decomposed. Every u (r,) certifies a
lower bound: with 2 A'u = vec S (+ y e),

    |A q - b|² >= -|u|² - 2 b'u + <S, Q>   and   <S, Q> + gamma (tr Q - log det Q - 4) >= gamma log det(I + S / gamma).
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.core.accuracy import Certificate
from hefting.core.inertia import DIAGONAL, IDENTITY, congruence, mat, vec
from hefting.core.lapack import lapack
from hefting.core.spatial import Array, immutable
from hefting.estimators.quadratic import ScaledSVD

SMALLEST_GAMMA = 1e-14
"""gamma relative to |b|² without a prior. It decides only what the data leave open."""
GAP_TOLERANCE = 1e-6
"""Certified gap at which a solution counts as converged, relative to the objective (or
1e-6 |b|², if it is smaller)."""
TRACE_BOUND = 10.0
"""The lower bound without logarithm holds for bodies whose tr Q is at most this
multiple of the trace found."""
SMALLEST_EIGENVALUE = 1e-15
"""Smallest eigenvalue of Q relative to its trace. Below it rounding decides whether Q
is positive definite."""
SUFFICIENT_GAP = 1e-9
"""Duality gap relative to the objective at which the path ends early, for gamma = 0 and
a unique solution."""
FIRST_MU = 0.01
"""First mu relative to the largest entry of the gradient at Q = I. Smaller values save
steps; much smaller ones fail."""
MOST_PATH_STEPS = 60
"""Largest number of steps along the central path."""
MOST_RESTARTS = 2
"""Largest number of restarts from the body that was found, for gamma = 0, if its bound
does not prove it optimal."""
INSIDE = 0.98
"""Share of the step to the boundary of the cones that is taken, to stay inside."""
SHORTER, SHORTEST_STEP = 0.7, 1e-4
"""Factor on a step that ends too far from the central path, and share of Newton's step
at which another goal is tried."""
SMALLEST_CENTRALITY = 1e-3
"""Smallest product of an eigenvalue of Q with that of Z, relative to their mean: steps
get short further from the central path."""

_EYE = np.eye(4)


def _eigenvalues(X: Array) -> Array:
    return lapack.dsyevd(X, 0)[0]


def _svd(X: Array) -> tuple[Array, Array, Array]:
    return lapack.dgesdd(X)[:3]


@immutable
class Solution:
    """Result of `solve`."""

    q: Array
    """(10,) of a positive definite Q"""
    objective: float
    bound: float
    """lower bound on the optimum"""
    iterations: int
    converged: bool

    @property
    def certificate(self) -> Certificate:
        """Certificate of the distance from the optimum."""
        return Certificate(self.objective, self.bound, self.iterations, self.converged)


def solve(
    A: Array, b: Array, gamma: float = 0.0, half_space: Array | None = None
) -> Solution:
    """Solve for `A` (r, 10), `b` (r,), `gamma` >= 0 and, if given, e (10,) with e'q >=
    0 and e'vec(I) > 0.

    Starts from Q = I, which should be of the order of the answer: see `congruence`.
    With gamma = 0 what the data leave open is taken as close to I as the rest allows; a
    half space is for gamma = 0 only.
    """
    size = math.sqrt(b @ b) or 1.0
    A, b, prior = A / size, b / size, gamma / size**2
    if prior >= SMALLEST_GAMMA:
        found = _follow(A, b, prior, half_space)
    else:
        svd = ScaledSVD.of(A)
        determined = not len(svd.kernel)
        found = _unconstrained(A, b, half_space, svd) if determined else None
        found = found or _follow(
            A, b, 0.0, half_space, SUFFICIENT_GAP if determined else 0.0
        )
        for _ in range(MOST_RESTARTS):
            if not found.converged:
                found = _restart(A, b, half_space, found)
        if prior:
            objective = found.objective + prior * divergence(mat(found.q))
            found = replace(
                found,
                objective=objective,
                converged=found.bound >= _sufficient(objective),
            )
    return replace(
        found, objective=found.objective * size**2, bound=found.bound * size**2
    )


def _sufficient(objective: float) -> float:
    """The lower bound that proves an objective optimal."""
    return objective - GAP_TOLERANCE * max(objective, 1e-6)


def _follow(
    A: Array, b: Array, gamma: float, half_space: Array | None, enough: float = 0.0
) -> Solution:
    """The point of the central path at gamma, or the best point before it. If the
    path's end is the aim, a duality gap `enough`, relative to the objective, suffices.
    """
    path = _Path(A, b, max(gamma, SMALLEST_GAMMA), half_space)
    q, multiplier, least = IDENTITY, path.multiplier, math.inf
    while path.steps < MOST_PATH_STEPS and path.advance():
        now = vec(path.L @ path.L.T)
        r = A @ now - b
        square = float(r @ r)
        if gamma or square <= least:  # else rounding errors dominate
            q, multiplier, least = now, path.multiplier, square
        if path.gap < enough * max(square, 1e-6):
            break
    lack = SMALLEST_EIGENVALUE * float(q @ IDENTITY) - float(_eigenvalues(mat(q))[0])
    body = q + max(0.0, lack) * IDENTITY
    r = A @ body - b
    objective = float(r @ r) + (gamma * divergence(mat(body)) if gamma else 0.0)
    bound = _bound(A, b, q, gamma, multiplier)
    if bound < _sufficient(objective):
        bound = max(bound, _bound(A, b, q, gamma, multiplier, feasible=True))
    return Solution(body, objective, bound, path.steps, bound >= _sufficient(objective))


def _restart(A: Array, b: Array, half_space: Array | None, found: Solution) -> Solution:
    """The better of `found` and a solution that starts from it, as the first start may
    have been far from optimal."""
    thick = mat(found.q) + 1e-2 * float(found.q @ IDENTITY) * _EYE
    T = congruence(lapack.dpotrf(thick, lower=1)[0])
    second = _follow(A @ T, b, 0.0, None if half_space is None else half_space @ T)
    steps = found.iterations + second.iterations
    if second.objective - second.bound < found.objective - found.bound:
        found = replace(second, q=T @ second.q)
    return replace(found, iterations=steps)


def _unconstrained(
    A: Array, b: Array, half_space: Array | None, svd: ScaledSVD
) -> Solution | None:
    """Least squares if that is a body; else None."""
    q = svd.solve(b)
    if _eigenvalues(mat(q))[0] < 1e-9 * np.abs(q).max() or (
        half_space is not None and half_space @ q < 0.0
    ):
        return None
    r = A @ q - b
    slack = svd.U.T @ r
    square = float(r @ r)
    return Solution(q, square, max(0.0, square - float(slack @ slack)), 1, True)


def divergence(Q: Array) -> float:
    """tr Q - log det Q - 4 of a positive definite Q (4, 4): the entropic distance from
    I (Lee et al. 2020)."""
    values = _eigenvalues(Q)
    if values[0] <= 0.0:
        return math.inf
    excess = values - 1.0
    return float(np.sum(excess - np.log1p(excess)))


def _bound(
    A: Array,
    b: Array,
    q: Array,
    gamma: float,
    multiplier: Array | float,
    *,
    feasible: bool = False,
) -> float:
    """Largest lower bound from u, the residual at q; `multiplier` (10,) is y e. With
    `feasible`, u is moved within the range of A to the nearest one for which S has no
    negative eigenvalue."""
    u = A @ q - b
    S = 2.0 * (A.T @ u) - multiplier
    if feasible:
        values, axes, _ = lapack.dsyevd(mat(S))
        svd = ScaledSVD.of(A)
        lack = vec((axes * np.maximum(-values, 0.0)) @ axes.T)
        u = u + svd.U @ ((svd.V @ (0.5 * lack / svd.scale)) / svd.S)
        S = 2.0 * (A.T @ u) - multiplier
    value, values = -float(u @ u + 2.0 * (b @ u)), _eigenvalues(mat(S))
    bound = value + TRACE_BOUND * float(q @ IDENTITY) * min(0.0, float(values[0]))
    if gamma > 0.0 and values[0] > -gamma:
        bound = max(bound, value + gamma * float(np.sum(np.log1p(values / gamma))))
    return max(0.0, bound)


class _Path:
    """The central path: Q Z = mu I (and e'q y = mu), where Z, y are the gradient's
    multipliers, down to `target`."""

    def __init__(self, A: Array, b: Array, target: float, half_space: Array | None):
        self._A, self._b = A * math.sqrt(2.0), b * math.sqrt(2.0)
        self._target = target
        self._e = half_space
        gradient = self._A.T @ (self._A @ IDENTITY - self._b) + target * IDENTITY
        mu = max(target, FIRST_MU * float(np.abs(gradient).max()))
        self.L, self._K = _EYE, math.sqrt(mu) * _EYE
        self._svd = _svd(self._K)
        self._slack, self._y = 1.0, 0.0
        if half_space is not None:
            self._slack = float(half_space @ IDENTITY)
            self._y = mu / self._slack
        self.steps = self._arrived = 0

    @property
    def gap(self) -> float:
        """Sum of the products of Q with Z, and of the slack with y: the duality gap of
        a feasible iterate."""
        s = self._svd[1]
        return float(s @ s) + self._slack * self._y

    @property
    def multiplier(self) -> Array | float:
        """y e (10,)"""
        return 0.0 if self._e is None else self._y * self._e

    def advance(self) -> bool:
        """Take one step; False at the end, or where rounding prevents further ones."""
        U, s, V = self._svd
        roots = np.sqrt(s)
        # R^-1 Q R^-T = R'Z R = diag(s), Rt = R^-T
        R, Rt = (self.L @ V.T) / roots, (self._K @ U) / roots
        T = congruence(R)
        At, scaled = self._A @ T, DIAGONAL @ s
        mismatch = (
            At.T @ (At @ scaled - self._b)
            + T.T @ (self._target * IDENTITY - self.multiplier)
            - scaled
        )
        if self._arrive(s, mismatch):
            return False
        N = At.T @ At
        N.ravel()[::11] += 1.0
        et = None if self._e is None else T.T @ self._e
        factor, failed = lapack.dpotrf(N)
        if failed:
            return False
        step = _Step(s, self._slack, self._y, factor, mismatch, et)
        return any(self._take(step, R, Rt, *goal) for goal in self._goals(step))

    def _arrive(self, s: Array, mismatch: Array) -> bool:
        """Whether the end of the path is reached, up to rounding."""
        target = self._target
        off = float(np.abs(s * s - target).max())
        if self._e is not None:
            off = max(off, abs(self._slack * self._y - target))
        if off > 1e-6 * target:
            return False
        self._arrived += 1
        return self._arrived > 1 or float(mismatch @ mismatch) < 1e-14 * target

    def _goals(self, step: "_Step") -> Iterator[tuple[float, Array | float, float]]:
        """mu to aim at, with second-order corrections: Mehrotra's, then ever more
        central ones if that fails."""
        target, mu = self._target, step.mu
        dQ, dZ, ds, dy = step.towards(target)
        sigma = 0.0
        if mu > target:
            ahead = step.mu_after(min(1.0, step.length(dQ, dZ, ds, dy)), dQ, dZ, ds, dy)
            sigma = min(1.0, max(ahead - target, 0.0) / (mu - target)) ** 2
        cross = dQ @ dZ
        yield target + sigma * (mu - target), 0.5 * (cross + cross.T), ds * dy
        yield 0.5 * (mu + target), 0.0, 0.0
        yield mu, 0.0, 0.0

    def _take(
        self,
        step: "_Step",
        R: Array,
        Rt: Array,
        goal: float,
        cross: Array | float,
        cross_y: float,
    ) -> bool:
        """Step towards `goal` as far as the iterate stays inside and near the path;
        False if it cannot."""
        dQ, dZ, ds, dy = step.towards(goal, cross, cross_y)
        a = min(1.0, INSIDE * step.length(dQ, dZ, ds, dy))
        while a > SHORTEST_STEP:
            left, failed = lapack.dpotrf(step.diagonal + a * dQ, lower=1)
            right, failed_too = lapack.dpotrf(step.diagonal + a * dZ, lower=1)
            if not (failed or failed_too):
                L, K = R @ left, Rt @ right
                svd = _svd(K.T @ L)
                squares = svd[1] * svd[1]
                if squares[3] > SMALLEST_CENTRALITY * 0.25 * float(squares.sum()):
                    self.L, self._K, self._svd = L, K, svd
                    self._slack, self._y = self._slack + a * ds, self._y + a * dy
                    self.steps += 1
                    return True
            a *= SHORTER
        return False


class _Step:
    """Newton's equations at one iterate, in coordinates in which Q = Z = diag(s)."""

    def __init__(
        self,
        s: Array,
        slack: float,
        y: float,
        factor: Array,
        mismatch: Array,
        e: Array | None,
    ):
        self.s = s
        self._slack = slack
        self._y = y
        self._factor = factor
        self._mismatch = mismatch
        self._e = e
        self.diagonal = s * _EYE
        self._sums = 0.5 * (s[:, None] + s)
        self._roots = np.sqrt(s[:, None] * s)
        total = float(s @ s)
        self.mu = total / 4.0 if e is None else (total + slack * y) / 5.0

    def towards(
        self, mu: float, cross: Array | float = 0.0, cross_y: float = 0.0
    ) -> tuple[Array, Array, float, float]:
        """Changes of Q and Z (4, 4), of the slack and of y, towards products `mu` less
        corrections."""
        right = vec(((mu - self.s * self.s) * _EYE - cross) / self._sums)
        dq = lapack.dpotrs(self._factor, right - self._mismatch)[0]
        ds = dy = 0.0
        # y by elimination: dividing by the slack would magnify rounding as it vanishes
        if self._e is not None:
            per_y = lapack.dpotrs(self._factor, self._e)[0]
            goal = mu - self._slack * self._y - cross_y
            dy = (goal - self._y * float(self._e @ dq)) / (
                self._slack + self._y * float(self._e @ per_y)
            )
            dq = dq + dy * per_y
            ds = (goal - self._slack * dy) / self._y
        return mat(dq), mat(right - dq), ds, dy

    def length(self, dQ: Array, dZ: Array, ds: float, dy: float) -> float:
        """Largest step that stays inside, at most 1 / `INSIDE`."""
        low = min(_eigenvalues(dQ / self._roots)[0], _eigenvalues(dZ / self._roots)[0])
        if self._e is not None:
            low = min(low, ds / self._slack, dy / self._y)
        return min(1.0 / INSIDE, -1.0 / low) if low < 0.0 else 1.0 / INSIDE

    def mu_after(self, a: float, dQ: Array, dZ: Array, ds: float, dy: float) -> float:
        """Mean product after a step of length `a`."""
        total = float(np.vdot(self.diagonal + a * dQ, self.diagonal + a * dZ))
        if self._e is None:
            return total / 4.0
        return (total + (self._slack + a * ds) * (self._y + a * dy)) / 5.0

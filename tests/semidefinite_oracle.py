"""Independent oracle for GEO and LMI: the published problems, from every sample,
through a general conic solver."""

import warnings
from dataclasses import dataclass
from functools import cache

import cvxpy
import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from hefting.core.regressor import full_regressor
from hefting.estimators import GEO, LMI
from hefting.shapes import Shape
from random_problems import random_motion, with_wrench

RELATIVE = 1e-6
"""Accuracy asked of an objective, relative to it (or to 1e-6 |b|² where it is
smaller)."""


@dataclass(frozen=True)
class Problem:
    """|A phi - b|² + gamma D(phi, phi0) over bodies, D by `distance`; with `ellipsoid`
    Q also tr(P Q) >= 0."""

    A: np.ndarray
    """(r, 10)"""
    b: np.ndarray
    """(r,)"""
    P0: np.ndarray
    """(4, 4) pseudo-inertia of the prior; without one, of a body of about the right
    size"""
    gamma: float = 0.0
    distance: str = "entropic"
    ellipsoid: np.ndarray | None = None
    """(4, 4)"""

    def objective(self, P: np.ndarray) -> float:
        """Value at the body of pseudo-inertia P (4, 4)."""
        r = self.A @ vector_of(P) - self.b
        value = float(r @ r)
        if self.gamma == 0.0:
            return value
        if self.distance == "euclidean":
            return value + self.gamma * float(
                np.sum((vector_of(P) - vector_of(self.P0)) ** 2)
            )
        G = np.linalg.inv(np.linalg.cholesky(self.P0))
        X = np.linalg.eigvalsh(G @ P @ G.T)
        if self.distance == "pullback":
            return value + 0.5 * self.gamma * float(np.sum((X - 1.0) ** 2))
        return value + self.gamma * float(np.sum(X - 1.0 - np.log(X)))

    @property
    def size(self) -> float:
        """|b|²"""
        return float(self.b @ self.b)

    def tolerance(self, optimum: float) -> float:
        """By how much objectives may differ."""
        return RELATIVE * max(optimum, 1e-6 * self.size)


@dataclass(frozen=True)
class Optimum:
    """What the conic solver found."""

    upper: float
    """objective, computed anew at a body: no optimum is above it"""
    P: np.ndarray
    """(4, 4) that body's pseudo-inertia"""
    status: str
    """``"optimal"``, or why not"""


def vector_of(P: np.ndarray) -> np.ndarray:
    """Inertial parameters (10,) of pseudo-inertia P (4, 4)."""
    J = np.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
    return np.concatenate(((P[3, 3],), P[:3, 3], J[np.triu_indices(3)]))


def pseudo_inertia(vector: np.ndarray) -> np.ndarray:
    """Pseudo-inertia (4, 4) of inertial parameters (10,)."""
    m, x, y, z, xx, xy, xz, yy, yz, zz = vector
    Sigma = 0.5 * (xx + yy + zz) * np.eye(3) - np.array(
        ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    )
    return np.block([[Sigma, np.array(((x,), (y,), (z,)))], [np.array((x, y, z)), m]])


def rows(
    z: Measurements, noise: Noise | np.ndarray | None, free_bias: bool
) -> tuple[np.ndarray, np.ndarray]:
    """A (r, 10) and b (r,) of all samples' equations, whitened; a free constant bias
    projected out of them."""
    S = np.eye(6) if noise is None else noise
    if isinstance(noise, Noise):
        S = np.diag(np.repeat((noise.force, noise.torque), 3) ** 2)
    W = np.linalg.inv(np.linalg.cholesky(S))
    bias = np.broadcast_to(np.eye(6), (len(z), 6, 6))
    columns = np.concatenate((bias, full_regressor(z), z.wrench[:, :, None]), axis=2)
    R = np.linalg.qr(
        (W @ columns).reshape(-1, 17)[:, 0 if free_bias else 6 :], mode="r"
    )
    R = R[6:, 6:] if free_bias else R
    return R[:, :10], R[:, 10]


_ROWS, _COLUMNS = np.triu_indices(4)


def _columns(problem: Problem, G: np.ndarray) -> np.ndarray:
    """(10, 10) takes the upper triangle of X (4, 4) to the parameters of G X G'."""
    columns = []
    for i, j in zip(_ROWS, _COLUMNS, strict=True):
        X = np.zeros((4, 4))
        X[i, j] = X[j, i] = 1.0
        columns.append(vector_of(G @ X @ G.T))
    return np.stack(columns, axis=1)


@cache
def _compiled(entropic: bool, half_space: bool):
    """The problem over X (4, 4) with its data left open, so that it need not be
    compiled anew each time."""
    A = cvxpy.Parameter((21, 10))
    b = cvxpy.Parameter(21)
    E = cvxpy.Parameter((4, 4))
    gamma = cvxpy.Parameter(nonneg=True)
    X = cvxpy.Variable((4, 4), symmetric=True)
    x = cvxpy.hstack([X[i, j] for i, j in zip(_ROWS, _COLUMNS, strict=True)])
    objective = cvxpy.sum_squares(A @ x - b)
    if entropic:
        objective += gamma * (cvxpy.trace(X) - cvxpy.log_det(X))
    constraints = [X >> 0] + ([cvxpy.trace(E @ X) >= 0] if half_space else [])
    return cvxpy.Problem(cvxpy.Minimize(objective), constraints), X, A, b, gamma, E


def solve(problem: Problem) -> Optimum:
    """Solve by Clarabel, in the coordinates X of P = G X G' with P0 = G G' and the data
    divided by |b|."""
    G, size = np.linalg.cholesky(problem.P0), np.sqrt(problem.size) or 1.0
    T = _columns(problem, G)
    left, right = [problem.A @ T], [problem.b]
    entropic = problem.gamma > 0.0 and problem.distance == "entropic"
    if problem.gamma > 0.0 and not entropic:  # a few more squares
        pull = (
            np.diag(np.where(_ROWS == _COLUMNS, np.sqrt(0.5), 1.0))
            if problem.distance == "pullback"
            else T
        )
        left.append(np.sqrt(problem.gamma) * pull)
        right.append(left[1] @ np.where(_ROWS == _COLUMNS, 1.0, 0.0))
    compiled, X, A, b, gamma, E = _compiled(entropic, problem.ellipsoid is not None)
    stacked, target = np.vstack(left) / size, np.concatenate(right) / size
    empty = 21 - len(stacked)
    A.value = np.vstack((stacked, np.zeros((empty, 10))))
    b.value = np.concatenate((target, np.zeros(empty)))
    gamma.value = problem.gamma / size**2
    if problem.ellipsoid is not None:
        E.value = G.T @ problem.ellipsoid @ G
    tight = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), 1e-11)
    try:
        # "may be inaccurate": see the status
        with warnings.catch_warnings(action="ignore", category=UserWarning):
            compiled.solve(cvxpy.CLARABEL, **tight, max_iter=200)
        status, found = compiled.status, X.value
    except cvxpy.SolverError as error:
        status, found = str(error), None
    values, axes = np.linalg.eigh(np.eye(4) if found is None else found)
    P = G @ (axes * np.maximum(values, 1e-15)) @ axes.T @ G.T
    if problem.ellipsoid is not None:  # towards G G', inside, as far as need be
        here = np.sum(P * problem.ellipsoid)
        there = np.sum(problem.P0 * problem.ellipsoid)
        share = -here / (there - here) if here < 0.0 else 0.0
        P = (1.0 - share) * P + share * problem.P0
    return Optimum(problem.objective(P), P, status)


@dataclass(frozen=True)
class Case:
    """One random situation: an object, how it is moved and what is known of it."""

    label: str
    measurements: Measurements
    body: InertialParameters
    shape: Shape
    noise: Noise | np.ndarray | None
    bias: str

    @property
    def rows(self) -> tuple[np.ndarray, np.ndarray]:
        """A (r, 10), b (r,)"""
        return rows(self.measurements, self.noise, self.bias == "estimate")


def case(seed: int) -> Case:
    """Situation number `seed`: 1 g to 50 kg, 1 cm to 1 m, of all, two, one or no
    dimensions; 4 to 150 samples at rest, slow or fast, with no noise or up to the
    paper's high one in motion and wrench, which is known or not."""
    rng = np.random.default_rng([1918, seed])
    mass, size = 10 ** rng.uniform(-3.0, 1.7), 10 ** rng.uniform(-2.0, 0.0)
    layout = str(rng.choice(["solid", "flat", "rod", "point"]))
    level = str(rng.choice(list(NOISE_LEVELS)))
    K = int(rng.choice([4, 10, 40, 150]))
    known = str(rng.choice(["unknown", "levels", "covariance"]))
    bias = "estimate" if rng.random() < 0.4 else "none"
    speed = 0.0 if rng.random() < 0.15 else 10 ** rng.uniform(-1.5, 0.7)
    points = 0.5 * size * rng.uniform(-1.0, 1.0, (1 if layout == "point" else 12, 3))
    points[:, {"solid": 3, "flat": 2, "rod": 1, "point": 3}[layout] :] = 0.0
    points = points @ Rotation.random(random_state=rng).as_matrix() + size * rng.normal(
        size=3
    )
    body = InertialParameters.from_points(
        points, mass * rng.dirichlet(np.ones(len(points)))
    )
    offset = (
        rng.normal(size=6) * (5.0, 5.0, 5.0, 0.5, 0.5, 0.5)
        if bias == "estimate"
        else 0.0
    )
    z = with_wrench(random_motion(rng, K, speed), body, offset)
    z = z.with_noise(NOISE_LEVELS[level], [1918, seed])
    noise = None
    if known == "levels":
        noise = NOISE_LEVELS["moderate"]
    elif known == "covariance":
        root = rng.normal(size=(6, 6)) * (0.1, 0.1, 0.1, 0.005, 0.005, 0.005)
        noise = root.T @ root + np.diag(np.repeat((1e-3, 1e-6), 3))
    label = (
        f"case {seed}: {layout}, {mass:.2g} kg, {size:.2g} m, "
        f"{K} samples at speed {speed:.2g}, noise {level} ({known})"
    )
    return Case(f"{label}, bias {bias}", z, body, Shape(points), noise, bias)


def thickened(P: np.ndarray) -> np.ndarray:
    """Pseudo-inertia P (4, 4) of a body at least 1/1000 of its length thick, as GEO
    documents."""
    m, c = P[3, 3], P[:3, 3] / P[3, 3]
    variances, axes = np.linalg.eigh(P[:3, :3] / m - np.outer(c, c))
    variances = np.maximum(variances, max(1e-6 * variances[2], 1e-4**2 / 12.0))
    Sigma = m * ((axes * variances) @ axes.T + np.outer(c, c))
    return np.block([[Sigma, m * c[:, None]], [m * c, m]])


def geo_case(seed: int) -> tuple[str, GEO, Measurements, Problem]:
    """Problem number `seed` for GEO: priors given or of a shape, right or wrong; any
    distance, any weight."""
    rng = np.random.default_rng([2019, seed])
    known = case(seed)
    A, b = known.rows
    distance = str(rng.choice(["entropic", "pullback", "euclidean"], p=[0.6, 0.2, 0.2]))
    gamma = float(b @ b) * 10 ** rng.uniform(-10.0, 1.0) if rng.random() < 0.6 else None
    prior, shape = None, None
    if rng.random() < 0.5:
        shape = known.shape
        P0 = measured_mass(A, b, shape.homogeneous.vector) * pseudo_inertia(
            shape.homogeneous.vector
        )
    else:
        off = known.shape.positions + 0.1 * np.ptp(known.shape.positions) * rng.normal(
            size=3
        )
        masses = (
            known.body.mass
            * 10 ** rng.normal(0.0, 0.3)
            * np.full(known.shape.n, 1.0 / known.shape.n)
        )
        prior = InertialParameters.from_points(off, masses)
        P0 = pseudo_inertia(prior.vector)
    estimator = GEO(shape, prior, distance, gamma, known.bias, known.noise)
    if gamma is None:
        gamma = (
            30.0
            if known.noise is not None and distance != "euclidean"
            else 1e-5 * trace_rule(A)
        )
    label = f"{known.label}; {distance}, gamma {gamma / (b @ b):.2g} |b|², {'shape' if prior is None else 'prior'}"
    return (
        label,
        estimator,
        known.measurements,
        Problem(A, b, thickened(P0), gamma, distance),
    )


def trace_rule(A: np.ndarray) -> float:
    """tr(A'A) with products of inertia, which a tensor holds twice, counted half."""
    return float(np.sum(A**2) - 0.5 * np.sum(A[:, [5, 6, 8]] ** 2))


def measured_mass(A: np.ndarray, b: np.ndarray, homogeneous: np.ndarray) -> float:
    """Mass by least squares; if that is none, over multiples of a body (10,); or else
    1/1000 of what explains |b|."""
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0.0] = 1.0
    mass = (np.linalg.lstsq(A / scale, b, rcond=1e-9)[0] / scale)[0]
    column = A @ homogeneous
    if mass <= 0.0:
        mass = column @ b / (column @ column)
    return mass if mass > 0.0 else 1e-3 * np.linalg.norm(b) / np.linalg.norm(column)


def lmi_case(seed: int) -> tuple[str, LMI, Measurements, Problem]:
    """Problem number `seed` for LMI, half of them with a shape: its box may lie off the
    body."""
    rng = np.random.default_rng([2017, seed])
    known = case(seed)
    shape, ellipsoid, P0 = None, None, thickened(pseudo_inertia(known.body.vector))
    if rng.random() < 0.5:
        low, high = known.shape.positions.min(axis=0), known.shape.positions.max(axis=0)
        axes = np.sqrt(3.0) * np.maximum(0.5 * (high - low), 5e-4)
        centre = 0.5 * (low + high) + float(rng.choice([0.0, 0.5])) * (high - low)
        shape = Shape(known.shape.positions + (centre - 0.5 * (low + high)))
        to_unit = np.diag((*(1.0 / axes), 1.0)) @ np.block(
            [[np.eye(3), -centre[:, None]], [np.zeros(3), np.ones(1)]]
        )
        ellipsoid = to_unit.T @ np.diag((-1.0, -1.0, -1.0, 1.0)) @ to_unit
        inside = np.linalg.inv(to_unit)
        P0 = known.body.mass * inside @ np.diag((0.2, 0.2, 0.2, 1.0)) @ inside.T
    label = f"{known.label}; {'no ellipsoid' if shape is None else 'ellipsoid'}"
    return (
        label,
        LMI(shape, known.bias, known.noise),
        known.measurements,
        Problem(*known.rows, P0, ellipsoid=ellipsoid),
    )


def lowest(vector: np.ndarray) -> float:
    """Least eigenvalue of the pseudo-inertia of 1 kg, in units of its root-mean-square
    distance from the origin."""
    P = pseudo_inertia(vector)
    if not (P[3, 3] > 0.0 and np.trace(P[:3, :3]) >= 0.0):
        return -np.inf
    P /= P[3, 3]
    scale = np.array([1.0 / np.sqrt(np.trace(P[:3, :3]) or 1.0)] * 3 + [1.0])
    return float(np.linalg.eigvalsh(P * np.outer(scale, scale))[0])


def assert_optimal(label: str, found: Estimate, problem: Problem) -> tuple[bool, bool]:
    """A body, truthful about its objective, proven optimal and no worse than the
    oracle's.

    Returns whether the oracle solved the problem by its own measure, and whether it
    came as low.
    """
    certificate = found.certificate
    objective = problem.objective(pseudo_inertia(found.parameters.vector))
    # rounding of the ten parameters, magnified where a prior is thin
    rounding = 1e-13 * problem.size + 1e-9 * objective
    if problem.gamma > 0.0:
        rounding += 1e-16 * np.linalg.cond(problem.P0) * objective
    assert abs(certificate.objective - objective) <= rounding, label
    assert certificate.converged, (label, certificate)
    assert certificate.gap <= problem.tolerance(certificate.objective), (
        label,
        certificate,
    )
    assert found.physically_consistent, label
    # rounding of ten parameters, whose P has size one
    assert lowest(found.parameters.vector) >= -1e-13, label
    optimum = solve(problem)
    allowed = problem.tolerance(optimum.upper)
    assert certificate.objective <= optimum.upper + allowed, (
        label,
        certificate,
        optimum.upper,
    )
    assert certificate.bound <= optimum.upper + allowed, (
        label,
        certificate,
        optimum.upper,
    )
    return optimum.status == "optimal", optimum.upper <= certificate.objective + allowed

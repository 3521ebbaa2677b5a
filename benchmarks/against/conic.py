"""CVXPY with Clarabel: PMD, GEO, LMI and least squares.

*As stated*: a row for each component of each sample, the problem written down for every
recording. *Reduced*: the same rows brought to eleven by a QR factorisation, of which a
sum of squares needs ten, and the problem compiled once for all recordings of an object,
with parameters for what differs: the fastest set-up that was found. Both solve the same
problem, to Clarabel's default tolerance; tighter ones change no digit that is shown.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from benchmarks.against.ours import BARE
from benchmarks.against.party import Answer, NoAnswerError, Party, Task
from benchmarks.conic import paper_matrices
from benchmarks.estimators import body
from hefting.core.inertia import InertialParameters
from hefting.core.regressor import full_regressor
from hefting.core.spatial import Array
from hefting.estimators import PMD
from hefting.estimators.geo import GAMMA

STATED, REDUCED = "", ", reduced"
"""What the names of parties end with."""


def weighted_rows(task: Task) -> tuple[Array, Array]:
    """A (6 K, 10) and b (6 K,), each row divided by its noise."""
    levels = np.repeat((task.noise.force, task.noise.torque), 3)
    A = full_regressor(task.z) / levels[:, None]
    return A.reshape(-1, 10), (task.z.wrench / levels).ravel()


def reduced_rows(A: Array, b: Array, count: int = 11) -> tuple[Array, Array]:
    """Eleven rows of the same |A phi - b|; the first ten are those with phi in them."""
    R = np.linalg.qr(np.column_stack((A, b)), mode="r")
    rows = np.zeros((11, A.shape[1] + 1))
    rows[: len(R)] = R
    return rows[:count, :-1], rows[:count, -1]


def solved(problem: cp.Problem, vector: cp.Expression) -> Answer:
    """By Clarabel, to its default tolerance; what it calls inaccurate is taken."""
    with warnings.catch_warnings(action="ignore", category=UserWarning):
        try:
            problem.solve(solver=cp.CLARABEL)
        except cp.SolverError as error:
            raise NoAnswerError(str(error)) from error
    if vector.value is None:
        raise NoAnswerError(str(problem.status))
    return Answer(InertialParameters(np.asarray(vector.value, dtype=float)))


# GEO, LMI and least squares: |A phi - b|² and what the method adds


@dataclass(frozen=True, eq=False)
class Quadratic:
    """A problem in ten parameters: what is minimised besides the squares, and where."""

    phi: cp.Expression
    """(10,)"""
    penalty: cp.Expression | float
    constraints: tuple[cp.Constraint, ...] = ()


def least_squares(prior: cp.Parameter | Array) -> Quadratic:
    """No more than the squares."""
    return Quadratic(cp.Variable(10), 0.0)


def lmi(prior: cp.Parameter | Array) -> Quadratic:
    """Over the bodies that can exist (Wensing et al. 2018)."""
    P, phi = body()
    return Quadratic(phi, 0.0, (P >> 0,))


def geo(prior: cp.Parameter | Array) -> Quadratic:
    """The entropic distance from a prior body whose pseudo-inertia has the inverse
    `prior` (Lee et al. 2020), less its constants."""
    P, phi = body()
    return Quadratic(phi, GAMMA * (cp.trace(prior @ P) - cp.log_det(P)))


def inverse_prior(task: Task, A: Array, b: Array) -> Array:
    """(4, 4) inverse pseudo-inertia of the homogeneous body, as heavy as least squares
    says."""
    mass = np.linalg.lstsq(A, b, rcond=None)[0][0]
    return np.linalg.inv(mass * task.shape.homogeneous.pseudo_inertia)


Statement = Callable[[cp.Parameter | Array], Quadratic]


def posed(stated: Quadratic, A: object, b: object) -> cp.Problem:
    """The problem over rows A and b."""
    squares = cp.sum_squares(A @ stated.phi - b)  # type: ignore[operator]
    return cp.Problem(cp.Minimize(squares + stated.penalty), list(stated.constraints))


def as_stated(statement: Statement) -> Callable[[Task, None], Answer]:
    """Identify by all rows."""

    def identify(task: Task, _: None) -> Answer:
        A, b = weighted_rows(task)
        stated = statement(inverse_prior(task, A, b) if statement is geo else np.eye(4))
        return solved(posed(stated, A, b), stated.phi)

    return identify


@dataclass(frozen=True, eq=False)
class Compiled:
    """A problem that was compiled, and what a recording fills in."""

    problem: cp.Problem
    vector: cp.Expression
    rows: tuple[cp.Parameter, ...]
    """A and b, of each norm"""
    prior: cp.Parameter | None = None


def compiled(statement: Statement) -> Compiled:
    """With parameters for ten rows and the prior; solved once, which compiles it."""
    A, b = cp.Parameter((10, 10)), cp.Parameter(10)
    prior = cp.Parameter((4, 4))
    stated = statement(prior)
    problem = posed(stated, A, b)
    A.value, b.value = np.eye(10), np.ones(10)
    prior.value = np.eye(4)
    problem.solve(solver=cp.CLARABEL)
    return Compiled(problem, stated.phi, (A, b), prior)


def reduced(task: Task, ready: Compiled) -> Answer:
    """Identify by ten rows, lengths in units of the longest side: without, solutions
    on the boundary are up to 1e-4 beyond it."""
    A, b = reduced_rows(*weighted_rows(task), count=10)
    side = float(task.shape.extents.max())
    units = np.repeat((1.0, side, side**2), (1, 3, 6))
    ready.rows[0].value, ready.rows[1].value = A * units, b
    assert ready.prior is not None
    lengths = np.array((side, side, side, 1.0))
    ready.prior.value = inverse_prior(task, A, b) * np.outer(lengths, lengths)
    found = solved(ready.problem, ready.vector).body.vector
    return Answer(InertialParameters(units * found))


# PMD: two norms, not squared, over masses that are not negative


def pmd_as_stated(task: Task, _: None) -> Answer:
    """Problem 1 of Nadeau et al. 2022, by all rows of both models."""
    pmd = PMD(task.shape)
    A0, b0, A1, b1 = paper_matrices(pmd, task.z)
    masses = cp.Variable(A0.shape[1], nonneg=True)
    norms = cp.norm(A0 @ masses - b0) + cp.norm(A1 @ masses - b1)
    problem = cp.Problem(cp.Minimize(norms + pmd.regularization * cp.norm(masses)))
    return solved(problem, task.shape.matrix @ masses)


def pmd_compiled(task: Task) -> Compiled:
    """For the points of the object."""
    pmd, M = PMD(task.shape), task.shape.matrix
    masses, phi = cp.Variable(M.shape[1], nonneg=True), cp.Variable(10)
    rows = tuple(cp.Parameter(size) for size in ((11, 10), 11, (11, 10), 11))
    A0, b0, A1, b1 = rows
    norms = cp.norm(A0 @ phi - b0) + cp.norm(A1 @ phi - b1)
    penalty = pmd.regularization * cp.norm(masses)
    problem = cp.Problem(cp.Minimize(norms + penalty), [phi == M @ masses])
    for each in rows:
        each.value = np.ones(each.shape)
    problem.solve(solver=cp.CLARABEL)
    return Compiled(problem, phi, rows)


def pmd_reduced(task: Task, ready: Compiled) -> Answer:
    """The same norms of eleven rows each."""
    from hefting.core.regressor import full_model_weight, reduced_regressor

    z = task.z
    w = full_model_weight(z, PMD(task.shape).c1)[:, None]
    parts = ((1.0 - w, reduced_regressor(z)), (w, full_regressor(z)))
    values = [
        value
        for u, A in parts
        for value in reduced_rows(
            (u[:, :, None] * A).reshape(-1, 10), (u * z.wrench).ravel()
        )
    ]
    for parameter, value in zip(ready.rows, values, strict=True):
        parameter.value = value
    return solved(ready.problem, ready.vector)


STATEMENTS: dict[str, Statement] = {"GEO": geo, "LMI": lmi, "OLS": least_squares}


def parties() -> list[Party]:
    """Each method as stated and reduced."""

    def party(method: str, how: str, identify, prepare=lambda task: None) -> Party:
        return Party(
            f"CVXPY + Clarabel {method}{how}",
            identify,
            prepare,
            beside=f"Hefting {method}{BARE}",
            peer=True,
            method="CVXPY + Clarabel" + how,
            calls=1 if how == STATED else 3,
        )

    found = [
        party("PMD", STATED, pmd_as_stated),
        party("PMD", REDUCED, pmd_reduced, pmd_compiled),
    ]
    for method, statement in STATEMENTS.items():
        found.append(party(method, STATED, as_stated(statement)))
        prepare = lambda task, s=statement: compiled(s)  # noqa: E731
        found.append(party(method, REDUCED, reduced, prepare))
    return found

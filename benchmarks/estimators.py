"""The estimators beside PMD: GEO and LMI against their problems as stated to CVXPY and
Clarabel, and all from moments.

The targets of 1 and 2 ms were set where Pinocchio's regressor with `lstsq` takes 2.4 ms
over 1,000 samples: see `benchmarks.streaming`. The time of an estimate from the moments
should not depend on the samples folded into them.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import cvxpy as cp
import numpy as np

from benchmarks.least_squares import with_pinocchio
from benchmarks.problem import RATE, shape, wielded
from benchmarks.report import Row, Section, faster
from benchmarks.timing import Party, compare
from hefting import GEO, HPS, LMI, OLS, RTLS
from hefting.core.measurements import DIMENSIONS, NOISE_LEVELS, Measurements
from hefting.core.regressor import full_regressor
from hefting.core.spatial import Array
from hefting.estimators.base import Estimator
from hefting.estimators.geo import GAMMA, weight_by_rule
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, sinusoids, wield

NOISE = NOISE_LEVELS["moderate"]
REFERENCE = 2.4e-3
"""What Pinocchio and `lstsq` take over 1,000 samples where the targets were set [s]."""


@dataclass(frozen=True)
class Conic:
    """What the conic solver found."""

    optimum: float
    seconds: float
    """as Clarabel itself reports"""


def rows(measurements: Measurements, whitened: bool) -> tuple[Array, Array]:
    """A (6 K, 10) and b (6 K,) of all samples, each divided by its noise level if
    `whitened`."""
    levels = np.repeat((NOISE.force, NOISE.torque), 3) if whitened else np.ones(6)
    A = full_regressor(measurements) / levels[:, None]
    return A.reshape(-1, 10), (measurements.wrench / levels).ravel()


def body() -> tuple[cp.Variable, cp.Expression]:
    """A symmetric pseudo-inertia P (4, 4) and its ten parameters."""
    P = cp.Variable((4, 4), symmetric=True)
    J = cp.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
    return P, cp.hstack(
        [
            P[3, 3],
            P[0, 3],
            P[1, 3],
            P[2, 3],
            J[0, 0],
            J[0, 1],
            J[0, 2],
            J[1, 1],
            J[1, 2],
            J[2, 2],
        ]
    )


def solved(problem: cp.Problem) -> Conic:
    """By Clarabel, to its default tolerance."""
    problem.solve(solver=cp.CLARABEL)
    optimum, seconds = np.asarray(
        (problem.value, problem.solver_stats.solve_time), dtype=float
    )
    return Conic(float(optimum), float(seconds))


def lmi_as_stated(A: Array, b: Array) -> Conic:
    """|A phi - b|² over P >= 0 (Wensing et al. 2018)."""
    P, phi = body()
    return solved(cp.Problem(cp.Minimize(cp.sum_squares(A @ phi - b)), [P >> 0]))


def geo_as_stated(A: Array, b: Array, gamma: float | None) -> Conic:
    """|A phi - b|² + gamma (tr(P0^-1 P) - log det(P0^-1 P) - 4); P0 is homogeneous, as
    heavy as least squares says.

    gamma None: by `weight_by_rule`.
    """
    P, phi = body()
    gamma = weight_by_rule(A) if gamma is None else gamma
    P0 = np.linalg.lstsq(A, b, rcond=None)[0][0] * shape(56).homogeneous.pseudo_inertia
    distance = (
        cp.trace(np.linalg.inv(P0) @ P)
        - cp.log_det(P)
        + float(np.linalg.slogdet(P0)[1])
        - 4.0
    )
    return solved(
        cp.Problem(cp.Minimize(cp.sum_squares(A @ phi - b) + gamma * distance))
    )


def geo_against_conic_solver(samples: int, rounds: int) -> list[Section]:
    """With the default weight of the prior beside known noise, and with the rule for
    unknown noise."""
    z, points = wielded(3500)[:samples], shape(56)
    known = partial(geo_as_stated, *rows(z, whitened=True), GAMMA)
    unknown = partial(geo_as_stated, *rows(z, whitened=False), None)
    return [
        against_conic_solver(
            "GEO, known noise",
            GEO(points, noise=NOISE, intervals=False),
            z,
            known,
            rounds,
            at_least=100.0,
        ),
        against_conic_solver(
            "GEO, unknown noise",
            GEO(points, intervals=False),
            z,
            unknown,
            rounds,
            at_least=100.0,
        ),
    ]


def lmi_against_conic_solver(samples: int, rounds: int) -> list[Section]:
    """Where least squares finds no body, so that the constraint is active, and where it
    finds one."""
    fast = wield(
        UR5.motion(sinusoids(samples / RATE, RATE, angular_speed=4.0)),
        hammer().parameters,
    )
    sections = []
    for active, z in (
        (True, wielded(3500)[:samples]),
        (False, fast.with_noise(NOISE, seed=1)),
    ):
        title = f"LMI, constraint {'' if active else 'in'}active"
        statement = partial(lmi_as_stated, *rows(z, False))
        section = against_conic_solver(
            title, LMI(intervals=False), z, statement, rounds, at_least=25.0
        )
        margin = OLS().fit(z).parameters.consistency().margins["pseudo_inertia"]
        low, high = (None, 0.0) if active else (0.0, None)
        row = Row(
            "margin by which least squares is a body",
            figure=margin,
            at_least=low,
            at_most=high,
        )
        sections.append(replace(section, rows=(*section.rows, row)))
    return sections


def against_conic_solver(
    title: str,
    estimator: Estimator,
    z: Measurements,
    statement: Callable[[], Conic],
    rounds: int,
    at_least: float,
) -> Section:
    """`estimator` and the conic solver on the same samples; its matrices of all samples
    are given to it ready-made."""
    times = compare(
        {
            "conic": Party(lambda _: statement()),
            "estimate": Party(
                estimator.estimate,
                lambda: estimator.update(estimator.start(), z),
                calls=20,
            ),
            "fit": Party(lambda _: estimator.fit(z), calls=20),
        },
        rounds,
    )
    conic, estimate, fit = times["conic"], times["estimate"], times["fit"]
    solver = float(np.median([found.seconds for found in conic.results]))
    certificate, optimum = estimate.results[-1].certificate, conic.results[-1].optimum
    return Section(
        f"{title}, {len(z):,} samples",
        (
            Row("the problem as stated: CVXPY and Clarabel", conic),
            Row("  of which Clarabel itself, without CVXPY", figure=solver, unit="s"),
            faster("Hefting, from the moments", estimate, conic, at_least),
            Row("  against Clarabel itself", figure=solver / estimate.median, unit="x"),
            faster("Hefting, folding the samples included", fit, conic),
            Row("linear systems solved", figure=float(certificate.iterations)),
            Row(
                "objective, relative difference",
                figure=abs(certificate.objective / optimum - 1.0),
                at_most=1e-6,
            ),
        ),
    )


def labelled_parts() -> Shape:
    """The hammer's points in three parts: handle, and the head on either side of it."""
    points = shape(56)
    x, _, z = points.positions.T
    return replace(points, labels=np.where(z < 0.26, 0, np.where(x < 0.0, 1, 2)))


def from_the_moments(samples: int, many: int, rounds: int) -> list[Section]:
    """Every estimator from the moments of so many samples, and from those of ten and of
    `many`."""
    long, z = wielded(many), wielded(3500)[:samples]
    estimators: dict[str, tuple[Estimator, float | None]] = {
        "OLS": (OLS(intervals=False), None),
        "RTLS": (RTLS(intervals=False), 1e-3),
        "HPS, 3 parts": (HPS(labelled_parts(), intervals=False), 1e-3),
        "GEO, known noise": (GEO(shape(56), noise=NOISE, intervals=False), 2e-3),
        "GEO, unknown noise": (GEO(shape(56), intervals=False), 2e-3),
        "LMI, constraint active": (LMI(intervals=False), 2e-3),
    }
    return [
        one_from_the_moments(name, *chosen, z, long, rounds)
        for name, chosen in estimators.items()
    ]


def one_from_the_moments(
    name: str,
    estimator: Estimator,
    at_most: float | None,
    z: Measurements,
    long: Measurements,
    rounds: int,
) -> Section:
    """Ten samples are spread over the motion of `z`, the many are `long`."""
    parties = {}
    for key, chosen in (("few", z[:: len(z) // 10]), ("z", z), ("long", long)):
        state = estimator.update(estimator.start(), chosen)
        parties[key] = Party(estimator.estimate, lambda state=state: state, calls=5)
    yardstick = wielded(3500)[:1000]
    arrays = tuple(
        getattr(yardstick, field) for field in DIMENSIONS if field != "weights"
    )
    times = compare(
        {"pinocchio": Party(lambda _: with_pinocchio(arrays))} | parties, rounds
    )
    few = times["few"]
    ours = times["z"]
    many = times["long"]
    theirs = times["pinocchio"]
    in_yardsticks = None if at_most is None else REFERENCE / at_most
    return Section(
        f"{name}, from the moments",
        (
            Row(
                f"estimate, {len(z):,} samples", ours, ours.median, "s", at_most=at_most
            ),
            Row("Pinocchio and lstsq over 1,000 samples", theirs),
            Row(
                "  over the estimate",
                figure=theirs.median / ours.median,
                unit="x",
                at_least=in_yardsticks,
            ),
            Row("10 samples, over 1,000", few, few.median / ours.median, at_most=1.5),
            Row(
                f"{len(long):,} samples, over 1,000",
                many,
                many.median / ours.median,
                at_most=1.5,
            ),
        ),
    )

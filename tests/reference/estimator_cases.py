"""Cases of `hefting.estimators` but for Bayes: every method and model, of several sets
of measurements."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from hammers import shape
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements, Noise
from hefting.core.regressor import full_regressor, predict_wrench
from hefting.estimators import GEO, HPS, LMI, OLS, PMD, RTLS, Estimator
from hefting.estimators.joint_state import WhitenedState
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.quadratic import Quadratic
from hefting.estimators.rtls import column_levels
from hefting.estimators.sample_state import SampleState, model_weight
from hefting.estimators.state_likelihood import StateSamples
from hefting.shapes import Shape
from hefting.simulation import hammer
from random_problems import random_body
from reference.held import (
    BIAS,
    TOOL,
    biased,
    box,
    coloured,
    covariance_of_tool,
    dynamic,
    few,
    fine,
    parts,
    slow,
)

NOISE = Noise(0.1, 0.005, 0.05, 0.5)
"""Of the wrench and the accelerations."""
COVARIANCE = np.diag((0.01, 0.02, 0.03, 3e-5, 2e-5, 1e-5)) + 1e-6
"""Of the wrench, with noise that channels share."""
PLANE = Shape(shape().positions * (1.0, 1.0, 0.0))
"""Points in a plane, which leave an inertia open."""
POSSIBLE = random_body(np.random.default_rng(30), 0.6, 0.08, 0.03)


def estimated(
    estimator: Estimator, measurements: Callable[[], Measurements]
) -> Estimate:
    """The estimate of one set of measurements."""
    return estimator.fit(measurements())


def of_two(estimator: Estimator) -> Estimate:
    """The estimate of two recordings."""
    states = [estimator.update(estimator.start(), z) for z in (dynamic(), biased())]
    return estimator.estimate(estimator.merge_all(states))


def poor() -> Measurements:
    """Few poses at rest that hardly differ, with a bias: the mass is poorly known."""
    z = slow()[:9]
    gravity = z.gravity[0] + 0.12 * (z.gravity - z.gravity[0])
    noise = z.wrench - predict_wrench(z, hammer().parameters.vector)
    wrench = noise + BIAS
    wrench += predict_wrench(replace(z, gravity=gravity), hammer().parameters.vector)
    return replace(z, gravity=gravity, force=wrench[:, :3], torque=wrench[:, 3:])


METHODS: dict[str, Callable[..., Estimator]] = {
    "OLS": OLS,
    "OLS-blended": partial(OLS, model="blended", c1=50.0),
    "OLS-reduced": partial(OLS, model="reduced"),
    "RTLS": RTLS,
    "GEO": partial(GEO, shape()),
    "GEO-blended": partial(GEO, box(), model="blended"),
    "LMI": LMI,
    "LMI-ellipsoid": partial(LMI, box()),
    "PMD": partial(PMD, shape()),
    "PMD-full": partial(PMD, shape(), model="full", regularization=0.01),
    "HPS": partial(HPS, parts(), max_acceleration=3.0, max_angular_acceleration=10.0),
}
"""How each is made of a bias and more."""
SETS: Mapping[str, Callable[[], Measurements]] = {
    "dynamic": dynamic,
    "slow": slow,
    "few": few,
}
"""Sets of measurements without a bias."""
OTHERS: Mapping[str, Callable[[], Estimate]] = {
    "OLS known noise": lambda: estimated(OLS(noise=COVARIANCE), dynamic),
    "OLS coloured": lambda: estimated(OLS("estimate"), coloured),
    "OLS weighed": lambda: estimated(OLS("estimate", mass=(0.671, 2e-3)), biased),
    "OLS tool": lambda: estimated(
        OLS(
            "estimate",
            systematic=covariance_of_tool(),
            carried=TOOL,
            sensor_accuracy="1% 0.3N 0.01Nm",
        ),
        biased,
    ),
    "OLS no intervals": lambda: estimated(OLS(intervals=False), dynamic),
    "RTLS known noise": lambda: estimated(RTLS(noise=NOISE), dynamic),
    "GEO euclidean": lambda: estimated(GEO(box(), distance="euclidean"), dynamic),
    "GEO prior": lambda: estimated(GEO(prior=POSSIBLE, gamma=3.0, noise=NOISE), slow),
    "LMI known noise": lambda: estimated(LMI(noise=COVARIANCE), few),
    "PMD fine": lambda: estimated(PMD(fine(), c1=30.0), dynamic),
    "PMD plane": lambda: estimated(
        PMD(PLANE, regularization=0.0, intervals=False), few
    ),
    "PMD smooth": lambda: estimated(PMD(shape(), regularization=30.0), slow),
    "PMD smoothest": lambda: estimated(PMD(shape(), regularization=1e5), dynamic),
    "PMD weighed": lambda: estimated(PMD(shape(), mass=(0.65, 1e-2)), slow),
    "HPS known noise": lambda: estimated(HPS(parts(), noise=COVARIANCE), slow),
}
"""Hyperparameters that the others do not have."""


def parts_of_least_squares() -> dict[str, Any]:
    """What estimates are made of."""
    z = replace(biased(), motion_noise=None)
    weight = model_weight(z, "blended", 20.0)
    state = SampleState.of(z, weight)
    recorded = SampleState.empty(True).fold(biased())
    quadratic = Quadratic.of(state, COVARIANCE, free_bias=True)
    vector = quadratic.least_squares()
    row = np.concatenate(([30.0], np.zeros(9), [20.0]))
    full = SampleState.empty(True).fold(dynamic())
    samples = StateSamples.of(full, False, None, None, None)
    return {
        "weight": weight,
        "state": state,
        "merged": recorded.merge(
            SampleState.empty(True).fold(dynamic()), one_bias=True
        ),
        "scaled": full.scaled(0.3),
        "record": recorded,
        "vector": vector,
        "square": quadratic.square(vector),
        "bias": quadratic.bias(vector),
        "with mass": quadratic.with_equation(row).least_squares(),
        "mass": quadratic.measured_mass(shape().homogeneous.vector),
        "levels": column_levels(NOISE),
        "likelihood": samples and samples.likelihood(vector),
    }


def possible_bodies() -> dict[str, Any]:
    """What methods take an object to be."""
    com = POSSIBLE.center_of_mass
    found = {
        "any": PossibleBodies.any(com),
        "near": PossibleBodies.near(POSSIBLE),
        "in box": PossibleBodies.in_box(POSSIBLE),
        "in shape": PossibleBodies.in_shape(shape()),
        "of parts": PossibleBodies.of_parts(parts(), HPS(parts())._shares),
    }
    return found | {f"{name} or any": each.or_any(com) for name, each in found.items()}


def whitened() -> dict[str, Any]:
    """Methods that take equations in place of samples."""
    z = dynamic()
    rows = full_regressor(z).reshape(-1, 10) / 0.1
    information, score = rows.T @ rows, rows.T @ z.wrench.ravel() / 0.1
    state = WhitenedState.of_information(
        information, score, len(z), float(np.ptp(z.time)), 1.3
    )
    return {
        "state": state,
        "OLS": OLS().estimate(state),
        "PMD": PMD(shape()).estimate(state),
        "LMI": LMI().estimate(state),
    }


CASES: dict[str, Callable[[], Any]] = {
    **{
        f"{name} {label}": partial(estimated, method(), measurements)
        for name, method in METHODS.items()
        for label, measurements in SETS.items()
    },
    **{
        f"{name} biased": partial(estimated, method(bias="estimate"), biased)
        for name, method in METHODS.items()
    },
    **{
        f"{name} two": partial(of_two, method(bias="estimate"))
        for name, method in METHODS.items()
    },
    **{
        f"{name} poor": partial(estimated, method(bias="estimate"), poor)
        for name, method in METHODS.items()
    },
    **OTHERS,
    "parts": parts_of_least_squares,
    "possible bodies": possible_bodies,
    "whitened": whitened,
}
"""By name."""

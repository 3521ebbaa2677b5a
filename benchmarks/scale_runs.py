"""One recording of a sensor whose gain is wrong, identified by each method with what a
scale shows and without."""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.bodies import Body
from benchmarks.method_runs import MethodRun, judged
from benchmarks.sensor_accuracy_runs import measured, methods
from hefting.core.errors import NotIdentifiableError
from hefting.core.messages import codes
from hefting.core.quantity import MassReading
from hefting.core.sensor_accuracy import SensorAccuracy

SHARES = (2e-4, 0.02)
"""Smallest and largest standard deviation of a scale over the mass: between a
letter scale and a luggage scale."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """One method's answers to one recording."""

    alone: MethodRun
    """by the wrench"""
    both: MethodRun
    """by wrench and scale"""
    contradicted: bool
    """whether the scale was said to contradict the wrench"""


def weighed(
    body: Body, accuracy: SensorAccuracy | None, seed: tuple[int, ...], others: bool
) -> list[Weighed]:
    """Wield a body once more, weigh it, and identify it; for the arguments see
    `benchmarks.sensor_accuracy_runs.identified`.

    The scale's standard deviation is drawn evenly from the logarithms of `SHARES`, its
    error from a Gaussian of that deviation.
    """
    z, free_bias = measured(body, accuracy, seed)
    rng = np.random.default_rng((*seed, 2))
    mass = body.parameters.mass
    std = mass * float(np.exp(rng.uniform(*np.log(SHARES))))
    reading = MassReading(mass + std * rng.normal(), std)
    bias = "estimate" if free_bias else "none"
    found: list[Weighed] = []
    for name, method in methods(body, others):
        told = replace(method, bias=bias, sensor_accuracy=accuracy)
        try:
            alone = told.fit(z)
            both = replace(told, mass=reading).fit(z)
        except NotIdentifiableError:
            continue
        runs = [
            replace(judged(body, each, free_bias), method=name)
            for each in (alone, both)
        ]
        found.append(
            Weighed(
                *runs,
                "mass-contradicts-wrench" in codes(both.warnings),
            )
        )
    return found

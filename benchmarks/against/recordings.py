"""The recordings that all parties get, and their truth."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from benchmarks.against.party import Task
from benchmarks.bodies import random_body
from benchmarks.things import THINGS
from hefting.core.accuracy import errors_between
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.core.spatial import Array
from hefting.shapes import Shape
from hefting.simulation import UR5, sinusoids, wield
from hefting.simulation.arm import SensorMotion

RATE = 100.0
"""Samples a second: 150 of them are the paper's 1.5 s."""
SPEED = 1.0
"""Mean angular speed of the paper's sinusoids [rad/s]."""
LEVEL = NOISE_LEVELS["moderate"]
"""The paper's, of wrench and accelerations."""
SEEDS = 6
"""Random tools of each kind."""
RANDOM, WORKSHOP = "random tools", "workshop tools"
"""Names of the sets."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """A recording of an object, and the truth."""

    name: str
    task: Task
    truth: InertialParameters
    extents: Array
    """(3,) sides of the object's bounding box [m]"""
    axes: Array
    """(3, 3) the axes of its file in the sensor frame"""

    def errors(self, body: InertialParameters) -> tuple[float, float, float]:
        """Of mass, COM and inertia about the sensor [%], as the paper has them."""
        e = errors_between(body, self.truth, self.extents, self.axes)
        return e.mass, e.center_of_mass, e.inertia_at_origin


@cache
def motion(samples: int) -> SensorMotion:
    """The paper's sinusoids, so many samples of them, the speed that of ten seconds."""
    seconds = max(samples, 1000) / RATE
    return UR5.motion(sinusoids(seconds, RATE, SPEED))


def given(
    exact: Measurements, shape: Shape, seed: int | Sequence[int], noisy: bool = True
) -> Task:
    """The task that exact measurements with the paper's moderate noise make; the
    measurements themselves do not say how noisy they are."""
    z = exact.with_noise(LEVEL, seed) if noisy else exact
    return Task(replace(z, noise=None), shape, LEVEL)


def random_tools(samples: int, seeds: int = SEEDS) -> list[Recorded]:
    """Hammers, drills, half-full bottles and dumbbells of random size, weight and
    grasp, `seeds` of each (`benchmarks.things`)."""
    return [
        random_tool(kind, seed, samples)
        for kind in THINGS
        for seed in range(1, seeds + 1)
    ]


def random_tool(kind: str, seed: int, samples: int, noisy: bool = True) -> Recorded:
    """One of them, with noise of its own."""
    body = random_body(kind, seed)
    exact = wield(motion(samples), body.parameters)[:samples]
    task = given(exact, body.shape, (seed, *kind.encode()), noisy)
    axes = body.shape.pose[:3, :3]
    return Recorded(f"{kind} {seed}", task, body.parameters, body.shape.extents, axes)


def workshop_tools(samples: int) -> list[Recorded]:
    """The twelve tools of `benchmarks.accuracy_tools`; none unless HEFTING_DATA names
    the folder that holds them."""
    data = Path(os.environ.get("HEFTING_DATA") or "no-recordings")
    if not (data / "workshop-tools").is_dir():
        return []
    from benchmarks.accuracy_tools import tools

    return [
        Recorded(
            tool.name,
            given(tool.samples[:samples], tool.shape, (3, i)),
            tool.scale.body,
            tool.scale.extents,
            tool.scale.axes,
        )
        for i, tool in enumerate(tools(data))
    ]

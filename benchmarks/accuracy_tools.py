"""Twelve workshop tools with white noise in wrench and accelerations; see
`benchmarks.accuracy`."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.cramer_rao import Scale, bound
from hefting.core.accuracy import errors_between
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from hefting.core.spatial import Array
from hefting.estimators import HPS, OLS, PMD, Bayes
from hefting.logs import read_log
from hefting.motion import measure
from hefting.shapes import Shape

GRAVITY = (0.0, 0.0, 9.81)
"""In the recordings' world, which is upside down [m/s²]."""
POINTS = 56
LEVELS = ("low", "moderate", "high")
SAMPLES = (150, 1000)
"""The first of the recording, 100 a second."""
NAMES = (
    "allen-key",
    "bent-jaw-pliers",
    "box-wrench",
    "c-clamp",
    "electronic-caliper",
    "file",
    "machinist-hammer",
    "measuring-tape",
    "pliers",
    "ruler",
    "socket-wrench",
    "vise-clamp",
)
"""Folders of the tools."""
HETEROGENEOUS = ("machinist-hammer", "file", "electronic-caliper", "vise-clamp")
"""Tools of more than one density."""
C1, REGULARIZATION = 300.0, 0.1
"""Of PMD in the paper's simulations."""
DRAWS = 2000
"""Of each tool's bound, to find medians by."""


@dataclass(frozen=True, eq=False)
class Tool:
    """A tool in the sensor frame."""

    name: str
    samples: Measurements
    """without noise: stop-and-go, 10 s at 100 Hz"""
    shape: Shape
    """its mesh as points"""
    parts: Shape
    """its labelled parts"""
    scale: Scale
    """its truth"""

    @classmethod
    def load(cls, folder: Path) -> "Tool":
        """One folder of the data set."""
        truth = json.loads((folder / "truth.json").read_text())
        pose = np.array(truth["object_pose_in_sensor"])
        shape = Shape.from_mesh(
            folder / "mesh.ply", unit="mm", pose=pose, points=POINTS
        )
        inertia = truth["inertia_at_sensor"]
        body = InertialParameters.from_origin(
            truth["mass"], truth["center_of_mass_sensor"], inertia
        )
        return cls(
            folder.name,
            measure(read_log(folder / "log.csv"), GRAVITY).measurements,
            shape,
            Shape.from_parts(folder / "parts.ply", pose=pose),
            Scale(body, np.asarray(shape.extents), pose[:3, :3]),
        )

    def errors(self, estimate: Estimate) -> Array:
        """(3,) [%] of mass, COM and inertia about the sensor."""
        e = errors_between(
            estimate.parameters, self.scale.body, self.scale.extents, self.scale.axes
        )
        return np.array((e.mass, e.center_of_mass, e.inertia_at_origin))


@dataclass(frozen=True, eq=False)
class Cell:
    """All tools and seeds with one level of noise and one number of samples."""

    level: str
    count: int
    tools: tuple[str, ...]
    errors: dict[str, Array]
    """(tools, seeds, 3) [%] of mass, COM and inertia by Bayes, PMD, weighted least
    squares with the true motion (WLS), and, of most samples, HPS"""
    bounds: dict[str, Array]
    """(tools, `DRAWS`, 3) [%] at the Cramér-Rao bound, the motion ``"known"`` and
    ``"noisy"``"""
    bound_means: dict[str, Array]
    """(tools, 3) [%] their means, in closed form"""

    def of(self, names: tuple[str, ...]) -> "Cell":
        """Of some tools only."""
        rows = [self.tools.index(name) for name in names]
        parts = (
            {k: v[rows] for k, v in each.items()}
            for each in (self.errors, self.bounds, self.bound_means)
        )
        return Cell(self.level, self.count, names, *parts)


def tools(data: Path) -> tuple[Tool, ...]:
    """Those of `NAMES` in the folder ``workshop-tools`` of `data`."""
    return tuple(Tool.load(data / "workshop-tools" / name) for name in NAMES)


def cells(subjects: tuple[Tool, ...], seeds: int) -> Iterator[Cell]:
    """By number of samples, then level of noise."""
    for count, level in product(SAMPLES, LEVELS):
        noise = NOISE_LEVELS[level]
        runs = [
            [_run(tool, i, count, noise, seed) for seed in range(seeds)]
            for i, tool in enumerate(subjects)
        ]
        errors = {
            name: np.array([[run[name] for run in row] for row in runs])
            for name in runs[0][0]
        }
        covariances = [_bounds(tool, count, noise) for tool in subjects]
        drawn, means = {}, {}
        for name in covariances[0]:
            each = list(zip(subjects, (c[name] for c in covariances), strict=True))
            drawn[name] = np.array(
                [t.scale.drawn_errors(c, DRAWS, i) for i, (t, c) in enumerate(each)]
            )
            means[name] = np.array([t.scale.mean_errors(c) for t, c in each])
        yield Cell(
            level, count, tuple(tool.name for tool in subjects), errors, drawn, means
        )


def _run(
    tool: Tool, index: int, count: int, noise: Noise, seed: int
) -> dict[str, Array]:
    """Errors (3,) [%] by method; Bayes, HPS and WLS are given the noise. In few samples
    HPS may find none at rest."""
    exact = tool.samples[:count]
    z = exact.with_noise(noise, (3, index, seed))
    wrench = Noise(noise.force, noise.torque)
    found = {
        "Bayes": Bayes(tool.shape, noise=noise).fit(z),
        "PMD": PMD(
            tool.shape, c1=C1, regularization=REGULARIZATION, intervals=False
        ).fit(z),
        "WLS": OLS(noise=wrench, intervals=False).fit(
            replace(exact, force=z.force, torque=z.torque)
        ),
    }
    if count == max(SAMPLES):
        found["HPS"] = HPS(tool.parts, noise=wrench, intervals=False).fit(z)
    return {name: tool.errors(estimate) for name, estimate in found.items()}


def _bounds(tool: Tool, count: int, noise: Noise) -> dict[str, Array]:
    """Covariances (10, 10) at the bound, the motion known and noisy."""
    exact, body = tool.samples[:count], tool.scale.body
    wrench = np.repeat(np.square((noise.force, noise.torque)), 3)
    motion = np.repeat(
        np.square((noise.linear_acceleration, noise.angular_acceleration)), 3
    )
    return {
        "known": bound(exact, body, wrench),
        "noisy": bound(exact, body, wrench, motion),
    }

"""HPS, OLS and GEO beside the figures their authors published for twelve tools (Nadeau,
Giamou & Kelly, ICRA 2023).

Theirs are one noisy run each. Their COM error drops the fraction of a percent on each
axis, and their GEO was given the true mass and a prior with the parallel-axis term
added twice; with that prior ours gives their figures.
"""

import json
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from hefting.core.regressor import full_regressor, reduced_regressor
from hefting.core.spatial import skew, tensor_to_vector
from hefting.estimators import GEO, HPS, OLS
from hefting.logs import read_log
from hefting.motion import measure
from hefting.shapes import Shape
from recordings import DATA, TOOL_FOLDERS, needs_recordings

pytestmark = needs_recordings

LEVELS = {
    "Low": NOISE_LEVELS["low"],
    "Mod": NOISE_LEVELS["moderate"],
    "High": replace(NOISE_LEVELS["high"], force=0.2, torque=0.01),
}
"""Their noise: the last is not that of the paper of 2022."""
HETEROGENEOUS = ("electronic-caliper", "file", "machinist-hammer", "vise-clamp")
SEEDS = 24


@dataclass(frozen=True)
class Tool:
    """A tool, its log, its labelled parts and its mesh as points."""

    name: str
    samples: Measurements
    parts: Shape
    mesh: Shape
    truth: InertialParameters

    @property
    def sides(self) -> np.ndarray:
        """Box (3,) as they measure errors by: the diagonal of the parts' box, turned
        into sensor axes."""
        return np.abs(self.parts.pose[:3, :3] @ self.parts.extents)

    def errors(self, found: InertialParameters) -> np.ndarray:
        """Errors (4,) [%]: mass, COM, inertia about the sensor's origin, and COM
        without fractions as published."""
        m, a = self.truth.mass, self.sides
        com = 100 * np.abs(found.center_of_mass - self.truth.center_of_mass) / a
        scale = m / 12 * (np.eye(3) * (a @ a) - np.outer(a, a))
        inertia = 100 * np.abs(
            tensor_to_vector(
                (found.inertia_at_origin - self.truth.inertia_at_origin) / scale
            )
        )
        return np.array(
            (
                100 * abs(found.mass - m) / m,
                com.mean(),
                inertia.mean(),
                np.trunc(com).mean(),
            )
        )


@cache
def tools() -> dict[str, Tool]:
    found = {}
    for folder in TOOL_FOLDERS:
        truth = json.loads((folder / "truth.json").read_text())
        pose = truth["object_pose_in_sensor"]
        found[folder.name] = Tool(
            folder.name,
            measure(read_log(folder / "log.csv"), (0.0, 0.0, 9.81)).measurements,
            Shape.from_parts(folder / "parts.ply", pose=pose),
            Shape.from_mesh(folder / "mesh.ply", unit="mm", pose=pose, points=56),
            InertialParameters.from_origin(
                truth["mass"],
                truth["center_of_mass_sensor"],
                truth["inertia_at_sensor"],
            ),
        )
    assert len(found) == 12
    return found


@cache
def published() -> dict[tuple[str, str, str], np.ndarray]:
    """Their errors (3,) [%] of mass, COM without fractions, and inertia, by tool,
    method and noise."""
    rows = json.loads((DATA / "workshop-tools" / "published_results.json").read_text())
    assert len(rows) == 240
    keys = ("mass_error_pct", "com_error_pct_truncated", "inertia_error_pct")
    return {
        (row["tool"].lower().replace("_", "-"), row["method"], row["noise"]): np.array(
            [row[key] for key in keys]
        )
        for row in rows
    }


# HPS without noise: the same samples, the same parts, the same figures


def test_hps_without_noise_is_theirs():
    """Their conic solver stops within about 1e-8 of the optimum and the logs hold six
    digits: 0.01 points agree.

    Beside this the ruler's inertia, which is below.
    """
    for name, tool in tools().items():
        ours = tool.errors(
            HPS(tool.parts, intervals=False).fit(tool.samples).parameters
        )
        theirs = published()[name, "HPS", "No"]
        print(
            f"{name:20s} mass {theirs[0]:.3f} {ours[0]:.3f}   inertia {theirs[2]:.3f} {ours[2]:.3f}"
        )
        assert ours[0] == pytest.approx(theirs[0], abs=0.01), name
        assert ours[3] == pytest.approx(theirs[1], abs=1e-9), name
        assert name == "ruler" or ours[2] == pytest.approx(theirs[2], abs=0.01), name


def test_the_rulers_parts_are_hardly_told_apart():
    """Theirs has an inertia error of 14.5 %, the optimum 26.5 %, and their objectives
    differ by less than a part in a billion of |b|², which is where an interior-point
    solver stops (another one, at 1e-8, gave 18.4 %). Along the direction that the
    samples see least there are masses that have their errors of mass, COM and
    inertia."""
    tool, theirs = tools()["ruler"], published()["ruler", "HPS", "No"]
    z = tool.samples
    still = np.linalg.norm(z.linear_acceleration, axis=1) < 1.0
    still &= np.linalg.norm(z.angular_acceleration, axis=1) < 1.0
    labels = np.unique(tool.parts.labels)
    M = np.column_stack([of_part(tool.parts, label).vector for label in labels])
    A = (reduced_regressor(z[still]) @ M).reshape(-1, len(labels))
    b = z[still].wrench.ravel()
    found = HPS(tool.parts).fit(z)
    best = np.array(
        [found.point_masses[tool.parts.labels == label].sum() for label in labels]
    )
    _, S, V = np.linalg.svd(A, full_matrices=False)
    assert S[-1] < 1e-4 * S[0]

    def objective(masses: np.ndarray) -> float:
        return float(np.sum((A @ masses - b) ** 2))

    candidates = best + np.linspace(-1.0, 1.0, 4001)[:, None] * tool.truth.mass * V[-1]
    candidates = candidates[(candidates >= 0.0).all(axis=1)]
    errors = np.array(
        [tool.errors(InertialParameters(M @ masses)) for masses in candidates]
    )
    nearest = int(np.argmin(np.abs(errors[:, 2] - theirs[2])))
    print(
        f"inertia {theirs[2]:.3f} {errors[nearest, 2]:.3f}, from {errors[:, 2].min():.1f} to {errors[:, 2].max():.1f} %"
    )
    assert errors[nearest, 2] == pytest.approx(theirs[2], abs=0.03)  # the grid's step
    assert errors[nearest, 0] == pytest.approx(theirs[0], abs=0.01)
    assert errors[nearest, 3] == pytest.approx(theirs[1], abs=1e-9)
    assert 0.0 <= objective(candidates[nearest]) - objective(best) < 1e-9 * (b @ b)
    assert found.certificate.gap < 1e-12 * (b @ b)


def of_part(parts: Shape, label: int) -> InertialParameters:
    """One kilogram in one part."""
    assert parts.volumes is not None
    volumes = np.where(parts.labels == label, parts.volumes, 0.0)
    return InertialParameters.from_points(parts.positions, volumes / volumes.sum())


# OLS with noise: the same levels


@pytest.mark.parametrize("level", LEVELS)
def test_ols_with_noise_is_as_far_off_as_theirs(level):
    """Inertia errors of single runs differ by a factor of about 1.6 either way, their
    geometric mean over twelve tools
    by 1.14: 1.4 is two and a half of those. From one level to the next they double."""
    ratios = []
    for index, (name, tool) in enumerate(tools().items()):
        runs = [
            OLS(intervals=False)
            .fit(tool.samples.with_noise(LEVELS[level], [1, index, seed]))
            .parameters
            for seed in range(8)
        ]
        ratios.append(
            published()[name, "OLS", level][2]
            / np.mean([tool.errors(run)[2] for run in runs])
        )
    ratio = np.exp(np.mean(np.log(ratios)))
    print(f"{level}: theirs over ours {ratio:.2f}")
    assert 1 / 1.4 < ratio < 1.4


# GEO: their prior, and the right one


def their_prior(tool: Tool) -> InertialParameters:
    """The true mass, all points alike, and the parallel-axis term once too often."""
    points = InertialParameters.from_points(
        tool.parts.positions, np.full(tool.parts.n, tool.truth.mass / tool.parts.n)
    )
    m, c = points.mass, points.center_of_mass
    return InertialParameters.from_origin(
        m, c, points.inertia_at_origin - m * skew(c) @ skew(c)
    )


def geo_methods(tool: Tool, level: str, z: Measurements) -> dict[str, GEO]:
    """Their rule counts products of inertia once, ours half: so it is written out."""
    gamma = 1e-5 * float(np.sum(full_regressor(z) ** 2))
    noise = LEVELS[level if level in LEVELS else "Low"]  # there must be some
    return {
        "their prior": GEO(prior=their_prior(tool), gamma=gamma, intervals=False),
        "ours": GEO(tool.mesh, noise=Noise(noise.force, noise.torque), intervals=False),
        "their weight": GEO(tool.mesh, gamma=gamma, intervals=False),
    }


def geo_errors(tool: Tool, level: str, seeds: int = SEEDS) -> dict[str, np.ndarray]:
    """Errors (seeds, 4) [%] of each of `geo_methods`."""
    errors: dict[str, list] = {"their prior": [], "ours": [], "their weight": []}
    for seed in range(seeds if level in LEVELS else 1):
        z = (
            tool.samples.with_noise(LEVELS[level], [2, seed])
            if level in LEVELS
            else tool.samples
        )
        for name, method in geo_methods(tool, level, z).items():
            errors[name].append(tool.errors(method.fit(z).parameters))
    return {name: np.array(values) for name, values in errors.items()}


def show(tool: Tool, level: str, errors: dict[str, np.ndarray]) -> None:
    mass, com, inertia = published()[tool.name, "GEO", level]
    ours = "".join(
        " | {:6.2f} {:6.2f} {:7.2f}".format(*values.mean(axis=0)[:3])
        for values in errors.values()
    )
    print(f"{tool.name:20s} {level:4s} {mass:6.2f} {com:6.2f} {inertia:7.2f}{ours}")


def test_geo_without_noise_is_theirs_with_their_prior():
    """The same problem to the same optimum, on logs of six digits: 0.05 points
    agree."""
    print(
        "mass, COM, inertia [%]: published | their prior | the right prior, weight by noise | its weight as theirs"
    )
    for name, tool in tools().items():
        errors = geo_errors(tool, "No")
        show(tool, "No", errors)
        (again,), theirs = errors["their prior"], published()[name, "GEO", "No"]
        assert again[0] == pytest.approx(theirs[0], abs=0.01), name
        assert again[3] == pytest.approx(theirs[1], abs=1e-9), name
        assert again[2] == pytest.approx(theirs[2], abs=0.05), name
        # with the right prior homogeneous tools are as good as known, the others nearer
        # than with theirs
        (ours,), (weighed,) = errors["ours"], errors["their weight"]
        assert ours[2] < (0.9 * theirs[2] if name in HETEROGENEOUS else 0.1), name
        assert ours[1] < 0.1 * again[1], name
        assert name in HETEROGENEOUS or weighed[2] < 0.5, name


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("name", HETEROGENEOUS)
def test_geo_with_noise_and_the_right_prior(name, level):
    """Means of 24 runs, each known to three of its standard errors, of bodies that are
    not homogeneous.

    The file is the exception: with its mass evenly spread it has an inertia error of 82
    %, and by chance the wrong prior one of 19 %. It weighs 20 g, so that in noise of
    0.1 N the prior counts: from there on theirs is as good.
    """
    tool = tools()[name]
    errors, theirs = geo_errors(tool, level), published()[name, "GEO", level]
    show(tool, level, errors)
    ours, again = errors["ours"].mean(axis=0), errors["their prior"].mean(axis=0)
    margin = 3 * errors["ours"].std(axis=0) / np.sqrt(SEEDS)
    assert ours[1] + margin[1] < theirs[1]  # though theirs lacks fractions
    assert ours[1] < 0.5 * again[1]
    if name == "file":
        assert ours[2] < {"Low": 1.0, "Mod": 1.15, "High": 1.5}[level] * theirs[2]
        assert ours[0] < 3 * again[0]
    else:
        assert ours[2] + margin[2] < 0.55 * min(theirs[2], again[2])
        assert ours[0] < 1.1 * again[0]  # both are as good as the force sensor


def test_the_files_wrong_prior_is_the_better_one_by_chance():
    tool = tools()["file"]
    right = InertialParameters(tool.truth.mass * tool.mesh.homogeneous.vector)
    assert tool.errors(right)[2] > 75.0
    assert tool.errors(their_prior(tool))[2] < 20.0
    for name in set(HETEROGENEOUS) - {"file", "machinist-hammer"}:
        other = tools()[name]
        right = InertialParameters(other.truth.mass * other.mesh.homogeneous.vector)
        assert other.errors(right)[2] < 0.3 * other.errors(their_prior(other))[2]

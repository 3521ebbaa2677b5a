"""Experiments: independent jobs, a function that does one, and the report of all
results; with the paper's setting, summaries of errors and parts of figures."""

import csv
import io
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.accuracy import Errors, errors_between
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements, Noise
from hefting.core.spatial import SPEED_LIMIT, immutable
from hefting.estimators import GEO, OLS, PMD, RTLS, Estimator
from hefting.plots.style import BLUE, GREEN, ORANGE, SHADOW, VERMILION, drawing
from hefting.shapes import Shape
from hefting.simulation import (
    MODULAR,
    HeldObject,
    Wielding,
    held_modular,
    paper_points,
    sinusoids,
    wield_in_mujoco,
)
from hefting.simulation.scenario import ARMS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Job = dict[str, Any]
"""Parameters of one job, JSON-ready, including its seed; they determine the result."""
Result = dict[str, Any]
"""Numbers of one job, JSON-ready."""
Results = list[tuple[Job, Result]]
"""Jobs and their results, in the order of the jobs."""
Cell = str | float | int | None
PLAIN = 1e6
"""Magnitude below which numbers are shown without an exponent."""


@dataclass(frozen=True)
class Table:
    """Rows under named columns; units are in the names."""

    name: str
    """of its files"""
    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]

    def csv(self) -> str:
        """Comma-separated values with one header row."""
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows((self.columns, *self.rows))
        return text.getvalue()

    def json(self) -> str:
        """A list of objects, one per row."""
        rows = [dict(zip(self.columns, row, strict=True)) for row in self.rows]
        return json.dumps(rows, indent=1) + "\n"

    def markdown(self) -> str:
        """A Markdown table, numbers with three digits."""
        lines = [
            " | ".join(map(str, self.columns)),
            " | ".join("---" for _ in self.columns),
        ]
        lines += [" | ".join(map(shown, row)) for row in self.rows]
        return "".join(f"| {line} |\n" for line in lines)


def shown(cell: Cell) -> str:
    """A cell as text, with three significant digits; empty for None."""
    if cell is None:
        return ""
    if not isinstance(cell, float):
        return str(cell)
    text = f"{cell:.3g}"
    return f"{float(text):.0f}" if "e+" in text and abs(cell) < PLAIN else text


@dataclass(frozen=True)
class Report:
    """Tables, figures and notes of an experiment."""

    tables: tuple[Table, ...]
    figures: dict[str, "Figure"] = field(default_factory=dict)
    """by the names of their files"""
    notes: tuple[str, ...] = ()
    """paragraphs on assumptions, and on differences from published figures"""


@dataclass(frozen=True)
class Experiment:
    """One table or figure of the paper."""

    name: str
    """as on the command line"""
    title: str
    source: str
    """table, figure or section of Nadeau et al. 2022"""
    jobs: Callable[[bool], list[Job]]
    """all jobs, or few for a quick run (True)"""
    run: Callable[[Job], Result]
    report: Callable[[Results], Report]


OBJECTS = tuple(MODULAR)
"""The eight configurations of the modular object."""
SPEEDS = {1.0: 0.14, 1.5: 0.2, 2.0: 0.27, 3.0: 0.41, 4.0: 0.54}
"""Average angular speeds [rad/s], with the paper's linear speeds [m/s]."""
RATE = 100.0
"""Samples per second."""
DURATION = 35.0
"""Duration of a motion [s]."""
C1 = 300.0
"""c1 of PMD in the paper's simulations."""
QUANTITIES = {"mass": "mass", "center_of_mass": "COM", "inertia_at_origin": "inertia"}
"""Errors that the paper gives, and their names in tables and figures."""
MOSTLY_WRONG = 500.0
"""Error [%] above which the paper states "> 500"."""


@immutable
class Thing:
    """A modular object with the paper's shape of it."""

    held: HeldObject
    shape: Shape
    """the paper's 56 points, in the sensor frame"""

    def errors(self, estimate: Estimate) -> Errors:
        """Errors of an estimate in the sensor frame."""
        axes = self.held.pose[:3, :3]
        return errors_between(
            estimate.parameters, self.held.parameters, self.held.extents, axes
        )


@cache
def thing(name: str) -> Thing:
    """One of `OBJECTS`."""
    held = held_modular(name)
    return Thing(held, paper_points(held))


@cache
def wielded(
    name: str, speed: float, arm: str = "ur5", duration: float = DURATION
) -> Wielding:
    """One of `OBJECTS` on the paper's sinusoids at an average angular speed [rad/s],
    exact, from MuJoCo."""
    robot = ARMS[arm]
    joints = sinusoids(duration, RATE, speed, robot)
    return wield_in_mujoco(robot, joints, thing(name).held.parameters)


Method = Callable[[Thing, Measurements], Estimator]


def pmd(c1: float) -> Method:
    """PMD with the shape of the thing."""
    return lambda thing, z: PMD(thing.shape, c1=c1, intervals=False)


METHODS: dict[str, Method] = {
    "OLS": lambda thing, z: OLS(intervals=False),
    "RTLS": lambda thing, z: RTLS(intervals=False),
    "GEO": lambda thing, z: GEO(thing.shape, intervals=False),
    "PMD": pmd(C1),
}
"""The paper's four methods with its hyperparameters; GEO with its authors' weight and the
homogeneous body."""
COLOURS = {"OLS": BLUE, "RTLS": ORANGE, "GEO": GREEN, "PMD": VERMILION}
"""Colours of the methods in all figures."""
MARKERS = {"OLS": "o", "RTLS": "s", "GEO": "^", "PMD": "D"}


def mean(values: Iterable[float | None]) -> float | None:
    """Mean of the finite values; None if there are none."""
    known = [v for v in values if v is not None and np.isfinite(v)]
    return float(np.mean(known)) if known else None


def printed(value: float) -> str | float:
    """An error [%] as the paper prints it: "> 500" from `MOSTLY_WRONG` on."""
    return "> 500" if value >= MOSTLY_WRONG else value


def signal_to_noise(measurements: Measurements, noise: Noise) -> float:
    """Mean-squared signal over noise variance: geometric mean over the 12 channels of
    accelerations and wrench."""
    z, n = measurements, noise
    signals = np.hstack((z.linear_acceleration, z.angular_acceleration, z.wrench))
    levels = n.linear_acceleration, n.angular_acceleration, n.force, n.torque
    ratios = np.mean(np.square(signals), axis=0) / np.square(np.repeat(levels, 3))
    return float(np.exp(np.mean(np.log(ratios))))


LIMIT = float(np.interp(SPEED_LIMIT, list(SPEEDS.values()), list(SPEEDS)))
"""Angular speed [rad/s] at ISO 10218-1's 0.25 m/s, by interpolation of `SPEEDS`."""


def mark_limit(axes: "Axes") -> None:
    """Draw a dotted line at `LIMIT`, where x is the angular speed [rad/s]."""
    axes.axvline(
        LIMIT,
        color="#777777",
        linewidth=1.0,
        linestyle=":",
        label=f"{SPEED_LIMIT} m/s (ISO 10218-1)",
        zorder=0,
    )


def over_limit(speed: float) -> bool:
    """Whether the paper's speed at an angular one [rad/s] is above ISO 10218-1's."""
    return SPEEDS[speed] > SPEED_LIMIT


def jobs_of(objects: Iterable[str], speeds: Iterable[float], **more: Any) -> list[Job]:
    """A job for each object and speed, with `more` that is the same for all."""
    return [{"object": name, "speed": s, **more} for name in objects for s in speeds]


def speeds_of(results: Results) -> list[Any]:
    """The speeds of the jobs of results, each once, in their order."""
    return list(dict.fromkeys(job["speed"] for job, _ in results))


def marked(colour: str, marker: str) -> dict[str, Any]:
    """Style of a line with a mark at each value."""
    return {"color": colour, "marker": marker, "markersize": 3.0, "linewidth": 1.0}


def errors_figure(
    height: float,
    methods: Sequence[str],
    tops: Sequence[float],
    draw: Callable[["Axes", int], None],
    below: str,
) -> "Figure":
    """A panel for each of `QUANTITIES`, which `draw` fills by its index, with methods
    along x, every other one shaded, and a logarithmic scale up to one of `tops`."""
    labels = [
        name.replace(", ", "\n")
        .replace("literature", "liter.")
        .replace("PMD-", "PMD\n")
        for name in methods
    ]
    with drawing(height, 7.2) as figure:
        panels = figure.subplots(1, 3)
        for quantity, name in enumerate(QUANTITIES.values()):
            axes = panels[quantity]
            draw(axes, quantity)
            for i in range(0, len(methods), 2):
                look = {"color": SHADOW, "alpha": 0.5, "linewidth": 0.0, "zorder": 0}
                axes.axvspan(i - 0.5, i + 0.5, **look)
            axes.set(yscale="log", xlim=(-0.5, len(methods) - 0.5))
            axes.set(ylim=(None, tops[quantity]), ylabel=f"{name} error [%]")
            axes.set_xticks(range(len(methods)), labels)
        panels[1].set_xlabel(below)
        legend_above(figure, panels[0], len(panels[0].get_legend_handles_labels()[0]))
    return figure


def legend_above(figure: "Figure", axes: "Axes", columns: int) -> None:
    """A legend of `axes` above the figure."""
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside upper center",
        ncols=columns,
        handlelength=1.8,
    )

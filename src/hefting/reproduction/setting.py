"""The paper's setting, how errors are summed up, and what the figures share."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements, Noise
from hefting.core.metrics import Errors, errors_between
from hefting.core.spatial import SPEED_LIMIT
from hefting.estimators import GEO, OLS, PMD, RTLS, Estimator
from hefting.plots.style import BLUE, GREEN, ORANGE, SHADOW, VERMILION
from hefting.shapes import Shape
from hefting.simulation import (
    MODULAR,
    UR5,
    XARM7,
    HeldObject,
    Wielding,
    held_modular,
    paper_points,
    sinusoids,
    wield_in_mujoco,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OBJECTS = tuple(MODULAR)
"""The eight configurations of the modular object."""
SPEEDS = {1.0: 0.14, 1.5: 0.2, 2.0: 0.27, 3.0: 0.41, 4.0: 0.54}
"""Average angular speeds [rad/s] and the linear ones [m/s] that the paper pairs with
them."""
RATE = 100.0
"""Samples a second."""
DURATION = 35.0
"""Of a motion [s]."""
C1 = 300.0
"""Of PMD in the paper's simulations."""
QUANTITIES = {"mass": "mass", "center_of_mass": "COM", "inertia_at_origin": "inertia"}
"""Errors that the paper gives, and what they are called in tables and figures."""
MOSTLY_WRONG = 500.0
"""Percent: the paper says "> 500" above it."""


@dataclass(frozen=True, eq=False)
class Thing:
    """A modular object with the 56 points the paper describes it by."""

    held: HeldObject

    @cached_property
    def shape(self) -> Shape:
        """The paper's 56 points, in the sensor frame."""
        return paper_points(self.held)

    def errors(self, estimate: Estimate) -> Errors:
        """Of an estimate in the sensor frame."""
        axes = self.held.pose[:3, :3]
        return errors_between(
            estimate.parameters, self.held.parameters, self.held.extents, axes
        )


@cache
def thing(name: str) -> Thing:
    """One of `OBJECTS`."""
    return Thing(held_modular(name))


@cache
def wielded(
    name: str,
    speed: float,
    arm: str = "ur5",
    duration: float = DURATION,
) -> Wielding:
    """One of `OBJECTS` on the paper's sinusoids at an average angular speed [rad/s],
    exact, from MuJoCo."""
    robot = {"ur5": UR5, "xarm7": XARM7}[arm]
    return wield_in_mujoco(
        robot, sinusoids(duration, RATE, speed, robot), thing(name).held.parameters
    )


METHODS: dict[str, Callable[[Thing, Measurements], Estimator]] = {
    "OLS": lambda thing, z: OLS(intervals=False),
    "RTLS": lambda thing, z: RTLS(intervals=False),
    "GEO": lambda thing, z: GEO(thing.shape, intervals=False),
    "PMD": lambda thing, z: PMD(thing.shape, c1=C1, intervals=False),
}
"""The paper's four, at its hyperparameters; GEO with its authors' weight and the
homogeneous body."""
COLOURS = {"OLS": BLUE, "RTLS": ORANGE, "GEO": GREEN, "PMD": VERMILION}
"""Of the methods in all figures."""
MARKERS = {"OLS": "o", "RTLS": "s", "GEO": "^", "PMD": "D"}


def mean(values: Iterable[float | None]) -> float | None:
    """Mean of those that are there; None of none."""
    known = [v for v in values if v is not None and np.isfinite(v)]
    return float(np.mean(known)) if known else None


def printed(value: float) -> str | float:
    """An error [%] as the paper prints it: "> 500" above that."""
    return "> 500" if value >= MOSTLY_WRONG else value


def signal_to_noise(measurements: Measurements, noise: Noise) -> float:
    """Mean-squared signal over noise variance: geometric mean over the 12 channels of
    accelerations and wrench."""
    signals = (
        measurements.linear_acceleration,
        measurements.angular_acceleration,
        measurements.wrench,
    )
    levels = (
        noise.linear_acceleration,
        noise.angular_acceleration,
        noise.force,
        noise.torque,
    )
    ratios = np.mean(np.square(np.hstack(signals)), axis=0) / np.square(
        np.repeat(levels, 3)
    )
    return float(np.exp(np.mean(np.log(ratios))))


LIMIT = float(np.interp(SPEED_LIMIT, list(SPEEDS.values()), list(SPEEDS)))
"""Angular speed [rad/s] that the paper's pairs put beside ISO 10218-1's 0.25 m/s."""


def mark_limit(axes: "Axes") -> None:
    """ISO 10218-1's largest TCP speed as a dotted line, where x is the angular speed
    [rad/s]."""
    axes.axvline(
        LIMIT,
        color="#777777",
        linewidth=1.0,
        linestyle=":",
        label=f"{SPEED_LIMIT} m/s (ISO 10218-1)",
        zorder=0,
    )


def over_limit(speed: float) -> bool:
    """Whether the linear speed the paper pairs with an angular one [rad/s] is above ISO
    10218-1's."""
    return SPEEDS[speed] > SPEED_LIMIT


def marked(colour: str, marker: str) -> dict[str, Any]:
    """How a line with a mark at each value is drawn."""
    return {"color": colour, "marker": marker, "markersize": 3.0, "linewidth": 1.0}


def group(axes: "Axes", methods: Sequence[str], top: float) -> None:
    """A place a method along x, every other one shaded, and a logarithmic scale up to
    `top`."""
    for i in range(0, len(methods), 2):
        axes.axvspan(i - 0.5, i + 0.5, color=SHADOW, alpha=0.5, linewidth=0.0, zorder=0)
    axes.set(yscale="log", xlim=(-0.5, len(methods) - 0.5))
    axes.set_ylim(top=top)
    labels = [
        name.replace(", ", "\n")
        .replace("literature", "liter.")
        .replace("PMD-", "PMD\n")
        for name in methods
    ]
    axes.set_xticks(range(len(methods)), labels)


def legend_above(figure: "Figure", axes: "Axes", columns: int) -> None:
    """A legend of what is in `axes`, above everything."""
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside upper center",
        ncols=columns,
        handlelength=1.8,
    )

"""What the experiments' figures share: the ISO limit among angular speeds, one legend
above all panels, groups."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from hefting.core.spatial import SPEED_LIMIT
from hefting.plots.style import SHADOW
from hefting.reproduction.setting import SPEEDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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

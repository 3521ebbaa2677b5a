"""What the experiments' figures share: colours, the ISO limit among angular speeds, and one legend above all panels."""

from typing import TYPE_CHECKING

import numpy as np

from hefting.reproduction.setting import ISO_LIMIT, SPEEDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLACK, ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE = (
    "#000000",
    "#E69F00",
    "#56B4E9",
    "#009E73",
    "#0072B2",
    "#D55E00",
    "#CC79A7",
)
"""The palette of Okabe & Ito (2008) but its yellow, too pale for lines."""
LIMIT = float(np.interp(ISO_LIMIT, list(SPEEDS.values()), list(SPEEDS)))
"""Angular speed [rad/s] that the paper's pairs put beside ISO 10218-1's 0.25 m/s."""


def mark_limit(axes: "Axes") -> None:
    """ISO 10218-1's largest TCP speed as a dotted line, where x is the angular speed [rad/s]."""
    axes.axvline(LIMIT, color="#777777", linewidth=1.0, linestyle=":", label=f"{ISO_LIMIT} m/s (ISO 10218-1)", zorder=0)


def over_limit(speed: float) -> bool:
    """Whether the linear speed the paper pairs with an angular one [rad/s] is above ISO 10218-1's."""
    return SPEEDS[speed] > ISO_LIMIT


def legend_above(figure: "Figure", axes: "Axes", columns: int) -> None:
    """A legend of what is in `axes`, above everything."""
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=columns, handlelength=1.8)

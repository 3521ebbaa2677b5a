"""What an identification costs against samples, points and recordings, drawn."""

from typing import TYPE_CHECKING, Any

from hefting.plots.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    drawing,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWN = {
    "Hefting Bayes": (BLUE, "o", "-"),
    "Hefting PMD, without intervals": (SKY, "s", "-"),
    "Hefting OLS, without intervals": (GREEN, "^", "-"),
    "Pinocchio + lstsq": (PURPLE, "^", "--"),
    "CVXPY + Clarabel PMD": (VERMILION, "s", "--"),
    "CVXPY + Clarabel PMD, reduced": (ORANGE, "s", "--"),
    "mujoco.sysid, mass and COM": ("#777777", "o", "--"),
    "mujoco.sysid, ten parameters": (BLACK, "o", "--"),
}
"""Colour, marker and line of each party: Hefting's are solid, and a peer has the marker
of what it is compared with."""
AXES = {
    "samples": "samples",
    "points": "points of the shape (150 samples)",
    "recordings": "recordings of 150 samples",
}


POWERS = (100, 1000, 10_000, 100_000)
"""Numbers of samples that are marked."""


def cost_figure(cost: dict[str, Any]) -> "Figure":
    """A panel for each of `AXES` that was measured, both axes logarithmic."""
    panels = [name for name in AXES if name in cost]
    with drawing(2.6, width=6.8) as figure:
        every = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
        for axes, name in zip(every, panels, strict=True):
            for party, (colour, marker, line) in DRAWN.items():
                curve = cost[name].get(party)
                if curve is None:
                    continue
                axes.plot(
                    curve["at"],
                    curve["seconds"],
                    color=colour,
                    marker=marker,
                    linestyle=line,
                    markersize=3.0,
                    linewidth=1.1,
                    label=party,
                )
            axes.set(xscale="log", yscale="log", xlabel=AXES[name])
            sizes = sorted({n for curve in cost[name].values() for n in curve["at"]})
            marked = [n for n in sizes if name != "samples" or n in POWERS]
            axes.set_xticks(marked, [f"{n:,}" for n in marked])
            axes.minorticks_off()
            axes.grid(color="#E4E4E4", linewidth=0.5)
        every[0].set_ylabel("time of an identification [s]")
        figure.legend(
            *every[0].get_legend_handles_labels(),
            loc="outside upper center",
            ncols=3,
        )
    return figure

"""The eight configurations of the modular object, and their true parameters."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.spatial import tensor_to_vector
from hefting.plots.style import BLUE, INK, SKY, VERMILION, drawing
from hefting.reproduction.experiment import (
    OBJECTS,
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
)
from hefting.simulation import MODULAR, Part
from hefting.simulation.modular import (
    ABS_WEIGHT,
    GRASPED,
    PLA,
    SLOTS,
    STEEL_WEIGHT,
    THICKNESS,
    WEIGHT,
    modular,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PRINT, STEEL, AIR = "#CFCFCF", "#303030", "#FFFFFF"
"""Colours of the print, of steel weights and of hollows; ABS weights are blue."""
TITLES = {"half-n-half": "Half-N-Half"}


def jobs(quick: bool) -> list[Job]:
    """A job for each object."""
    return [{"object": name} for name in OBJECTS]


def run(job: Job) -> Result:
    """True mass [kg], COM [m] and inertia about the COM [kg m²] (xx, xy, xz, yy, yz, zz),
    in the object's frame."""
    body: InertialParameters = modular(job["object"]).parameters
    inertia = tensor_to_vector(body.inertia_at_com)
    return {
        "mass": body.mass,
        "center_of_mass": body.center_of_mass.tolist(),
        "inertia": inertia.tolist(),
    }


def report(results: Results) -> Report:
    """The paper's picture, and the true parameters of all simulations."""
    rows = []
    for job, result in results:
        filling = MODULAR[job["object"]]
        com = 1e3 * np.array(result["center_of_mass"])
        inertia = 1e4 * np.array(result["inertia"])
        # removes rounding errors that look like asymmetry
        numbers = np.round((result["mass"], *com, *inertia), 9) + 0.0
        rows.append(
            (job["object"], len(filling.steel), len(filling.abs), *map(float, numbers))
        )
    entries = tuple(f"J{ij} kg cm²" for ij in ("xx", "xy", "xz", "yy", "yz", "zz"))
    columns = ("object", "steel", "ABS", "mass kg", "x mm", "y mm", "z mm", *entries)
    title = "True mass, COM and inertia about it, in the object's frame: origin in the middle of the face held"
    steel, plastic = (
        1e3 * density * np.pi * WEIGHT[0] ** 2 * WEIGHT[1]
        for density in (STEEL_WEIGHT, ABS_WEIGHT)
    )
    notes = (
        f"Steel and ABS weights have {steel:.1f} and {plastic:.1f} g (published: 101 and 17 g). Outline, pockets, "
        "holes and densities are those of the authors' own generator; bolts are left out.",
        f"The TCP is on the face z = 0 at pocket {GRASPED} (x = {SLOTS[GRASPED][0]:g}, y = {SLOTS[GRASPED][1]:g} mm), "
        "all objects alike; inertia errors are about it unless said otherwise.",
    )
    table = Table("objects", title, columns, rows)
    return Report((table,), {"objects": _figure(results)}, notes)


DOT: dict[str, Any] = {
    "marker": "o",
    "markersize": 5.0,
    "markeredgecolor": "white",
    "markeredgewidth": 0.7,
    "linestyle": "none",
}
"""Mark of a COM, or of the TCP."""


def _figure(results: Results):
    """Each object as seen along z, with its COM and the TCP."""
    with drawing(5.3, 7.2) as figure:
        panels = figure.subplots(2, 4, sharex=True, sharey=True).ravel()
        for letter, axes, (job, result) in zip(
            "abcdefgh", panels, results, strict=True
        ):
            name = job["object"]
            for part in sorted(modular(name).parts, key=_depth):
                _draw(axes, part)
            com = 1e3 * np.array(result["center_of_mass"][:2])
            axes.plot(*SLOTS[GRASPED], color=BLUE, zorder=4, **DOT)
            axes.plot(*com, color=VERMILION, zorder=5, **DOT)
            title = TITLES.get(name, name.capitalize())
            axes.set(
                title=f"({letter}) {title}, {1e3 * result['mass']:.0f} g",
                aspect="equal",
                xlim=(-112, 112),
                ylim=(-172, 172),
                xticks=(-100, 0, 100),
            )
        for axes in panels[4:]:
            axes.set_xlabel("x [mm]")
        for axes in panels[::4]:
            axes.set_ylabel("y [mm]")
        _draw_legend(figure)
    return figure


def _draw_legend(figure: "Figure") -> None:
    """Colours of weights, print, COM and TCP, above the panels."""
    from matplotlib.lines import Line2D

    weights = {
        "steel weight": STEEL,
        "ABS weight": SKY,
        "no weight (air)": AIR,
        "print (PLA)": PRINT,
    }
    outlined = {
        "marker": "o",
        "markersize": 6.0,
        "markeredgecolor": INK,
        "markeredgewidth": 0.5,
        "linestyle": "none",
    }
    handles = [
        *(
            Line2D([], [], color=c, label=label, **outlined)
            for label, c in weights.items()
        ),
        Line2D([], [], color=VERMILION, label="COM", **DOT),
        Line2D([], [], color=BLUE, label="TCP", **DOT),
    ]
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=len(handles),
        handletextpad=0.2,
    )


def _depth(part: Part) -> int:
    """Drawing order: the print, then holes, then weights."""
    return 0 if part.density == PLA else 1 if part.density < 0.0 else 2


def _draw(axes: "Axes", part: Part) -> None:
    """Draw a part as seen along z [mm]."""
    from matplotlib.patches import Circle, Rectangle

    x, y = 1e3 * part.center[0], 1e3 * part.center[1]
    colour = {PLA: PRINT, STEEL_WEIGHT: STEEL, ABS_WEIGHT: SKY}.get(part.density, AIR)
    if part.solid == "box":
        width, height = 1e3 * part.size[0], 1e3 * part.size[1]
        axes.add_patch(
            Rectangle(
                (x - width / 2, y - height / 2),
                width,
                height,
                facecolor=colour,
                linewidth=0.0,
            )
        )
        return
    pocket = part.density < 0.0 and part.size[1] < THICKNESS
    edge = {"edgecolor": INK, "linewidth": 0.5} if pocket else {"linewidth": 0.0}
    axes.add_patch(Circle((x, y), 1e3 * part.size[0], facecolor=colour, **edge))


EXPERIMENT = Experiment(
    "objects",
    "The modular test object",
    "Figure on the eight weight configurations",
    jobs,
    run,
    report,
)

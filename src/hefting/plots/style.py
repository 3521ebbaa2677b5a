"""Style: the palette, sizes and fonts of every picture, and how one is saved. Needs matplotlib."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.core.errors import MissingDependencyError
from hefting.core.files import write_atomically

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE, ORANGE, GREEN, VERMILION = "#0072B2", "#E69F00", "#009E73", "#D55E00"
"""From the colour-blind safe palette of Okabe & Ito (2008)."""
COMPONENTS = {"x": BLUE, "y": VERMILION, "z": GREEN}
SHADOW, INK = "#E4E4E4", "#303030"
WIDTH = 3.5
"""Width of a printed column [in]."""
TALLEST = 6.5
"""Greatest height of a picture [in]."""
BAR = 0.07
"""Height of the colour bar [in]."""
DRAWN = 1500
"""Most samples drawn of a long recording, evenly chosen."""

STYLE: dict[Any, Any] = {
    "font.size": 7.0,
    "axes.labelsize": 7.0,
    "axes.titlesize": 7.0,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.5,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "svg.hashsalt": "hefting",
}


def save_figure(figure: "Figure", stem: str | Path) -> tuple[Path, Path]:
    """Write `figure` as ``stem.png`` (300 dpi) and ``stem.svg``, each whole or not at all; their paths."""
    png, svg = io.BytesIO(), io.BytesIO()
    with style():
        figure.savefig(png, format="png", dpi=300)
        figure.savefig(svg, format="svg", metadata={"Date": None})
    paths = Path(f"{stem}.png"), Path(f"{stem}.svg")
    write_atomically(paths[0], png.getvalue())
    write_atomically(paths[1], svg.getvalue())
    return paths


@contextmanager
def style() -> Iterator[None]:
    """Within it matplotlib draws as everything here is drawn. `MissingDependencyError` without matplotlib."""
    try:
        import matplotlib
    except ImportError as error:
        raise MissingDependencyError("matplotlib", "plot") from error
    with matplotlib.rc_context(STYLE):
        yield


def figure_of(height: float, width: float = WIDTH) -> "Figure":
    """An empty figure of a height and a width [in], to be laid out by `settled`."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def settled(figure: "Figure") -> "Figure":
    """The figure with its layout worked out once, not again for every file format."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    return figure

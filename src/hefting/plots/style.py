"""Style: palette, sizes and fonts of every picture, its headline, and how it is saved.
Needs matplotlib."""

import io
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.errors import InputError, needing
from hefting.core.files import write_atomically
from hefting.core.spatial import Array, Indices

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, FigureBase, SubFigure

    from hefting.scene import Headline

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE = "#0072B2", "#D55E00", "#CC79A7"
"""The colour-blind safe palette of Okabe & Ito (2008) without yellow, which is too pale
for lines."""
COMPONENTS = {"x": BLUE, "y": VERMILION, "z": GREEN}
SHADOW, INK = "#E4E4E4", "#303030"
WIDTH = 3.5
"""Width of a printed column [in]."""
TALLEST = 6.5
"""Greatest height of a picture [in]."""
DRAWN = 1500
"""Most drawn samples of a recording, evenly chosen."""
MEASURED: dict[str, Any] = {"linewidth": 1.8, "alpha": 0.35}
"""Style of measured lines, wide and pale, below computed ones."""
FORMATS: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
"""Suffixes of pictures, and the metadata that is removed so that equal pictures have
equal bytes."""
DPI = 300
"""Resolution of raster pictures [dots per inch]."""

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
NO_LAYOUT: dict[Any, Any] = {
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
}
"""Settings with which a figure has no layout engine."""
RIGHT = 0.02
"""Margin of a picture at the right, as a share of its width."""
LINE = 0.15
"""Height of a line of the headline, or of a legend [in]."""
COLUMN = 62
"""Approximate number of characters in `WIDTH`."""
MOST_LINES = 3
"""Most lines of the reason."""


def save_figure(figure: "Figure", stem: str | Path) -> tuple[Path, Path]:
    """Write `figure` as ``stem.png`` (300 dpi) and ``stem.svg``, each whole or not at all;
    returns their paths."""
    paths = Path(f"{stem}.png"), Path(f"{stem}.svg")
    contents = [picture_of(figure, path.suffix) for path in paths]
    for path, content in zip(paths, contents, strict=True):
        write_atomically(path, content)
    return paths


def picture_suffix(path: str | Path) -> str:
    """Suffix of a picture to write, in lower case. `InputError` unless it is one of
    `FORMATS`, `MissingDependencyError` without matplotlib."""
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        fix = f"use {', '.join(FORMATS)}"
        raise InputError(f"'{suffix}' is not a picture format", path, fix)
    with style():
        return suffix


def picture_of(figure: "Figure", suffix: str) -> bytes:
    """`figure` as the content of a file with a suffix of `FORMATS`, in 300 dpi; the same
    bytes every time."""
    content = io.BytesIO()
    with style():
        figure.savefig(content, format=suffix[1:], dpi=DPI, metadata=FORMATS[suffix])
    return content.getvalue()


@contextmanager
def style() -> Iterator[None]:
    """Within, matplotlib uses `STYLE`. `MissingDependencyError` without matplotlib."""
    with needing("matplotlib", "plot"):
        import matplotlib
    with matplotlib.rc_context(STYLE):
        yield


@contextmanager
def drawing(height: float, width: float = WIDTH) -> "Iterator[Figure]":
    """A context with an empty figure of a height and a width [in]; at its end the layout
    is computed, once for all file formats."""
    with style():
        from matplotlib import rc_context
        from matplotlib.figure import Figure
        from matplotlib.layout_engine import ConstrainedLayoutEngine

        margin = RIGHT * WIDTH / width
        layout = ConstrainedLayoutEngine(rect=(0.0, 0.0, 1.0 - margin, 1.0))
        figure = Figure(figsize=(width, height), layout=layout)
        yield figure
        figure.draw_without_rendering()
        with rc_context(NO_LAYOUT):
            # with the engine called "none" every file would be drawn twice
            figure.set_layout_engine(None)


def chosen(count: int) -> Indices:
    """At most `DRAWN` of `count` indices, evenly chosen."""
    return np.unique(np.linspace(0, count - 1, min(count, DRAWN)).astype(np.intp))


def lines_of(
    headline: "Headline", width: float = WIDTH, say: Callable[[str], str] = str
) -> list[str]:
    """Lines of a headline over a picture of a width [in]; `say` turns names of arguments
    in backquotes into the reader's."""
    columns = int(COLUMN * width / WIDTH)
    reason = wrap(say(headline.reason), columns)
    if len(reason) > MOST_LINES:
        reason = [*reason[: MOST_LINES - 1], f"{reason[MOST_LINES - 1][:-2]} …"]
    numbers = list(headline.numbers)
    if width > 1.5 * WIDTH and numbers:
        numbers = [f"{numbers[0]}   {numbers[1]}", *numbers[2:]]
    numbers = [line for text in numbers for line in _wrapped(text, columns)]
    return [headline.verdict, *reason, *numbers]


def _wrapped(text: str, columns: int) -> list[str]:
    """Lines of at most `columns` characters; a name keeps its number and interval."""
    kept = re.sub(r"(\w+) (\S+) ± (\S+)", "\\1\xa0\\2\xa0±\xa0\\3", text)
    return [line.replace("\xa0", " ") for line in wrap(kept, columns)]


@contextmanager
def headed(
    height: float, lines: list[str], usable: bool = True, width: float = WIDTH
) -> "Iterator[tuple[Figure, SubFigure]]":
    """As `drawing`, with a headline above an area of a height [in]; yields the figure and
    this area."""
    with drawing(height + LINE * len(lines), width) as figure:
        yield figure, write_headline(figure, lines, usable)


def write_headline(figure: "Figure", lines: list[str], usable: bool) -> "SubFigure":
    """Write lines at the top left, if not usable in another colour, with the words "do not
    use" across the picture. Returns the area below them."""
    figure.suptitle(
        "\n".join(lines),
        x=0.015,
        ha="left",
        fontsize=7.0,
        linespacing=1.35,
        color=INK if usable else VERMILION,
    )
    if not usable:
        figure.text(
            0.5,
            0.45,
            "do not use",
            rotation=30.0,
            ha="center",
            va="center",
            fontsize=40.0,
            color=VERMILION,
            alpha=0.18,
            zorder=10,
        )
    # a legend outside the axes has no place beside a title of the same figure
    return subfigures_of(figure, 1)[0]


def subfigures_of(figure: "FigureBase", count: int) -> "list[SubFigure]":
    """A figure divided from left to right into `count` parts."""
    return list(np.atleast_1d(np.asarray(figure.subfigures(1, count))))


def draw_components(axes: "Axes", time: Array, values: Array, **look: Any) -> None:
    """Three components (K, 3) over time (K,), in one style and three colours."""
    for column, colour in zip(values.T, COMPONENTS.values(), strict=True):
        axes.plot(time, column, color=colour, **look)


def line_of(static: bool, width: float) -> dict[str, Any]:
    """Style of a line of a width [pt]; dots for static poses."""
    dots: dict[str, Any] = {"marker": ".", "markersize": 3.0, "linestyle": "none"}
    return dots if static else {"linewidth": width}


def write_title(axes: "Axes", text: str) -> None:
    """Write a title above axes at the right."""
    axes.set_title(text, loc="right", pad=2.0, color=INK)


def label_time(axes: "Axes", time: Array, static: bool) -> None:
    """Label and limits of the x axis: time [s], or the numbers of static poses."""
    axes.set_xlabel("Pose" if static else "Time [s]")
    margin = 0.5 if static or len(time) == 1 else 0.0
    axes.set_xlim(time[0] - margin, time[-1] + margin)
    if static:
        from matplotlib.ticker import MaxNLocator

        whole = MaxNLocator("auto", integer=True, min_n_ticks=1)
        axes.xaxis.set_major_locator(whole)


def component_handles() -> "list[Any]":
    """Entries of a legend for the three components."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=colour, linewidth=1.2, label=name)
        for name, colour in COMPONENTS.items()
    ]


def draw_legend(
    figure: "SubFigure", handles: "list[Any]", columns: int, **look: Any
) -> None:
    """A legend above the axes of a figure, in rows of at most `columns` entries that are
    read from left to right: matplotlib fills columns."""
    count = min(columns, len(handles))
    order = [k for column in range(count) for k in range(column, len(handles), count)]
    figure.legend(
        handles=[handles[k] for k in order],
        ncols=count,
        loc="outside upper center",
        **look,
    )

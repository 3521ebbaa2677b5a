"""Headline over a picture: verdict and numbers. Needs matplotlib."""

import re
from collections.abc import Callable
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from hefting.plots.style import INK, VERMILION, WIDTH
from hefting.scene import Headline

if TYPE_CHECKING:
    from matplotlib.figure import Figure, FigureBase, SubFigure

LINE = 0.15
"""Height of a line of the headline, or of a legend [in]."""
COLUMN = 62
"""Characters in the width of a column, about."""
MOST_LINES = 3
"""Lines of the reason that are shown."""


def lines_of(
    headline: Headline, width: float = WIDTH, say: Callable[[str], str] = str
) -> list[str]:
    """Lines of a headline over a picture of a width [in]; `say` turns the library's way
    of naming its arguments into the reader's."""
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
    """Lines of at most so many characters that keep a name, its number and its interval
    together."""
    kept = re.sub(r"(\w+) (\S+) ± (\S+)", "\\1\xa0\\2\xa0±\xa0\\3", text)
    return [line.replace("\xa0", " ") for line in wrap(kept, columns)]


def write_headline(
    figure: "Figure", lines: list[str], usable: bool = True
) -> "SubFigure":
    """Write lines at the top left; of what is not to be used in another colour, and the
    verdict across the picture. Returns what is below them, to draw on."""
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
    """A figure divided from left to right into so many parts."""
    return list(np.atleast_1d(np.asarray(figure.subfigures(1, count))))

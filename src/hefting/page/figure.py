"""Figure: traces and layout as plotly takes them, as plain data with few digits."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.spatial import Array, Indices
from hefting.scene import gaps_between

DIGITS = 7
"""Significant digits of numbers in a page: more than a screen shows, and few enough to
keep it small."""
AXES = ("x", "y", "z")
LEGEND = {
    "orientation": "h",
    "x": 0.0,
    "xanchor": "left",
    "y": 1.0,
    "yanchor": "bottom",
}
Trace = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Figure:
    """One drawing."""

    name: str
    """Of its place in the page, unique"""
    traces: list[Trace]
    layout: dict[str, Any]
    height: int = 420
    """[pixels]"""
    about: str = ""
    """What it shows, for those who cannot see it"""
    config: dict[str, Any] = field(default_factory=dict[str, Any])


def numbers(values: ArrayLike) -> list[Any]:
    """An array as lists of numbers of `DIGITS` digits; None for what is not finite."""
    array = np.asarray(values)
    if array.dtype.kind in "iu":
        return array.tolist()
    if array.ndim > 1:
        return [numbers(row) for row in array]
    return [
        float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
        for value in array.tolist()
    ]


def line(
    time: ArrayLike,
    values: ArrayLike,
    name: str,
    colour: str,
    *,
    dots: bool = False,
    **more: Any,
) -> Trace:
    """A curve, or dots in place of it."""
    look: dict[str, Any] = {"mode": "markers", "marker": {"color": colour, "size": 6}}
    if not dots:
        look = {"mode": "lines", "line": {"color": colour, "width": 1.5}}
    trace = {"type": "scatter", "x": numbers(time), "y": numbers(values), "name": name}
    return trace | look | more


def curve(
    time: Array, values: Array, shown: Indices, name: str, colour: str, **more: Any
) -> Trace:
    """The `shown` samples of a curve over times (K,), without a line over gaps."""
    gaps = gaps_between(time, shown)
    x, y = time[shown].astype(float), values[shown].astype(float)
    x, y = np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan)
    return line(x, y, name, colour, **more)


def band(
    time: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str, **more: Any
) -> Trace:
    """What is between two curves; nothing where one is not finite."""
    t, lower, upper = (np.asarray(v, dtype=float) for v in (time, low, high))
    known = np.isfinite(lower) & np.isfinite(upper)
    t, lower, upper = t[known], lower[known], upper[known]
    return {
        "type": "scatter",
        "x": numbers(np.concatenate((t, t[::-1]))),
        "y": numbers(np.concatenate((upper, lower[::-1]))),
        "fill": "toself",
        "fillcolor": colour,
        "mode": "none",
        "hoverinfo": "skip",
        "showlegend": False,
        **more,
    }


def axis(title: str, **more: Any) -> dict[str, Any]:
    """An axis with its title, in the colours of the page."""
    return {
        "title": {"text": title, "standoff": 6},
        "gridcolor": "@grid",
        "zerolinecolor": "@muted",
        "zerolinewidth": 1,
        "linecolor": "@muted",
        "automargin": True,
        **more,
    }


def rows(
    titles: list[str], heights: list[float], x_title: str, gap: float = 0.06
) -> dict[str, Any]:
    """A layout of rows that have their x axis in common, from the top; axis ``y``, then
    ``y2`` and so on."""
    free = 1.0 - gap * (len(titles) - 1)
    shares = [height / sum(heights) * free for height in heights]
    layout: dict[str, Any] = {}
    top = 1.0
    for i, (title, share) in enumerate(zip(titles, shares, strict=True), 1):
        ends = [max(0.0, top - share), top]
        layout[f"yaxis{i if i > 1 else ''}"] = axis(title, domain=ends)
        top -= share + gap
    last = f"y{len(titles)}" if len(titles) > 1 else "y"
    layout["xaxis"] = axis(x_title, anchor=last)
    layout["legend"] = dict(LEGEND)
    layout["hovermode"] = "x unified"
    return layout

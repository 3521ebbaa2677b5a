"""Figures: traces and layouts of plotly as plain data with few digits, and the colours of
a page, light and dark."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.spatial import Array, Indices, immutable
from hefting.scene import gaps_between

DIGITS = 7
"""Significant digits of numbers in a page: more than a screen resolves."""
AXES = ("x", "y", "z")
LEGEND = {
    "orientation": "h",
    "x": 0.0,
    "xanchor": "left",
    "y": 1.0,
    "yanchor": "bottom",
}
Trace = dict[str, Any]
LIGHT = {
    "paper": "#ffffff",
    "ink": "#222222",
    "muted": "#5c5c5c",
    "grid": "#dddddd",
    "soft": "#f3f3f3",
    "x": "#0072b2",
    "y": "#d55e00",
    "z": "#007d5b",
    "x-pale": "rgba(0,114,178,0.25)",
    "y-pale": "rgba(213,94,0,0.25)",
    "z-pale": "rgba(0,125,91,0.25)",
    "estimate": "#d55e00",
    "truth": "#222222",
    "shape": "#9a9a9a",
    "gravity": "#a8568a",
    "good": "#006e4f",
    "care": "#8a5a00",
    "bad": "#b3261e",
    "contact": "rgba(213,94,0,0.30)",
    "spike": "rgba(168,86,138,0.55)",
    "saturation": "rgba(230,159,0,0.45)",
    "no-pose": "rgba(120,120,120,0.30)",
    "no-wrench": "rgba(60,60,60,0.30)",
    "pose": "rgba(86,180,233,0.40)",
    "touched": "rgba(213,94,0,0.45)",
    "other": "rgba(120,120,120,0.22)",
}
"""Colours on white, by their use. Figures refer to one as ``@name``, styles as
``var(--name)``. Lines have the colour-blind safe ones of Okabe & Ito (2008)."""
DARK = LIGHT | {
    "paper": "#16181c",
    "ink": "#e6e6e6",
    "muted": "#a8adb5",
    "grid": "#3a3e45",
    "soft": "#22252b",
    "x": "#56b4e9",
    "y": "#f0883e",
    "z": "#2fbf94",
    "x-pale": "rgba(86,180,233,0.36)",
    "y-pale": "rgba(240,136,62,0.36)",
    "z-pale": "rgba(47,191,148,0.36)",
    "estimate": "#f0883e",
    "truth": "#f2f2f2",
    "shape": "#8c929b",
    "gravity": "#d79ac0",
    "good": "#4ccfa3",
    "care": "#e6b84d",
    "bad": "#ff8a80",
    "contact": "rgba(240,136,62,0.35)",
    "no-pose": "rgba(170,170,170,0.30)",
    "no-wrench": "rgba(220,220,220,0.25)",
    "other": "rgba(170,170,170,0.22)",
}
"""Colours on near black."""
GAP = 0.06
"""Distance of two rows over the height of the figure."""
MOST_BINS = 60
NARROWEST = 0.002
"""Least width of a histogram's axis [decades]."""
MOST_LABELLED = 2.5
"""Decades up to which an axis has labels within each decade."""


@immutable
class Figure:
    """One drawing."""

    name: str
    """Unique name, for its place in the page"""
    traces: list[Trace]
    layout: dict[str, Any]
    height: int = 420
    """[pixels]"""
    about: str = ""
    """Description for screen readers"""


def numbers(values: ArrayLike) -> list[Any]:
    """An array as lists of numbers of `DIGITS` digits; None for those not finite."""
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
    """A curve, or `dots`."""
    look: dict[str, Any] = {"mode": "markers", "marker": {"color": colour, "size": 6}}
    if not dots:
        look = {"mode": "lines", "line": {"color": colour, "width": 1.5}}
    trace = {"type": "scatter", "x": numbers(time), "y": numbers(values), "name": name}
    return trace | look | more


def curve(
    time: Array, values: Array, shown: Indices, name: str, colour: str, **more: Any
) -> Trace:
    """The `shown` samples of a curve over times (K,), interrupted at gaps."""
    gaps = gaps_between(time, shown)
    x, y = time[shown].astype(float), values[shown].astype(float)
    x, y = np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan)
    return line(x, y, name, colour, **more)


def band(
    time: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str, **more: Any
) -> Trace:
    """The area between two curves, where both are finite."""
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


def rows(titles: list[str], heights: list[float], x_title: str) -> dict[str, Any]:
    """A layout of rows with one x axis; their axes from the top: ``y``, ``y2``, ...."""
    free = 1.0 - GAP * (len(titles) - 1)
    shares = [height / sum(heights) * free for height in heights]
    layout: dict[str, Any] = {}
    top = 1.0
    for i, (title, share) in enumerate(zip(titles, shares, strict=True), 1):
        ends = [max(0.0, top - share), top]
        layout[f"yaxis{i if i > 1 else ''}"] = axis(title, domain=ends)
        top -= share + GAP
    last = f"y{len(titles)}" if len(titles) > 1 else "y"
    layout["xaxis"] = axis(x_title, anchor=last, zeroline=False)
    layout["legend"] = dict(LEGEND)
    layout["hovermode"] = "x unified"
    return layout


def histogram(name: str, title: str, unit: str, values: Array) -> Figure | None:
    """Histogram of the positive values (n,) on a logarithmic axis; None if there are
    none. Other values are not counted."""
    known = values[np.isfinite(values) & (values > 0.0)]
    if not len(known):
        return None
    edges = _edges(np.log10(known))
    count, _ = np.histogram(np.log10(known), edges)
    x = 10.0 ** np.repeat(edges, 2)
    y = np.concatenate(([0], np.repeat(count, 2), [0]))
    middle = float(np.median(known))
    at = numbers([middle])[0]
    trace = line(x, y, title, "@x", fill="tozeroy", fillcolor="@x-pale")
    trace["hovertemplate"] = f"%{{x:.3g}} {unit}: %{{y}}<extra></extra>"
    mark = {
        "type": "line",
        "x0": at,
        "x1": at,
        "y0": 0,
        "y1": 1,
        "yref": "paper",
        "line": {"color": "@estimate", "width": 2, "dash": "dot"},
    }
    layout = {
        "xaxis": axis(f"{title} [{unit}]", type="log", **_ticks(edges)),
        "yaxis": axis(
            "rows", rangemode="tozero", tickformat=",d", dtick=_step(int(count.max()))
        ),
        "showlegend": False,
        "shapes": [mark],
    }
    low, high = np.percentile(known, (2.5, 97.5))
    about = (
        f"{title} of {len(known):,} rows: median (dotted) {middle:.3g} {unit}, "
        f"95 % of them from {low:.3g} to {high:.3g} {unit}"
    )
    return Figure(name, [trace], layout, height=240, about=about)


def _step(largest: int) -> int:
    """Step between the labels of an axis of counts, of 1, 2, 5, 10 and so on, for at most
    five steps."""
    steps = (first * 10**zeros for zeros in range(20) for first in (1, 2, 5))
    return next(step for step in steps if largest <= 5 * step)


def _ticks(edges: Array) -> dict[str, Any]:
    """Labels at 1, 2 and 5 of each decade, only at decades on axes longer than
    `MOST_LABELLED`; plotly's own on axes shorter than a decade."""
    low, high = float(edges[0]), float(edges[-1])
    if high - low < 1.0:
        return {"nticks": 4, "tickangle": 0}
    steps = (1, 2, 5) if high - low < MOST_LABELLED else (1,)
    decades = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    values = [step * 10.0**decade for decade in decades for step in steps]
    return {"tickvals": values, "ticktext": [f"{v:g}" for v in values], "tickangle": 0}


def _edges(sizes: Array) -> Array:
    """Edges of bins that hold all `sizes` (n,), in decades."""
    low, high = float(sizes.min()), float(sizes.max())
    room = max(0.0, 0.5 * (NARROWEST - (high - low)))
    bins = int(np.clip(np.sqrt(len(sizes)), 5, MOST_BINS))
    return np.linspace(low - room, high + room, bins + 1)

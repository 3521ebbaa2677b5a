"""Histogram: how often a positive quantity has which size, on a logarithmic axis."""

from typing import Any

import numpy as np

from hefting.core.spatial import Array
from hefting.page.figure import Figure, axis, line, numbers

MOST_BINS = 60
NARROWEST = 0.002
"""Width of the axis [decades] where all values are the same."""

MOST_LABELLED = 2.5
"""Decades up to which numbers between them are labelled."""


def histogram(name: str, title: str, unit: str, values: Array) -> Figure | None:
    """How many of the values (n,) are in which bin; None where none is positive.

    Values that are missing, zero or negative are not counted.
    """
    known = values[np.isfinite(values) & (values > 0.0)]
    if not len(known):
        return None
    edges = _edges(np.log10(known))
    count, _ = np.histogram(np.log10(known), edges)
    x = 10.0 ** np.repeat(edges, 2)
    y = np.concatenate(([0], np.repeat(count, 2), [0]))
    middle = float(np.median(known))
    trace = line(x, y, title, "@x", fill="tozeroy", fillcolor="@x-pale")
    trace["hovertemplate"] = f"%{{x:.3g}} {unit}: %{{y}}<extra></extra>"
    mark = {
        "type": "line",
        "x0": numbers([middle])[0],
        "x1": numbers([middle])[0],
        "y0": 0,
        "y1": 1,
        "yref": "paper",
        "line": {"color": "@estimate", "width": 2, "dash": "dot"},
    }
    layout = {
        "xaxis": axis(f"{title} [{unit}]", type="log", **_ticks(edges)),
        "yaxis": axis("rows", rangemode="tozero", tickformat=",d", nticks=5),
        "showlegend": False,
        "shapes": [mark],
    }
    low, high = np.percentile(known, (2.5, 97.5))
    about = (
        f"{title} of {len(known):,} rows: median (dotted) {middle:.3g} {unit}, "
        f"95 % of them from {low:.3g} to {high:.3g} {unit}"
    )
    return Figure(name, [trace], layout, height=240, about=about)


def _ticks(edges: Array) -> dict[str, Any]:
    """Labels at 1, 2 and 5 of each decade, or at decades alone where those are many;
    over less than a decade as plotly has them."""
    low, high = float(edges[0]), float(edges[-1])
    if high - low < 1.0:
        return {"nticks": 6, "tickangle": 0}
    steps = (1, 2, 5) if high - low < MOST_LABELLED else (1,)
    decades = range(int(np.floor(low)), int(np.ceil(high)) + 1)
    values = [step * 10.0**decade for decade in decades for step in steps]
    return {"tickvals": values, "ticktext": [f"{v:g}" for v in values], "tickangle": 0}


def _edges(sizes: Array) -> Array:
    """Ends of bins that hold all sizes (n,) [decades]."""
    low, high = float(sizes.min()), float(sizes.max())
    room = max(0.0, 0.5 * (NARROWEST - (high - low)))
    bins = int(np.clip(np.sqrt(len(sizes)), 5, MOST_BINS))
    return np.linspace(low - room, high + room, bins + 1)

"""An estimate in a notebook: verdict, numbers, warnings, picture."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.identification.identify import Answer
from hefting.notebook.html import (
    beside,
    block,
    list_html,
    picture_html,
    table_html,
    verdict_html,
)
from hefting.scene import half_widths, plus_minus, power_of_thousand, scene_of

HEAD = ("quantity", "estimate ± 95 %", "from", "to", "unit")
MOMENTS = {"Jxx": (0, 0), "Jyy": (1, 1), "Jzz": (2, 2)}
PRODUCTS = {"Jxy": (0, 1), "Jxz": (0, 2), "Jyz": (1, 2)}


MOST_WARNINGS = 12
"""Warnings that are shown."""
ALT = "COM with its 95 % region and ellipsoid of equal inertia, in three views"


@dataclass(frozen=True)
class Row:
    """One number of a body."""

    name: str
    value: str
    """With half the width of its interval, or ``open``."""
    low: str
    high: str
    """Ends of its interval; empty where there is none."""
    unit: str

    @property
    def cells(self) -> tuple[str, ...]:
        """As a row below `HEAD`."""
        return self.name, self.value, self.low, self.high, self.unit


def rows_of(estimate: Estimate, products: bool = True) -> list[Row]:
    """Mass, COM and inertia about the COM, in sensor axes; `products` of inertia only
    where they are wanted."""
    p = estimate.parameters
    tensor = p.inertia_at_com
    unit, scale = power_of_thousand(tensor.diagonal())
    mass, com, inertia = (
        _entries(estimate, name, value)
        for name, value in (
            ("mass", np.asarray(p.mass)),
            ("center_of_mass", p.center_of_mass),
            ("inertia_at_com", tensor),
        )
    )
    rows = [_row("mass", mass, (), 1.0, "kg")]
    rows += [_row(f"COM {axis}", com, (i,), 1e3, "mm") for i, axis in enumerate("xyz")]
    wanted = MOMENTS | PRODUCTS if products else MOMENTS
    return rows + [
        _row(f"{name} at COM", inertia, at, scale, f"{unit}kg m²")
        for name, at in wanted.items()
    ]


@dataclass(frozen=True, eq=False)
class _Entries:
    """A quantity, and what is known of how sure it is; arrays of one shape."""

    value: Array
    half: Array | None
    ends: Array | None


def _entries(estimate: Estimate, name: str, value: Array) -> _Entries:
    ends = None if estimate.intervals is None else estimate.intervals[name]
    return _Entries(value, half_widths(estimate, name, value), ends)


def _row(
    name: str, entries: _Entries, at: tuple[int, ...], scale: float, unit: str
) -> Row:
    value = scale * float(entries.value[at])
    half = None if entries.half is None else scale * float(entries.half[at])
    low, high = "", ""
    if entries.ends is not None and half is not None and np.isfinite(half):
        low, high = (
            plus_minus(scale * float(entries.ends[end][at]), half).split(" ± ")[0]
            for end in (0, 1)
        )
    return Row(name, plus_minus(value, half), low, high, unit)


def answer_html(answer: Answer) -> str:
    """What holds an estimate, as a block."""
    return block(card(answer.estimate, type(answer).__name__))


def estimate_html(estimate: Estimate) -> str:
    """An estimate as a block."""
    return block(card(estimate, "Estimate"))


def card(estimate: Estimate, title: str) -> str:
    """Verdict, numbers and warnings beside a picture."""
    extent = "" if estimate.duration is None else f", {estimate.duration:.4g} s"
    source = _source(estimate.provenance.get("log"))
    after = f"{title} by {estimate.method}: {estimate.samples} samples{extent}{source}"
    numbers = table_html(HEAD, [row.cells for row in rows_of(estimate)])
    picture = picture_html(scene_of({"estimate": estimate}), ALT)
    return (
        verdict_html(estimate.verdict, after)
        + warnings_html(estimate)
        + beside(numbers, picture)
    )


def warnings_html(estimate: Estimate) -> str:
    """Warnings that are no reason of the verdict."""
    reasons = estimate.verdict.reasons
    more = [f"warning: {text}" for text in estimate.warnings if text not in reasons]
    if len(more) > MOST_WARNINGS:
        left = len(more) - MOST_WARNINGS
        more[MOST_WARNINGS:] = [f"and {left} more in .warnings"]
    return list_html(more)


def _source(log: Any) -> str:
    """Where it came from, of an estimate that tells it."""
    return f" of {log}" if isinstance(log, str) and log else ""

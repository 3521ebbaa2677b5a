"""Numbers of an estimate as the rows of a table, each with its interval and unit."""

from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.scene import half_widths, plus_minus, power_of_thousand

HEAD = ("quantity", "estimate ± 95 %", "from", "to", "unit")
MOMENTS = {"Jxx": (0, 0), "Jyy": (1, 1), "Jzz": (2, 2)}
PRODUCTS = {"Jxy": (0, 1), "Jxz": (0, 2), "Jyz": (1, 2)}


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

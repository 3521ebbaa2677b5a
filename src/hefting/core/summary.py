"""Summary: an estimate in a few lines, for a prompt."""

from typing import TYPE_CHECKING

import numpy as np

from hefting.core.spatial import tensor_to_vector

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.core.spatial import Array

MOST_WARNINGS = 3
"""Warnings that are shown."""
LONGEST_WARNING = 150
"""Characters of a warning that are shown."""
MOST_DECIMALS = 9
"""Decimals of a number, at most."""
ENTRIES = ("xx", "xy", "xz", "yy", "yz", "zz")


def summary(estimate: "Estimate", title: str) -> str:
    """An estimate in some ten lines and fewer than 1500 characters.

    Half the width of its 95 % interval stands behind each number, which is rounded to
    two digits of that; ``open`` stands where the interval has no end.
    """
    body, ends = estimate.parameters, estimate.intervals or {}

    def shown(name: str, values: "Array", scale: float = 1.0) -> list[str]:
        ends_of = ends.get(name)
        if ends_of is None:
            return [f"{scale * value:.6g}" for value in values]
        low, high = (_flat(end) for end in ends_of)
        return [
            _with_half_width(scale * value, 0.5 * scale * (b - a))
            for value, a, b in zip(values, low, high, strict=True)
        ]

    mass = shown("mass", np.array([body.mass]))[0]
    com = shown("center_of_mass", body.center_of_mass, 1e3)
    inertia = shown("inertia_at_com", _flat(body.inertia_at_com), 1e3)
    tensor = [f"{name} {value}" for name, value in zip(ENTRIES, inertia, strict=True)]
    lines = [
        f"{title} by {estimate.method}, verdict: {estimate.verdict}",
        f"  mass           {mass} kg",
        f"  center of mass {', '.join(com)} mm",
        f"  inertia at COM {', '.join(tensor[:3])}",
        f"                 {', '.join(tensor[3:])} g m²",
        f"  from           {_extent(estimate)}",
    ]
    return "\n".join(lines + _warnings(estimate))


def _flat(values: "Array") -> "Array":
    """Mass, COM or tensor as a vector."""
    values = np.atleast_1d(values)
    return tensor_to_vector(values) if values.ndim == 2 else values


def _with_half_width(value: float, half: float) -> str:
    """A number with half the width of its interval, to two digits of that."""
    if not np.isfinite(half):
        return "open"
    if not half > 0.0:
        return f"{value:.6g}"
    decimals = 1 - int(np.floor(np.log10(half)))
    if decimals > MOST_DECIMALS:
        return f"{value:.3g} ± {half:.2g}"
    decimals = max(decimals, 0)
    rounded = round(value, decimals) + 0.0  # no negative zero
    return f"{rounded:.{decimals}f} ± {half:.{decimals}f}"


def _extent(estimate: "Estimate") -> str:
    """How much it was made from."""
    text = f"{estimate.samples} samples"
    return text if estimate.duration is None else f"{text}, {estimate.duration:.4g} s"


def _warnings(estimate: "Estimate") -> list[str]:
    """The first warnings, cut to a line each, and how many more there are."""
    lines = [
        f"  warning: {text if len(text) <= LONGEST_WARNING else text[: LONGEST_WARNING - 4] + ' ...'}"
        for text in map(str, estimate.warnings[:MOST_WARNINGS])
    ]
    more = len(estimate.warnings) - MOST_WARNINGS
    return [*lines, f"  and {more} more in .warnings"] if more > 0 else lines

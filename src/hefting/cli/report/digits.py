"""Numbers as people read them: as many digits as their interval is worth, points under
each other."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

FEWEST, MOST = 0, 9
"""Decimals that are printed."""
SIGNIFICANT = 4
"""Digits of a number of which nobody says how sure it is."""


def decimals_of(value: float, reach: float | None, digits: int = 2) -> int:
    """Decimals that show so many `digits` of how far a value may be off, its `reach`;
    where that is not known, `SIGNIFICANT` digits of the value."""
    known = reach is not None and np.isfinite(reach) and reach > 0.0
    size, digits = (reach, digits) if known else (abs(value), SIGNIFICANT)
    if not size or not np.isfinite(size):
        return FEWEST
    # 9.96 has as many digits before the point as 10 once it is rounded
    order = int(np.floor(np.log10(size) + 1e-3))
    return int(np.clip(digits - 1 - order, FEWEST, MOST))


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals, without a minus before a zero; ``open`` where it
    is not finite."""
    if not np.isfinite(value):
        return "open"
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def with_reach(values: ArrayLike, reach: float | None) -> str:
    """``"1.4, 172.2, 60.0 ± 0.8"``, with one digit of how far each may be off at most;
    the values alone where nobody says."""
    numbers = np.asarray(values, dtype=float)
    if not np.isfinite(numbers).all() or (reach is not None and not np.isfinite(reach)):
        return "open"
    decimals = decimals_of(float(np.abs(numbers).max()), reach, 1)
    text = ", ".join(fixed(value, decimals) for value in numbers)
    return text if reach is None else f"{text} ± {fixed(reach, decimals)}"


def aligned(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Rows of numbers, filled up so that in each column points stand under each other
    where the column is set to the right."""
    places = [max(map(_places, column)) for column in zip(*rows, strict=True)]
    return [
        [
            text + " " * (most - _places(text))
            for text, most in zip(row, places, strict=True)
        ]
        for row in rows
    ]


def _places(text: str) -> int:
    """Characters from the point on."""
    _, point, part = text.partition(".")
    return len(point) + len(part)

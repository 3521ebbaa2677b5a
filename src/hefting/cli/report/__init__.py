"""Results as readable tables with units, one file for each kind. This file has what they
share: the verdict as the first lines of a report, and numbers with as many digits as
their interval justifies, aligned at the point; ``open`` where neither the recording nor a
shape determines them."""

from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.estimate import Estimate
from hefting.core.messages import Verdict
from hefting.core.quantity import decimals
from hefting.core.spatial import immutable, tensor_to_vector

STATUS_DO_NOT_USE = 3
"""Exit status of a command whose answer is not to be used."""


def verdict_lines(verdict: Verdict) -> list[str]:
    """Lines with the verdict, and each of its reasons."""
    return [f"verdict: {verdict}", *(f"- {reason}" for reason in verdict.reasons)]


def exit_status(verdict: Verdict) -> int:
    """0, or `STATUS_DO_NOT_USE`."""
    return 0 if verdict.usable else STATUS_DO_NOT_USE


FEWEST, MOST = 0, 9
"""Smallest and largest number of printed decimals."""
SIGNIFICANT = 4
"""Significant digits of a number without an interval."""

MILLIMETRE = 3
"""Decimal places by which millimetres differ from metres."""
LEAST_DIGITS = 2
"""Smallest number of significant digits of the mass, and of the largest moment, however
wide their intervals are."""
NOTHING = 0.01
"""Smallest size for the digits of moments, as a share of their widest interval."""


def decimals_of(value: float, reach: float | None) -> int:
    """Number of decimals that shows one significant digit of the half-width of a value's
    interval, its `reach`; without one `SIGNIFICANT` digits of the value."""
    known = reach is not None and np.isfinite(reach) and reach > 0.0
    size, digits = (reach, 1) if known else (abs(value), SIGNIFICANT)
    if not size or not np.isfinite(size):
        return FEWEST
    # 9.96 has as many digits before the point as 10 once it is rounded
    order = int(np.floor(np.log10(size) + 1e-3))
    return int(np.clip(digits - 1 - order, FEWEST, MOST))


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals, zero without a minus; ``open`` if not finite."""
    if not np.isfinite(value):
        return "open"
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def with_reach(
    values: ArrayLike, reach: float | None, least: float | None = None
) -> str:
    """``"1.4, 172.2, 60.0 ± 0.8"``, with one significant digit of their largest
    half-width, the `reach`, or of their `least`; without one the values alone."""
    numbers = np.asarray(values, dtype=float)
    if not np.isfinite(numbers).all() or (reach is not None and not np.isfinite(reach)):
        return "open"
    finest = reach if least is None else least
    decimals = decimals_of(float(np.abs(numbers).max()), finest)
    text = ", ".join(fixed(value, decimals) for value in numbers)
    return text if reach is None else f"{text} ± {fixed(reach, decimals)}"


def aligned(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Rows of numbers, padded so that the points of right-aligned columns are aligned."""
    places = [max(map(_places, column)) for column in zip(*rows, strict=True)]
    return [
        [text + " " * (n - _places(text)) for text, n in zip(row, places, strict=True)]
        for row in rows
    ]


def _places(text: str) -> int:
    """Number of characters from the point on."""
    _, point, part = text.partition(".")
    return len(point) + len(part)


@immutable
class Worth:
    """Decimal places of mass [kg], COM [mm] and inertia at the COM [kg m²], and which of
    the ten are open."""

    places: np.ndarray
    open: np.ndarray

    @classmethod
    def of(cls, estimate: Estimate) -> Self:
        """Decimal places from the intervals of an estimate."""
        p, half = estimate.parameters, estimate.half_widths
        com, moments = p.center_of_mass, p.inertia_at_com.diagonal()
        wide = half["inertia_at_com"]
        widest = float(np.max(wide, where=np.isfinite(wide), initial=0.0))
        size = max(float(np.abs(moments).max()), NOTHING * widest)
        inertia = decimals(wide, size, LEAST_DIGITS)
        places = (
            decimals(half["mass"], abs(p.mass), LEAST_DIGITS),
            *decimals(half["center_of_mass"], float(np.abs(com).max())) - MILLIMETRE,
            *tensor_to_vector(inertia).astype(int),
        )
        return cls(np.array(places, dtype=int), estimate.undetermined.ten)

    def text(self, value: float, row: int, is_estimate: bool) -> str:
        """The number of a row as text; an end of an interval may be open although the
        estimate is not."""
        if not np.isfinite(value) or (is_estimate and self.open[row]):
            return "open"
        return fixed(value, max(int(self.places[row]), 0))

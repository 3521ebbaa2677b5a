"""The ten numbers of an estimate as texts with as many digits as they are worth, and
``open`` for what neither the recording nor a shape determines."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.cli.report.digits import fixed
from hefting.core.estimate import Estimate
from hefting.core.rounding import decimals
from hefting.core.spatial import tensor_to_vector

MILLIMETRE = 3
"""Decimal places by which millimetres differ from metres."""
LEAST_DIGITS = 2
"""Significant digits of the mass, and of the largest moment, that are shown however
wide their intervals are."""


@dataclass(frozen=True, eq=False)
class Worth:
    """Decimal places of mass [kg], COM [mm] and inertia at the COM [kg m²], and which of
    the ten are open."""

    places: np.ndarray
    open: np.ndarray

    @classmethod
    def of(cls, estimate: Estimate) -> Self:
        """From the intervals of an estimate."""
        p, half, open_ = (
            estimate.parameters,
            estimate.half_widths,
            estimate.undetermined,
        )
        com, moments = p.center_of_mass, p.inertia_at_com.diagonal()
        inertia = decimals(
            half["inertia_at_com"], float(np.abs(moments).max()), LEAST_DIGITS
        )
        places = (
            decimals(half["mass"], abs(p.mass), LEAST_DIGITS),
            *decimals(half["center_of_mass"], float(np.abs(com).max())) - MILLIMETRE,
            *tensor_to_vector(inertia).astype(int),
        )
        flags = (
            open_.mass,
            *open_.center_of_mass,
            *tensor_to_vector(open_.inertia_at_com),
        )
        return cls(np.array(places, dtype=int), np.array(flags, dtype=bool))

    def text(self, value: float, row: int, is_estimate: bool) -> str:
        """A number of one row; an end of an interval may be open by itself."""
        if not np.isfinite(value) or (is_estimate and self.open[row]):
            return "open"
        return fixed(value, max(int(self.places[row]), 0))

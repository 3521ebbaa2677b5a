"""What an estimate says of how it was made, which may come from somebody else's file."""

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.magnitudes import LARGEST_PARAMETER
from hefting.core.spatial import Array


def numbers_in(
    estimate: Estimate, key: str, count: int, largest: float
) -> Array | None:
    """So many numbers (count,) of an estimate's provenance, none larger than `largest`;
    None for anything else."""
    try:
        values = np.asarray(estimate.provenance.get(key), dtype=float)
    except (TypeError, ValueError, OverflowError):
        return None
    fits = values.shape == (count,) and bool((np.abs(values) <= largest).all())
    return values if fits else None


def subtracted_tool(estimate: Estimate) -> Array | None:
    """Parameters (10,) of the tool that was subtracted for an estimate, in sensor axes
    about the sensor origin; None where there was none."""
    return numbers_in(estimate, "tool", 10, LARGEST_PARAMETER)

"""Whether a constant bias is estimated with the object, and what is said where the
motion does not tell one."""

from dataclasses import dataclass

import numpy as np

from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.free_fit import FreeFit, free_fit

FEWEST_SAMPLES = 20
"""Samples from which on what a bias explains is no noise."""
LARGE_BIAS = 0.1
"""Bias over the object's weight from which on a mass found without one is not to be
used."""


@dataclass(frozen=True, eq=False)
class FreeFits:
    """Unconstrained least squares of all samples."""

    beside_bias: FreeFit
    """with a free constant bias"""
    alone: FreeFit
    """without bias"""

    @classmethod
    def of(cls, state: SampleState, inflation: Array) -> "FreeFits":
        """Of the samples of a state; `inflation` as of `free_fit`."""
        return cls(free_fit(state, True, inflation), free_fit(state, False, inflation))

    def chosen(self, *, free_bias: bool) -> FreeFit:
        """The one with a bias, or without."""
        return self.beside_bias if free_bias else self.alone

    def flipped(self) -> "FreeFits":
        """The same for the wrench of the other sign."""
        return FreeFits(self.beside_bias.flipped(), self.alone.flipped())


def choose_bias(
    found: Conditioned,
    fits: FreeFits,
    *,
    may_be_biased: bool,
    is_auto: bool,
) -> tuple[bool, list[Message]]:
    """Whether a constant bias is estimated with the object, and a warning when the
    motion does not determine one.

    With an automatic choice it is where the bias drifts or is significantly different
    from zero.
    """
    drifts = found.bias.kind != "constant"
    if (
        not (may_be_biased and is_auto)
        or drifts
        or fits.beside_bias.bias_is_significant
    ):
        return may_be_biased, []
    if not fits.beside_bias.mass_is_open:
        return False, []
    least = _least_bias(fits)
    weight = float(np.linalg.norm(found.gravity)) * abs(float(fits.alone.vector[0]))
    if len(found.rejected) >= FEWEST_SAMPLES and least > LARGE_BIAS * weight:
        what = (
            f"the force is off by {least:.2g} N without a bias, and this motion cannot "
            "tell one from the object's weight: turn the sensor to other orientations, "
            "or give `bias`"
        )
        return False, [error("bias-undetermined", what, "bias")]
    what = "this motion cannot tell a bias from the object's weight: assumed no bias"
    return False, [warning("bias-unknown", what, "bias")]


def _least_bias(fits: FreeFits) -> float:
    """[N] Size of the part of a bias that the object's weight does not account for, as
    that across gravity: what is along it may be as large."""
    alone, beside = fits.alone.noise.force, fits.beside_bias.noise.force
    return float(np.sqrt(3.0 * max(alone**2 - beside**2, 0.0)))

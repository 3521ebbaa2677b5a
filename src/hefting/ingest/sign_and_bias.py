"""Sign and bias of the wrench, and whether it is late, as far as least squares of all
samples tell them."""

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, error, warning
from hefting.core.quantity import significant
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.estimators.sample_state import SampleState
from hefting.ingest.bias import BiasOfEstimate, is_chosen
from hefting.ingest.conditioned import LEAST_MASS, SIGNIFICANT, Conditioned, WrenchSign
from hefting.ingest.free_fit import (
    SMALLEST_GRAVITY_CHANGE,
    FreeFit,
    free_fit,
    wrench_sign,
)
from hefting.ingest.response import Response, response_of

FEWEST_SAMPLES = 20
"""Number of samples from which on a bias is more than noise."""
LARGE_BIAS = 0.1
"""Bias over the object's weight above which a mass found without a bias is wrong."""


@immutable
class FreeFits:
    """Unconstrained least squares of all samples."""

    beside_bias: FreeFit
    """with a free constant bias"""
    alone: FreeFit
    """without bias"""

    @classmethod
    def of(cls, state: SampleState, inflation: Array) -> "FreeFits":
        """Both fits of a state; `inflation` as for `free_fit`."""
        return cls(free_fit(state, True, inflation), free_fit(state, False, inflation))

    def chosen(self, *, free_bias: bool) -> FreeFit:
        """The fit with or without a bias."""
        return self.beside_bias if free_bias else self.alone

    def flipped(self) -> "FreeFits":
        """Both fits for the opposite sign of the wrench."""
        return FreeFits(self.beside_bias.flipped(), self.alone.flipped())


def choose_bias(
    found: Conditioned, fits: FreeFits, *, may_be_biased: bool, is_auto: bool
) -> tuple[bool, list[Message]]:
    """Whether to estimate a constant bias with the object, and a warning where the motion
    does not determine one.

    An automatic choice is to estimate it if it drifts or is significant.
    """
    if not (may_be_biased and is_auto):
        return may_be_biased, []
    if found.bias.kind != "constant" or fits.beside_bias.bias_is_significant:
        return True, []
    if not fits.beside_bias.mass_is_open:
        return False, []
    least = _least_bias(fits)
    weight = float(np.linalg.norm(found.gravity)) * abs(fits.alone.mass)
    if len(found.rejected) >= FEWEST_SAMPLES and least > LARGE_BIAS * weight:
        what = (
            f"the force is off by {least:.2g} N without a bias, and this motion cannot "
            "tell one from the object's weight: turn the sensor to other orientations, "
            "or give `bias`"
        )
        return False, [error("bias-undetermined", what, "bias")]
    what = "this motion cannot tell a bias from the object's weight: assumed no bias"
    return False, [warning("bias-unknown", what, "bias")]


def nothing_held(z: Measurements, fit: FreeFit) -> Message | None:
    """An error where gravity turns in sensor axes but the force does not with it: the
    mass by the `fit` is zero, or some grams at most."""
    most = abs(fit.mass) + SIGNIFICANT * fit.mass_std
    turned = float(np.linalg.norm(np.std(z.gravity, axis=0)))
    still = turned < SMALLEST_GRAVITY_CHANGE * float(np.linalg.norm(STANDARD_GRAVITY))
    if still or not fit.mass_is_open or not most < LEAST_MASS:
        return None
    what = (
        f"the wrench does not change as gravity turns ({significant(1000 * most)} g at most): "
        "nothing is held, or the controller subtracts the payload (set its payload to "
        "zero before recording)"
    )
    return error("nothing-held", what)


def _least_bias(fits: FreeFits) -> float:
    """Lower bound [N] of a bias, by the larger residual of the fit without one: a part of
    the bias, such as that along gravity, may be taken for the object's weight."""
    alone, beside = fits.alone.noise.force, fits.beside_bias.noise.force
    return float(np.sqrt(3.0 * max(alone**2 - beside**2, 0.0)))


@immutable
class Fitted:
    """Sign, bias and delay of a wrench, and the least squares that tell them."""

    measurements: Measurements
    """corrected for a wrench that was filtered"""
    state: SampleState
    """of the measurements"""
    fits: FreeFits
    sign: WrenchSign
    free_bias: bool
    bias_messages: tuple[Message, ...]
    is_empty: bool
    """whether nothing seems to be held"""
    response: Response | None

    @property
    def fit(self) -> FreeFit:
        """The fit with or without a bias."""
        return self.fits.chosen(free_bias=self.free_bias)


def fit_samples(
    z: Measurements,
    found: Conditioned,
    wrench: str,
    bias: str | Array | BiasOfEstimate,
    *,
    may_be_biased: bool,
) -> Fitted:
    """Sign, bias and delay of the wrench."""
    state = SampleState.of(z)
    fits = FreeFits.of(state, found.inflation)
    sign = choose_sign(wrench, found, fits, may_be_biased=may_be_biased)
    free_bias, messages = choose_bias(
        found, fits, may_be_biased=may_be_biased, is_auto=is_chosen(bias)
    )
    empty = nothing_held(z, fits.chosen(free_bias=may_be_biased))
    if empty is not None:
        free_bias, messages = may_be_biased, [empty]
    response = response_of(found, z, fits.chosen(free_bias=free_bias))
    if response is not None:
        z = response.corrected(z)
        state = SampleState.of(z)
        fits = FreeFits.of(state, found.inflation)
    return Fitted(
        z, state, fits, sign, free_bias, tuple(messages), empty is not None, response
    )


def choose_sign(
    wrench: str, found: Conditioned, fits: FreeFits, *, may_be_biased: bool
) -> WrenchSign:
    """The sign convention as given, by the robust fit, or else by the free fits."""
    if may_be_biased and found.sign.t:
        sign = found.sign
    else:
        sign = wrench_sign(fits.beside_bias if may_be_biased else None, fits.alone)
    return sign if wrench == "auto" else WrenchSign(wrench == "on-object", sign.t)


def sign_warnings(sign: WrenchSign) -> list[Message]:
    """A warning if the sign convention that was found is uncertain."""
    if sign.certain:
        return []
    what = f"the wrench's sign is uncertain ({sign.doubt}); assumed {sign.name}"
    return [
        warning("sign-uncertain", f"{what}: give `sign` on-object or on-sensor", "sign")
    ]

"""Sign and bias of the wrench, and whether it is late, as far as least squares of all
samples tell them; and a bias that is given: a model's name, six numbers, a file, or a
time in which nothing was held."""

from dataclasses import replace
from os.path import isfile
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.files import read_json
from hefting.core.magnitudes import LARGEST, check_magnitude
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, error, warning
from hefting.core.quantity import numbers, significant
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array, frozen, immutable
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import LEAST_MASS, SIGNIFICANT, Conditioned, WrenchSign
from hefting.ingest.free_fit import (
    SMALLEST_GRAVITY_CHANGE,
    FreeFit,
    free_fit,
    wrench_sign,
)
from hefting.ingest.response import Response, response_of

MODELS = ("auto", "none", "estimate")
TARE = "tare:"


def tare(recording: Recording, start: float, end: float) -> Array:
    """Mean wrench while nothing was held.

    Parameters
    ----------
    recording : Recording
        The recording.
    start, end : float
        [s] since the first sample of the recording.

    Returns
    -------
    Array
        (6,) [N, N m], with the sign of the recording.

    Raises
    ------
    InputError
        If there are no wrench samples between the two times.
    """
    wrench = recording["wrench"]
    chosen = (wrench.time >= recording.start + start) & (
        wrench.time <= recording.start + end
    )
    if not chosen.any():
        what = f"no wrench between {start:g} and {end:g} s to tare with"
        raise InputError(what, where=recording.source)
    return wrench.values[chosen].mean(axis=0)


@immutable
class BiasOfEstimate:
    """A bias from the file of an estimate."""

    values: Array
    """(6,) [N, N m] with the sign of the wrench on the object"""
    wrench: str
    """sign convention of the log in which it was found"""

    def recorded(self, wrench: str) -> Array:
        """(6,) with the sign of a log of a convention; ``"auto"`` is that of its own."""
        own = self.wrench if wrench == "auto" else wrench
        return -self.values if own == "on-sensor" else self.values


def load_bias(path: str | Path) -> Array | BiasOfEstimate:
    """Read a bias (6,) [N, N m] from a JSON file.

    The file holds six numbers, with the sign of the recording, or a key ``bias``, as an
    estimate does. Raises `InputError` if it holds no six finite numbers.
    """
    data = read_json(path)
    data = data if isinstance(data, dict) else {"bias": data}
    try:
        values = np.asarray(data["bias"], dtype=float)
        wrench = (data.get("provenance") or {}).get("wrench")
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        what = f"holds no bias ({str(error)[:80]})"
        fix = 'write {"bias": [fx,fy,fz,tx,ty,tz]}'
        raise InputError(what, where=path, fix=fix) from error
    if data["bias"] is None:
        raise InputError("found no bias", path, "leave it out, or give `bias` none")
    if values.shape != (6,) or not np.isfinite(values).all():
        raise InputError("a bias is six finite numbers [N, N m]", where=path)
    check_magnitude(values, LARGEST["wrench"], "a bias", path)
    if wrench in ("on-object", "on-sensor"):
        return BiasOfEstimate(values, wrench)
    return values


def bias_of(
    given: str | Path | ArrayLike | BiasOfEstimate,
) -> str | Array | BiasOfEstimate:
    """A bias model's name, or the bias (6,) [N, N m] that is given as numbers or as a JSON
    file; of a tare its text. `InputError` for anything else."""
    if isinstance(given, BiasOfEstimate):
        return given
    if isinstance(given, str | Path):
        given = str(given)
        if given in MODELS or (given.startswith(TARE) and _times(given)):
            return given
        if given.endswith(".json") or isfile(given):
            return load_bias(given)
        if "," not in given:
            fix = "use auto, none, estimate, tare:START,END, six numbers or a JSON file"
            raise InputError(f"unknown bias model '{given}'", "`bias`", fix)
        given = numbers(given, 6, "`bias`")
    values = frozen(given)
    if values.shape != (6,) or not np.isfinite(values).all():
        raise InputError(
            f"a bias is six finite numbers [N, N m], not {np.asarray(given).tolist()}"
        )
    return values


def _times(text: str) -> list[float]:
    """Start and end [s] in the text of a tare."""
    start, end = numbers(text.removeprefix(TARE), 2, "`bias` tare:START,END")
    if end < start:
        raise InputError(f"'{text}' ends before it begins", "`bias`", "as in tare:0,2")
    return [start, end]


def tared(given: str | Array, recording: Recording) -> str | Array:
    """The bias that is given; of a tare that of the recording."""
    if isinstance(given, str) and given.startswith(TARE):
        return tare(recording, *_times(given))
    return given


def is_chosen(bias: str | Array | BiasOfEstimate) -> bool:
    """Whether the bias model is to be chosen."""
    return isinstance(bias, str) and bias == "auto"


def subtract_bias(
    recording: Recording, given: str | Array
) -> tuple[Recording, Array | None]:
    """The recording without the given bias (6,), and that bias; for a bias model's name
    as it is, and None."""
    if isinstance(given, str):
        return recording, None
    wrench = recording["wrench"]
    unbiased = replace(wrench, values=wrench.values - given)
    return replace(recording, streams={**recording.streams, "wrench": unbiased}), given


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

"""The bias of the wrench: given, or a constant that is estimated with the object where
the motion determines it."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.files import read_json
from hefting.core.immutable import immutable
from hefting.core.magnitudes import LARGEST, check_magnitude
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, error, warning
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array, frozen
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import LEAST_MASS, SIGNIFICANT, Conditioned
from hefting.ingest.free_fit import SMALLEST_GRAVITY_CHANGE, FreeFit, free_fit


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
        raise InputError(
            f"no wrench between {start:g} and {end:g} s to tare with",
            where=recording.source,
        )
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
    data, wrench = read_json(path), None
    try:
        values = np.asarray(
            data["bias"] if isinstance(data, dict) else data, dtype=float
        )
        if isinstance(data, dict):
            wrench = (data.get("provenance") or {}).get("wrench")
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise InputError(
            f"holds no bias ({str(error)[:80]})",
            where=path,
            fix='write {"bias": [fx,fy,fz,tx,ty,tz]}',
        ) from error
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
    file; `InputError` for anything else."""
    if isinstance(given, BiasOfEstimate):
        return given
    if isinstance(given, Path) or (isinstance(given, str) and given.endswith(".json")):
        return load_bias(given)
    if isinstance(given, str):
        if given in ("auto", "none", "estimate"):
            return given
        raise InputError(
            f"unknown bias model '{given}'",
            fix="use auto, none, estimate, six numbers or a JSON file",
        )
    values = frozen(given)
    if values.shape != (6,) or not np.isfinite(values).all():
        raise InputError(
            f"a bias is six finite numbers [N, N m], not {np.asarray(given).tolist()}"
        )
    return values


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
    found: Conditioned,
    fits: FreeFits,
    *,
    may_be_biased: bool,
    is_auto: bool,
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


def nothing_held(z: Measurements, fit: FreeFit) -> Message | None:
    """An error where gravity turns in sensor axes but the force does not with it: the
    mass by the `fit` is zero, or some grams at most."""
    std = float(fit.covariance[0, 0]) ** 0.5
    most = abs(float(fit.vector[0])) + SIGNIFICANT * std
    turned = float(np.linalg.norm(np.std(z.gravity, axis=0)))
    still = turned < SMALLEST_GRAVITY_CHANGE * float(np.linalg.norm(STANDARD_GRAVITY))
    if still or not fit.mass_is_open or not most < LEAST_MASS:
        return None
    what = (
        f"the wrench does not change as gravity turns ({1000 * most:.2g} g at most): "
        "nothing is held, or the controller subtracts the payload (set its payload to "
        "zero before recording)"
    )
    return error("nothing-held", what)


def _least_bias(fits: FreeFits) -> float:
    """Lower bound [N] of a bias, by the larger residual of the fit without one: a part of
    the bias, such as that along gravity, may be taken for the object's weight."""
    alone, beside = fits.alone.noise.force, fits.beside_bias.noise.force
    return float(np.sqrt(3.0 * max(alone**2 - beside**2, 0.0)))

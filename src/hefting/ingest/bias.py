"""The bias of the wrench as it is given: a model's name, six numbers, a file, or a time
in which nothing was held."""

from dataclasses import replace
from os.path import isfile
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.files import read_json
from hefting.core.immutable import immutable
from hefting.core.magnitudes import LARGEST, check_magnitude
from hefting.core.quantity import numbers
from hefting.core.recording import Recording
from hefting.core.spatial import Array, frozen

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

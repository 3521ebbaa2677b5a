"""The JSON form of an estimate: what `Estimate.save` writes, and the check of what
`Estimate.load` reads.

The keys are those of ``hefting identify --json`` and are fixed. JSON has no infinity:
null stands where a covariance is infinite, or an accuracy was not asked for.
"""

from collections.abc import Mapping
from typing import Any, cast, get_args

import numpy as np

from hefting.core.accuracy import Accuracy, Certificate
from hefting.core.errors import InputError, encodable, printable
from hefting.core.inertia import InertialParameters
from hefting.core.magnitudes import LARGEST_PARAMETER, LARGEST_VARIANCE, SMALLEST_MASS
from hefting.core.messages import Level, Message, Severity, Verdict
from hefting.core.spatial import Array, frozen
from hefting.core.undetermined import Covariance, Undetermined

SCHEMA = "hefting.estimate/1"
"""Name and version of the form, under the key ``schema``."""
METHODS_SCHEMA = "hefting.methods/1"
"""The same of an object of the estimates of several methods."""
INTERVALS = {
    "mass": (2,),
    "center_of_mass": (2, 3),
    "inertia_at_origin": (2, 3, 3),
    "inertia_at_com": (2, 3, 3),
}
"""Shapes of the lower and upper ends of an estimate's intervals."""

Json = Mapping[str, Any]


def recommended_of(data: dict[str, Any]) -> dict[str, Any]:
    """The estimate of the recommended method, of an object of several methods; any other
    object as it is, or an empty one if the estimate is not there."""
    if data.get("schema") != METHODS_SCHEMA:
        return data
    results: Any = data.get("results")
    for each in cast(list[Any], results) if isinstance(results, list) else ():
        estimate = cast(dict[str, Any], each) if isinstance(each, dict) else {}
        if estimate.get("method") == data.get("recommended"):
            return estimate
    return {}


def fields_of(data: Json) -> dict[str, Any]:
    """Fields of the estimate in JSON values. Raises `KeyError`, `TypeError`,
    `ValueError`, `AttributeError` or `OverflowError` for an incomplete estimate."""
    vector = _array(data, "vector", 10)
    if vector is None or not np.isfinite(vector).all():
        raise ValueError("vector is not ten finite numbers")
    if 0.0 < abs(vector[0]) < SMALLEST_MASS:
        raise ValueError(f"the mass is {vector[0]:.3g} kg")
    parameters = InertialParameters(vector)
    _check_said(data, parameters)
    sufficient = data.get("sufficient")
    if sufficient is not None and type(sufficient) is not bool:
        raise ValueError("sufficient is neither true nor false")
    messages = {
        str(message): message for message in map(_message, data.get("messages") or ())
    }
    return dict(  # noqa: C408
        method=printable(str(data["method"])),
        parameters=parameters,
        samples=int(data["samples"]),
        duration=None if data.get("duration") is None else float(data["duration"]),
        covariance=_covariance(data),
        intervals=_intervals(data.get("intervals")),
        accuracy=_accuracy(data.get("accuracy")),
        sufficient=sufficient,
        undetermined=_undetermined(data.get("undetermined")),
        certificate=_certificate(data.get("certificate")),
        bias=_bias(data),
        point_masses=_array(data, "point_masses", None),
        residual=_array(data, "residual", 2),
        hull_margin=_hull_margin(data.get("consistency")),
        warnings=tuple(
            messages.get(str(text)) or coded(str(text))
            for text in data.get("warnings", ())
        ),
        provenance=_provenance(data.get("provenance", {}), messages),
    )


def _check_said(data: Json, parameters: InertialParameters) -> None:
    """`ValueError` for a mass or COM that contradicts the parameters; each may be
    missing."""
    for name, shape in {"mass": (), "center_of_mass": (3,)}.items():
        found = getattr(parameters, name)
        said = _shaped(data, name, *shape)
        off = 0.0 if said is None else np.abs(said - found).max()
        if off > 1e-3 * np.abs(found).max():
            raise ValueError(f"{name} is not that of vector")


def graver_reasons(data: Json, found: Verdict) -> tuple[Message, ...]:
    """Reasons of the verdict in a file, if that is worse than the verdict `found` from
    the rest of the file; else nothing. Raises as `fields_of`."""
    levels, said = get_args(Level), data.get("verdict") or get_args(Level)[0]
    reasons = cast("list[object]", data.get("reasons") or ["its file says so"])
    texts = [text for text in reasons if isinstance(text, str)]
    if said not in levels or texts != reasons:
        raise ValueError("the verdict is none, or its reasons are no texts")
    if levels.index(said) <= levels.index(found.level):
        return ()
    severity = "error" if said == levels[-1] else "warning"
    return tuple(Message("unknown", text, severity) for text in texts)


def coded(text: str) -> Message:
    """A message as it is; a text without a code gets ``unknown``."""
    return text if isinstance(text, Message) else Message("unknown", text)


def json_ready(value: Any) -> Any:
    """Arrays as lists, non-finite numbers as None and texts as UTF-8 allows,
    recursively in dicts and lists."""
    if isinstance(value, dict):
        items = cast(dict[Any, Any], value).items()
        return {encodable(str(k)): json_ready(v) for k, v in items}
    if isinstance(value, list | tuple):
        return [json_ready(v) for v in cast(list[Any], value)]
    if isinstance(value, np.ndarray):
        return json_ready(cast(Array, value).tolist())
    if isinstance(value, str):
        return encodable(value)
    if isinstance(value, np.generic):
        return json_ready(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _array(data: Json, name: str, *shape: int | None) -> Array | None:
    """The array `name`, of a shape in which None is any length; None if missing."""
    values = _shaped(data, name, *shape)
    if values is not None and not np.isfinite(values).all():
        raise ValueError(f"{name} holds what is no number")
    _check_size(values, LARGEST_PARAMETER, name)
    return values


def _bias(data: Json) -> Array | None:
    """(6,), or (n, 6) those of n recordings."""
    values: Any = data.get("bias")
    several = isinstance(values, list) and any(
        isinstance(own, list) for own in cast(list[Any], values)
    )
    return _array(data, "bias", None, 6) if several else _array(data, "bias", 6)


def _check_size(values: Array | None, largest: float, name: str) -> None:
    """`ValueError` for a number beyond `largest` that is not infinite."""
    if values is None:
        return
    if (np.abs(values[np.isfinite(values)]) > largest).any():
        raise ValueError(f"{name} holds a number beyond {largest:.0e}")


def _shaped(data: Json, name: str, *shape: int | None) -> Array | None:
    if data.get(name) is None:
        return None
    values = np.array(data[name], dtype=float)
    if len(values.shape) != len(shape) or any(
        n not in (None, m) for n, m in zip(shape, values.shape, strict=True)
    ):
        raise ValueError(f"{name} has shape {values.shape}")
    return values


def _covariance(data: Json) -> Array | None:
    """(10, 10) covariance; null on the diagonal is an infinite variance."""
    values = _shaped(data, "covariance", 10, 10)
    if values is None:
        return None
    undetermined = [i for i in range(10) if data["covariance"][i][i] is None]
    values[undetermined, undetermined] = np.inf
    if np.isnan(values).any():
        raise ValueError("covariance holds what is no number")
    _check_size(values, LARGEST_VARIANCE, "covariance")
    try:
        Covariance.of(values)
    except InputError as error:
        raise ValueError(error.what) from error
    return values


def _certificate(data: Json | None) -> Certificate | None:
    if data is None:
        return None
    return Certificate(
        objective=float(data["objective"]),
        bound=float(data["bound"]),
        iterations=int(data["iterations"]),
        converged=bool(data["converged"]),
    )


def _intervals(data: Json | None) -> dict[str, Array] | None:
    if data is None:
        return None
    intervals = {str(name): _opened(str(name), ends) for name, ends in data.items()}
    if {name: ends.shape for name, ends in intervals.items()} != INTERVALS:
        raise ValueError("the intervals are not those of mass, COM and inertia")
    if any(
        np.isnan(ends).any() or (ends[0] > ends[1]).any() for ends in intervals.values()
    ):
        raise ValueError("an interval has no lower and upper end")
    return intervals


def _opened(name: str, values: Any) -> Array:
    """Lower and upper ends; null is no end, as the mass may have below."""
    ends = np.array(values, dtype=float)
    if len(ends.shape) and len(ends) == 2:
        ends[1] = np.where(np.isnan(ends[1]), np.inf, ends[1])
        if name != "mass":
            ends[0] = np.where(np.isnan(ends[0]), -np.inf, ends[0])
    _check_size(ends, LARGEST_VARIANCE, "intervals")
    return frozen(ends)


def _accuracy(data: Json | None) -> Accuracy | None:
    if data is None:
        return None
    limits = [data[name] for name in ("mass", "center_of_mass", "inertia")]
    if not all(
        limit is None or (_is_number(limit) and limit > 0.0) for limit in limits
    ):
        raise ValueError("an accuracy is not a positive number")
    return Accuracy(*(np.inf if limit is None else float(limit) for limit in limits))


def _undetermined(data: Json | None) -> Undetermined | None:
    """None for a file without the key; the intervals then show it."""
    return None if data is None else Undetermined.from_dict(data)


def _hull_margin(consistency: Json | None) -> float | None:
    margins: Json = (consistency or {}).get("margins") or {}
    hull: Any = margins.get("hull")
    if hull is not None and not _is_number(hull):
        raise ValueError("the margin of the hull is not a finite number")
    return None if hull is None else float(hull)


def _is_number(value: Any) -> bool:
    """Whether a JSON value is a finite number, which a truth value is not."""
    return type(value) in (int, float) and bool(np.isfinite(value))


def _provenance(data: Json, messages: Mapping[str, Message]) -> dict[str, Any]:
    """Provenance with the codes of its notes; `ValueError` for no list of texts."""
    provenance = dict(data)
    if "notes" in provenance:
        found: Any = provenance["notes"]
        notes = cast(list[Any], found if isinstance(found, list) else [None])
        if not all(isinstance(text, str) for text in notes):
            raise ValueError("the notes are not a list of texts")
        provenance["notes"] = [messages.get(text) or printable(text) for text in notes]
    return provenance


def _message(data: Json) -> Message:
    severity, argument = data["severity"], data.get("argument")
    recordings: Any = data.get("recordings", [])
    if not isinstance(recordings, list):
        raise ValueError("the recordings of a message are not a list")
    own = tuple(cast(list[Any], recordings))
    texts = (data["code"], data["text"], *own)
    texts = texts if argument is None else (*texts, argument)
    if severity not in get_args(Severity) or not all(
        isinstance(text, str) for text in texts
    ):
        raise ValueError("a message is not made of texts")
    return Message(data["code"], data["text"], severity, argument, own)


def numbers_in(
    provenance: Mapping[str, Any], key: str, count: int, largest: float
) -> Array | None:
    """Numbers (count,) under a key of an estimate's provenance, none above `largest`;
    None for anything else, as a file may hold."""
    try:
        values = np.asarray(provenance.get(key), dtype=float)
    except (TypeError, ValueError, OverflowError):
        return None
    fits = values.shape == (count,) and bool((np.abs(values) <= largest).all())
    return values if fits else None


EMPTY_RUNS = "empty runs"
"""Source of the arm's parameters, for joint torques of the object alone."""


def subtracted_tool(provenance: Mapping[str, Any]) -> Array | None:
    """Parameters (10,) of the tool that was subtracted for an estimate, in sensor axes
    about the sensor origin; None for none."""
    return numbers_in(provenance, "tool", 10, LARGEST_PARAMETER)

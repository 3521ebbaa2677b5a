"""Making an estimator for a recording, checking a given one, and handing it the samples."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from hefting.core.errors import InputError, NeedError, nearest
from hefting.core.measurements import Measurements
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.estimators import Estimator, default_method, method_named, methods_with
from hefting.estimators.base import Known
from hefting.estimators.joint_state import State
from hefting.ingest.ingested import Ingested
from hefting.shapes import Shape

Method = str | type[Estimator] | Estimator
"""A method by its name or class, or with all hyperparameters."""
SHAPES = {
    "a bounding box": "box:X0,X1,Y0,Y1,Z0,Z1 or FILE",
    "a shape": "FILE or box:X0,X1,Y0,Y1,Z0,Z1",
    "labelled parts": "FILE.ply of points with a 'segmentation' property",
}
"""Arguments to advise, by what a method needs."""


def estimator_of(
    method: Method,
    found: Ingested,
    shape: Shape | None,
    hyperparameters: dict[str, Any],
) -> Estimator:
    """The estimator of a method's name or class, as by `estimator_for`, or the given one;
    `InputError` if that does not estimate the recording's bias."""
    if isinstance(method, Estimator):
        require_its_bias(method, found)
        return method
    kind, settings = method_named(method)
    return estimator_for(kind, found, shape, hyperparameters | settings)


def estimator_for(
    kind: type[Estimator],
    found: Ingested,
    shape: Shape | None,
    hyperparameters: dict[str, Any],
) -> Estimator:
    """An estimator whose hyperparameters, unless given, follow from a recording and a
    shape.

    Parameters
    ----------
    kind : class of the method.
    found : the recording as read and conditioned.
    shape : of the object in the sensor frame.
    hyperparameters : values by name. The value "shape" stands for `shape` itself where
        the method takes one for that hyperparameter.

    Raises `InputError` if the method needs what is not given, or has no such
    hyperparameter.
    """
    return estimator_knowing(kind, known_of(found, shape), hyperparameters)


def estimator_knowing(
    kind: type[Estimator], facts: Known, hyperparameters: dict[str, Any]
) -> Estimator:
    """As `estimator_for`, from the facts about a recording of any sensor."""
    shape, model = facts.shape, hyperparameters.get("model")
    _require_hyperparameters(kind, model, hyperparameters)
    takes_shape = [
        name for name in kind.takes_shape if hyperparameters.get(name) == "shape"
    ]
    _require_shape(kind, shape, hyperparameters, takes_shape)
    settings = kind.settings(facts, model)
    if any(name in hyperparameters for name in kind.instead_of_shape):
        settings.pop("shape", None)
    return kind(**(settings | hyperparameters | dict.fromkeys(takes_shape, shape)))


def _require_hyperparameters(
    kind: type[Estimator], model: Any, names: Iterable[str]
) -> None:
    """`InputError` for a name that is no hyperparameter of the method in this model."""
    known = kind.hyperparameters(model)
    for name in names:
        if name not in known:
            others = methods_with(name)
            what = f"{kind.__name__} has no '{name}'{nearest(name, known)}"
            fix = f"it has {', '.join(known)}"
            raise InputError(what, fix=f"{', '.join(others)} has it" if others else fix)


def _require_shape(
    kind: type[Estimator],
    shape: Shape | None,
    hyperparameters: dict[str, Any],
    takes_shape: list[str],
) -> None:
    """`NeedError` where the method needs a shape, or labelled parts, and has none;
    `takes_shape` are the hyperparameters whose value is the shape."""
    name, needs = kind.__name__, kind.needs
    if takes_shape:
        name, needs = f"{name}-{takes_shape[0]}", kind.takes_shape[takes_shape[0]]
    instead = any(key in hyperparameters for key in kind.instead_of_shape)
    missing = shape is None and needs != "nothing" and not instead
    unlabelled = shape is not None and shape.labels is None
    if missing or (unlabelled and needs == "labelled parts"):
        other = f", or use {default_method(False)}" if missing else ""
        fix = f"give `shape` {SHAPES[needs]}{other}"
        raise NeedError(f"{name} needs {needs}", fix=fix)


def known_of(found: Ingested, shape: Shape | None) -> Known:
    """The facts from which hyperparameters may follow."""
    return Known(
        bias=found.bias,
        noise=found.fit.noise,
        motion_noise=None if found.source == "columns" else found.motion_noise,
        smoothed=found.source in ("smooth", "inertial"),
        systematic=found.common_errors,
        carried=None if found.tool is None else found.tool.parameters.vector,
        shape=shape,
    )


def accuracy_of(
    method: Any, hyperparameters: Mapping[str, Any]
) -> SensorAccuracy | str | None:
    """The sensor's accuracy, from the hyperparameters or else an estimator; None if it is
    not given."""
    own = getattr(method, "sensor_accuracy", None)
    return hyperparameters.get("sensor_accuracy", own)


def shape_of(
    method: Any, shape: Shape | None, hyperparameters: Mapping[str, Any]
) -> Shape | None:
    """The shape that is known: of a complete estimator its own, None if that is only a
    neighbourhood of the sensor, and of a method's name, or None, the given one.
    `InputError` if a shape or hyperparameters are given beside an estimator."""
    if not isinstance(method, Estimator):
        return shape
    own = getattr(method, "shape", None)
    for name in (*hyperparameters, *(["shape"] if shape not in (None, own) else [])):
        what = f"`{name}` is given beside an estimator that is complete"
        fix = f"give it to {type(method).__name__}, or give the method's name"
        raise InputError(what, fix=fix)
    return own if isinstance(own, Shape) and own.known != "reach" else None


def require_its_bias(estimator: Estimator, found: Ingested) -> None:
    """`InputError` if the wrench has a bias that the estimator does not estimate."""
    if found.bias == "estimate" and getattr(estimator, "bias", "estimate") == "none":
        name = type(estimator).__name__
        what = f"the wrench has a bias, which the {name} that is given does not find"
        fix = f"make it {name}(..., bias='estimate'), or give `bias`='none'"
        raise InputError(what, found.log, fix)


def out_of_order(found: Ingested) -> InputError:
    """That a recording's samples are gone, which a method needs in order."""
    what = "an accuracy to stop at (`until`) needs the samples in order"
    fix = "leave it out, or identify the recordings themselves"
    return InputError(what, found.log, fix)


def state_of(estimator: Estimator, part: Ingested) -> State:
    """State of an estimator that has seen one recording.

    Raises `InputError` if the recording has no samples any more and was condensed for
    another method.
    """
    how = estimator.sampling
    state = None if how is None else part.condensed.states.get(how)
    if state is None and part.has_samples:
        return estimator.update(estimator.start(), taken(estimator, part))
    if state is None:
        what = f"was condensed for another method than {estimator.name}"
        fix = "condense it with the method and hyperparameters that identify it"
        raise InputError(what, part.log, fix)
    if estimator.start().record is None:
        state = replace(state, record=None)
    count = part.samples / part.rows
    return state.scaled(count) if estimator.depends_on_count else state


def taken(estimator: Estimator, part: Ingested) -> Measurements:
    """Measurements of a recording, with the weights that the method expects."""
    return part.weighted_by_count if estimator.depends_on_count else part.measurements

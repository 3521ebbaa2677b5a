"""Recording -> Estimate: the whole way, with what has to be found out on it (sign,
bias, weights) and told."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, NeedError, NotIdentifiableError, nearest
from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH, GravityLike
from hefting.core.measurements import Measurements
from hefting.core.messages import warning
from hefting.core.progress import report
from hefting.core.recording import Recording
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.estimators import (
    OLS,
    Estimator,
    default_method,
    method_named,
    methods_with,
)
from hefting.estimators.base import Known
from hefting.identification.answer import Answer
from hefting.identification.checks import Checked, warnings_of
from hefting.identification.known import known_of
from hefting.identification.own_estimator import require_its_bias, shape_of
from hefting.identification.run import run, understand
from hefting.identification.undetermined import undetermined_by
from hefting.identification.widened import widened_covariance
from hefting.ingest.conditioned import WrenchSign
from hefting.ingest.ingest import Ingested, ingest
from hefting.ingest.plausibility import named_instead, require_object
from hefting.ingest.several import Log
from hefting.motion.measure import Source
from hefting.shapes import Shape
from hefting.shapes.doubt import REACH

SHAPES = {
    "a bounding box": "box:X0,X1,Y0,Y1,Z0,Z1 or FILE",
    "a shape": "FILE or box:X0,X1,Y0,Y1,Z0,Z1",
    "labelled parts": "FILE.ply of points with a 'segmentation' property",
}
"""What to give for what a method needs."""


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Answer):
    """An estimate and the measurements it was made from.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv")
    >>> found.verdict.usable, len(found.measurements), found.source
    (True, 1000, 'smooth')
    >>> round(found.mass, 2)
    0.67
    """

    estimate: Estimate
    measurements: Measurements
    """With the sign convention of `hefting.core.spatial`, a given bias removed, and the
    weights that were used."""
    sign: WrenchSign | None
    """What the data say of the wrench's sign; None when it was given."""
    source: str
    """How the motion was found: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    ingested: Ingested
    """The recording as far as it was used, with what was found and left out."""
    estimator: Estimator
    """What made the estimate, with all hyperparameters."""


def identify(
    recording: Log | Sequence[Log],
    shape: Shape | None = None,
    *,
    method: str | Estimator | None = None,
    gravity: GravityLike = ON_EARTH,
    wrench: Literal["auto", "on-object", "on-sensor"] = "auto",
    bias: Literal["auto", "none", "estimate"] | ArrayLike = "auto",
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
    tool: Estimate | None = None,
    **hyperparameters: Any,
) -> Identification:
    """Identify the object a recording shows.

    Parameters
    ----------
    recording : a recording or the path of a log; or a list of these, several recordings
        of the same object in the same grasp, each of which has a clock, a wrench bias
        and a sign of its own.
    shape : where the object may have mass, in the sensor frame. Without one Bayes takes
        an object of any shape near the sensor for possible (`Shape.unknown`).
    method : name of an estimator (`hefting.estimators.METHODS`) or of a variant; by
        default the first (`hefting.estimators.default_method`). An estimator is used
        as it is, with its own shape and hyperparameters.
    gravity : (3,) in world axes [m/s²], which is exact; `Gravity.at` a latitude;
        ``"estimate"`` finds its direction, for a robot on a tilted base. By default
        standard gravity, whose size may be that of anywhere on the Earth.
    wrench : which way the sensor counts; ``"auto"`` finds out from gravity.
    bias : ``"estimate"`` finds a constant bias with the object, ``"none"`` assumes
        there is none, ``"auto"`` keeps one that exceeds three standard deviations; or
        six numbers [N, N m], as recorded, to subtract. Of n recordings (n, 6) are one
        for each.
    motion : where velocities and accelerations come from, see
        `hefting.motion.measure.measure`.
    start, duration : part of the recording to use [s], or of each.
    tool : estimate, in the same sensor frame, of what the sensor holds besides the
        object, to subtract.
    hyperparameters : fields of the estimator. Of Bayes: ``pose_std`` and ``shape_std``
        where pose or shape are not exact, ``until`` to use no more of the recording
        than it takes. Of all methods: ``sensor_accuracy``; ``mass``, a scale's reading
        of the object without the tool, as in ``"0.512kg±1g"``, or mass and standard
        deviation [kg], see `hefting.MassReading`. Of PMD: ``c1``, which is
        `hefting.estimators.sample_state.SMOOTHED_C1` where poses are smoothed here,
        else the paper's.

    Raises `InputError` for input that cannot be right (names what, where and what to
    do) and `NotIdentifiableError` when the recording determines nothing.
    """
    if isinstance(method, Estimator):
        shape = shape_of(method, shape, hyperparameters)
    found = understand(
        recording,
        gravity=gravity,
        wrench=wrench,
        bias=bias,
        motion=motion,
        start=start,
        duration=duration,
        tool=tool,
    )
    return identify_understood(found, shape, method, hyperparameters)


def identify_understood(
    found: Ingested,
    shape: Shape | None,
    method: str | Estimator | None,
    hyperparameters: dict[str, Any],
) -> Identification:
    """Identify the object in one recording, or in several, that were understood; for
    arguments and errors see `identify`."""
    warnings = ()
    if method is None:
        method = default_method(shape is not None)
        if shape is None:
            what = (
                f"no shape given, so {method} takes any object of up to some 40 cm "
                f"within {REACH:g} m of the sensor for possible: give `shape` for more"
            )
            warnings = (warning("no-shape", what, "shape"),)
    require_object(found, shape)
    estimator = estimator_of(method, found, shape, hyperparameters)
    report("identifying")
    estimate, found = run(estimator, found)
    estimate = with_diagnostics(estimate, estimator, found, shape)
    estimate = replace(estimate, warnings=(*warnings, *estimate.warnings))
    return _identification(estimate, estimator, found)


def estimator_of(
    method: str | Estimator,
    found: Ingested,
    shape: Shape | None,
    hyperparameters: dict[str, Any],
) -> Estimator:
    """The estimator that a name stands for, as `estimator_for` makes it; or the one
    that is given. `InputError` where that has another bias than the recording."""
    if isinstance(method, Estimator):
        require_its_bias(method, found)
        return method
    kind, settings = method_named(method)
    return estimator_for(kind, found, shape, hyperparameters | settings)


def _identification(
    estimate: Estimate, estimator: Estimator, found: Ingested
) -> Identification:
    return Identification(
        estimate,
        found.measurements,
        found.sign if found.sign_found else None,
        found.source,
        found,
        estimator,
    )


def calibrate(
    recording: Recording | str | Path,
    *,
    gravity: GravityLike = ON_EARTH,
    sensor_accuracy: SensorAccuracy | str | None = None,
) -> Estimate:
    """Estimate of a bare tool, for `identify(..., tool=)`: with covariance, the
    wrench's bias, and its noise; `sensor_accuracy` is that of the sensor.

    Ten-parameter least squares, which has no prior to lean the object's estimate one
    way. The bias is in ``Estimate.bias``, the noise levels in ``provenance["noise"]``.
    Errors as for `identify`; `NotIdentifiableError` also when the motion leaves the COM
    open.

    Examples
    --------
    >>> tool = hefting.calibrate("demo/log.csv")  # of the gripper alone
    >>> tool.bias.shape
    (6,)
    >>> tool.save("gripper.json")  # then identify(..., tool="gripper.json")
    """
    return calibration(
        recording, gravity=gravity, sensor_accuracy=sensor_accuracy
    ).estimate


def calibration(
    recording: Recording | str | Path,
    *,
    gravity: GravityLike = ON_EARTH,
    sensor_accuracy: SensorAccuracy | str | None = None,
) -> Identification:
    """The estimate of `calibrate`, with the measurements it was made from; arguments
    and errors as there."""
    found = ingest(recording, gravity=gravity, bias="estimate")
    require_object(found, None)
    settings = OLS.settings(known_of(found, None))
    estimator = OLS(**settings, sensor_accuracy=sensor_accuracy)
    state = estimator.update(estimator.start(), found.measurements)
    estimate = with_diagnostics(estimator.estimate(state), estimator, found, None)
    # with all that may be wrong, as it becomes an error of every object
    covariance = estimator.uncertainty(estimate.parameters, state)[1]
    if not np.isfinite(covariance.diagonal()[:4]).all():
        raise NotIdentifiableError(
            "the motion leaves the tool's centre of mass open",
            found.log,
            "turn the sensor about two axes or more",
        )
    estimate = replace(estimate, covariance=covariance)
    return _identification(estimate, estimator, found)


def estimator_for(
    kind: type[Estimator],
    found: Ingested,
    shape: Shape | None,
    hyperparameters: dict[str, Any],
) -> Estimator:
    """Create an estimator; hyperparameters that are not given follow from the recording
    and the shape.

    Parameters
    ----------
    kind : type of Estimator
        Class of the method.
    found : Ingested
        The recording as read and conditioned.
    shape : Shape, optional
        Shape of the object in the sensor frame.
    hyperparameters : dict
        Values by name. The value "shape" stands for `shape` itself where the method
        takes one for that hyperparameter.

    Returns
    -------
    Estimator

    Raises
    ------
    InputError
        If the method needs what is not given, or has no such hyperparameter.
    """
    return estimator_knowing(kind, known_of(found, shape), hyperparameters)


def estimator_knowing(
    kind: type[Estimator], facts: Known, hyperparameters: dict[str, Any]
) -> Estimator:
    """The same for what is known before any method, from whatever sensor."""
    shape, model = facts.shape, hyperparameters.get("model")
    known = kind.hyperparameters(model)
    for name in hyperparameters:
        if name not in known:
            raise _unknown_hyperparameter(kind, name, known)
    named_shape = [
        name for name in kind.takes_shape if hyperparameters.get(name) == "shape"
    ]
    _require_what_it_needs(kind, shape, hyperparameters, named_shape)
    settings = kind.settings(facts, model)
    if any(name in hyperparameters for name in kind.instead_of_shape):
        settings.pop("shape", None)
    return kind(**(settings | hyperparameters | dict.fromkeys(named_shape, shape)))


def _unknown_hyperparameter(
    kind: type[Estimator], name: str, known: Iterable[str]
) -> InputError:
    """The error for a hyperparameter that the method does not have."""
    others = methods_with(name)
    fix = f"{', '.join(others)} has it" if others else f"it has {', '.join(known)}"
    return InputError(f"{kind.__name__} has no '{name}'{nearest(name, known)}", fix=fix)


def _require_what_it_needs(
    kind: type[Estimator],
    shape: Shape | None,
    hyperparameters: dict[str, Any],
    standing: list[str],
) -> None:
    """`NeedError` where the shape is not there, or not as a method needs it; `standing`
    are its hyperparameters for which the shape stands."""
    name, needs = kind.__name__, kind.needs
    if standing:
        name, needs = f"{name}-{standing[0]}", kind.takes_shape[standing[0]]
    if (
        shape is None
        and needs != "nothing"
        and not any(key in hyperparameters for key in kind.instead_of_shape)
    ):
        raise NeedError(
            f"{name} needs {needs}",
            fix=f"give `shape` {SHAPES[needs]}, or use {default_method(False)}",
        )
    if needs == "labelled parts" and shape is not None and shape.labels is None:
        raise NeedError(f"{name} needs {needs}", fix=f"give `shape` {SHAPES[needs]}")


def with_diagnostics(
    estimate: Estimate, estimator: Estimator, found: Ingested, shape: Shape | None
) -> Estimate:
    """The estimate with its residual, with what was assumed and what gives doubt.

    Raises `NotIdentifiableError` when its mass is not positive.
    """
    negative = (
        estimate.intervals is not None and not estimate.intervals["mass"][1] > 0.0
    )
    if negative or not estimate.parameters.mass > 0.0:
        if shape is None or not estimator.rests_on_shape:
            what = "no positive mass explains the wrench"
            fix = "check `sign` and `gravity`"
        else:
            doubts = f" ({'; '.join(shape.warnings)})" if shape.warnings else ""
            what = f"no mass inside the shape explains the wrench{doubts}"
            fix = "check the shape's pose and unit"
        refusal = NotIdentifiableError(what, where=found.log, fix=fix)
        raise named_instead(refusal, found)
    rms = found.residual(estimate.sensed_vector, estimate.bias)
    provenance = found.provenance | estimator.provenance | estimate.provenance
    own: Shape | None = getattr(estimator, "shape", None)
    if own is not None and own.known != "reach":
        provenance["points"] = own.n
    estimate = replace(
        estimate,
        samples=round(found.samples),
        duration=found.duration,
        covariance=widened_covariance(estimate, estimator, found),
        hull_margin=_margin(estimate, shape),
        residual=rms,
        provenance=provenance,
    )
    estimate = replace(
        estimate, undetermined=undetermined_by(estimate, estimator, found, shape)
    )
    checked = Checked(estimate, rms, estimator, found, shape)
    return replace(estimate, warnings=warnings_of(checked))


def _margin(estimate: Estimate, shape: Shape | None) -> float | None:
    """Depth of the COM in the hull; where the shape is uncertain the method knows
    better where that is."""
    if shape is None or estimate.hull_margin is not None:
        return estimate.hull_margin
    return shape.margin(estimate.parameters.center_of_mass)

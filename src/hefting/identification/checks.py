"""Checks of an estimate: errors that its method neglects, what is open, and doubts.

Each check is a function from `Checked` to messages with a line in `CHECKS`; its messages
are part of `Estimate.warnings`, with their codes in the output for machines.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message, codes, error, warning
from hefting.core.quantity import EXAMPLE, MassReading
from hefting.core.spatial import Array, immutable
from hefting.core.undetermined import Undetermined, undetermined_mass
from hefting.estimators import Bayes, Estimator
from hefting.identification.estimator import state_of
from hefting.ingest.free_fit import TYPICAL_SIZE
from hefting.ingest.identifiability import identifiability
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import JointIngested
from hefting.ingest.plausibility import (
    com_warnings,
    density_warnings,
    mass_warnings,
    misfit_warnings,
    named_instead,
    sum_of_moments,
    torque_sign_messages,
)
from hefting.ingest.tool import left_open
from hefting.shapes import Shape

LARGEST_CHANGE_BY_SHAPE = 2.0
"""Difference of the masses with a shape and by least squares, in standard deviations,
that is attributed to chance."""
LARGEST_HALF_WIDTH = 0.5
"""Half-width of an interval over the mass, or over the largest moment of inertia, up to
which a number counts as known."""

CONTRADICTED = "shape-contradicts-wrench"
"""Code of the message that no likely body explains the wrench."""


@immutable
class Checked:
    """An estimate and what it is based on."""

    estimate: Estimate
    residual: Array
    """(2,) root mean square residual of force [N] and torque [N m]"""
    estimator: Estimator
    found: Ingested
    shape: Shape | None


Check = Callable[[Checked], Iterable[str]]


def warnings_of(checked: Checked) -> tuple[str, ...]:
    """Messages of all checks in order, without consequences of a named mistake."""
    messages = tuple(message for check in CHECKS for message in check(checked))
    doubt = checked.found.doubt
    return messages if doubt is None else doubt.without_consequences(messages)


def _undetermined(checked: Checked) -> Iterable[Message]:
    """A warning of what the motion leaves open, where the estimate follows from the
    shape or the method."""
    fit, estimator, tool = checked.found.fit, checked.estimator, checked.found.tool
    if not estimator.rests_on_shape or checked.shape is None:
        motion = checked.found.excitation
        summary = identifiability(motion, fit, TYPICAL_SIZE, tool).summary
        return [warning("not-identifiable", line) for line in summary]
    size = float(np.linalg.norm(checked.shape.extents))
    kinds = {name[0] for name in fit.open_parameters(size)}
    names = [n for n, kind in (("the COM", "m"), ("the inertia", "J")) if kind in kinds]
    if not names:
        return []
    whose, fix = "motion", ""
    if left_open(tool).any():
        whose, fix = "tool's estimate", " (record the gripper empty in motion)"
    what = f"the {whose} leaves {' and '.join(names)} open{fix}: what is shown follows from {estimator.assumes}"
    return [warning("open-without-shape", what)]


def _method_warnings(checked: Checked) -> Iterable[str]:
    """Warnings of the method. If no body explains the wrench without the tool's, and no
    shape is given, the tool may not have been there."""
    own, tool = checked.estimate.warnings, checked.found.tool
    if tool is None or CONTRADICTED not in codes(own):
        return own
    what = (
        f"no likely body explains what the tool of {tool.parameters.mass:.3g} kg leaves "
        "of the wrench: was it on the sensor in this recording? identify without `tool`"
    )
    if checked.shape is not None:
        return (*own, warning("tool-contradicts-wrench", what, "tool"))
    left = [m for m in own if getattr(m, "code", "") != CONTRADICTED]
    return (error("tool-contradicts-wrench", what, "tool"), *left)


def _contradictions_alone(checked: Checked) -> Iterable[Message]:
    """An error for each recording that by itself contradicts the shape, if all together
    do not."""
    found, estimator = checked.found, checked.estimator
    contradicted = CONTRADICTED in codes(checked.estimate.warnings)
    if checked.shape is None or contradicted or not isinstance(estimator, Bayes):
        return
    if not isinstance(found, JointIngested):
        return
    for name, part in zip(found.names, found.parts, strict=True):
        alone = estimator.estimate(state_of(estimator, part))
        if CONTRADICTED in codes(alone.warnings):
            what = f"{name} alone contradicts the shape: turned in the grasp?"
            yield Message("recordings-contradict", what, "error", None, [name])


def mass_undetermined(estimate: Estimate) -> Iterable[Message]:
    """A warning of a mass whose interval is about as wide as itself."""
    found = undetermined_mass(estimate.parameters.mass, estimate.intervals)
    return [] if found is None else [found]


def _against_least_squares(checked: Checked) -> Iterable[Message]:
    estimate, fit = checked.estimate, checked.found.fit
    if checked.shape is None or estimate.covariance is None or fit.mass_is_open:
        return []
    variance = float(estimate.covariance[0, 0] + fit.covariance[0, 0])
    mass, free = float(estimate.sensed_vector[0]), fit.mass
    if not abs(mass - free) > LARGEST_CHANGE_BY_SHAPE * variance**0.5:
        return []
    what = (
        f"the shape moves the mass from {free:.3g} kg, by least squares, to "
        f"{mass:.3g} kg: does it fit the object, and is its pose right?"
    )
    return [warning("mass-moved-by-shape", what, "shape")]


def _scale_assumed(checked: Checked) -> Iterable[Message]:
    reading = getattr(checked.estimator, "mass", None)
    if not isinstance(reading, MassReading) or not reading.assumed:
        return []
    what = (
        f"the scale's {reading.mass:g} kg are taken as accurate to {1e3 * reading.std:g} "
        f"g, the last digit: give its accuracy, as in `mass` {EXAMPLE}"
    )
    return [warning("mass-deviation-assumed", what, "mass")]


def _not_converged(checked: Checked) -> Iterable[Message]:
    certificate = checked.estimate.certificate
    if certificate is None or certificate.converged:
        return []
    what = (
        "the method stopped before its best answer was reached "
        f"({certificate.gap:.2g} above the lower bound of what it minimises)"
    )
    return [warning("not-converged", what)]


def _not_physical(checked: Checked) -> Iterable[Message]:
    estimate = checked.estimate
    if estimate.physically_consistent:
        return []
    what = f"no body has these parameters: {estimate.consistency}"
    if checked.shape is not None and (estimate.hull_margin or 0.0) < 0.0:
        what += ": is the shape's pose right, and nothing else held (`tool`)?"
    return [warning("not-physical", what)]


CHECKS: list[Check] = [
    lambda checked: checked.found.warnings,
    lambda checked: mass_warnings(checked.found),
    lambda checked: torque_sign_messages(checked.found, checked.shape is not None),
    lambda c: com_warnings(c.found.fit, c.shape, sum_of_moments(c.found)),
    lambda checked: density_warnings(checked.found.fit, checked.shape),
    lambda checked: () if checked.shape is None else checked.shape.warnings,
    _method_warnings,
    _contradictions_alone,
    lambda c: misfit_warnings(c.estimate, c.residual, c.found),
    _undetermined,
    lambda checked: mass_undetermined(checked.estimate),
    _against_least_squares,
    _scale_assumed,
    _not_converged,
    _not_physical,
]
"""All checks, in the order of their messages."""


def with_diagnostics(
    estimate: Estimate, estimator: Estimator, found: Ingested, shape: Shape | None
) -> Estimate:
    """The estimate with its residual, assumptions and doubts.

    Raises `NotIdentifiableError` when its mass is not positive.
    """
    negative = (
        estimate.intervals is not None and not estimate.intervals["mass"][1] > 0.0
    )
    if negative or not estimate.parameters.mass > 0.0:
        empty = [m for m in found.warnings if m.code == "nothing-held"]
        if empty:
            what, fix = str(empty[0]), ""
        elif shape is None or not estimator.rests_on_shape:
            what = "no positive mass explains the wrench"
            fix = "check `sign` and `gravity`"
        else:
            doubts = f" ({'; '.join(shape.warnings)})" if shape.warnings else ""
            what = f"no mass inside the shape explains the wrench{doubts}"
            fix = "check the shape's pose and unit"
        refusal = NotIdentifiableError(what, where=found.log, fix=fix)
        raise named_instead(refusal, found)
    left_out = estimate.provenance.get("shape_known") == "reach"
    used = None if left_out else shape  # the wrench contradicts it
    rms = found.residual(estimate.sensed_vector, estimate.bias)
    provenance = found.provenance | estimator.provenance | estimate.provenance
    own: Shape | None = getattr(estimator, "shape", None)
    if own is not None and own.known != "reach" and not left_out:
        provenance["points"] = own.n
    estimate = replace(
        estimate,
        samples=round(found.samples),
        duration=found.duration,
        hull_margin=_margin(estimate, used),
        residual=rms,
        provenance=provenance,
    )
    estimate = replace(
        estimate, undetermined=undetermined_by(estimate, estimator, found, used)
    )
    checked = Checked(estimate, rms, estimator, found, shape)
    return replace(estimate, warnings=warnings_of(checked))


def _margin(estimate: Estimate, shape: Shape | None) -> float | None:
    """Depth of the COM in the hull; from the method if the shape is uncertain."""
    if shape is None or estimate.hull_margin is not None:
        return estimate.hull_margin
    return shape.margin(estimate.parameters.center_of_mass)


def undetermined_by(
    estimate: Estimate, estimator: Estimator, found: Ingested, shape: Shape | None
) -> Undetermined:
    """Open numbers of an estimate.

    These are left open by unconstrained least squares (`FreeFit.open_parameters`), do not
    follow from the object's shape (a box around the object is none), and have no narrow
    interval.
    """
    if shape is not None and estimator.rests_on_shape and shape.known == "object":
        return Undetermined()
    size = TYPICAL_SIZE
    if shape is not None and estimator.rests_on_shape:
        size = float(np.linalg.norm(shape.extents))
    names = found.fit.open_parameters(size)
    open_ = Undetermined.of_parameters(names, estimator.fills_in)
    return _without_known(open_, estimate, size)


def _without_known(
    open_: Undetermined, estimate: Estimate, size: float
) -> Undetermined:
    if not open_:
        return open_
    mass, moments = estimate.parameters.mass, estimate.parameters.inertia_at_com
    half = estimate.half_widths
    largest = LARGEST_HALF_WIDTH * float(np.abs(moments.diagonal()).max())
    left = Undetermined(
        open_.mass and not half["mass"] <= LARGEST_HALF_WIDTH * mass,
        open_.center_of_mass & ~(half["center_of_mass"] <= 0.5 * size),
        open_.inertia_at_com & ~(half["inertia_at_com"] <= largest),
        open_.filled_from,
    )
    return left if left else Undetermined()

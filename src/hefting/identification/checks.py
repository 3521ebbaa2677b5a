"""Checks of an estimate: each looks for one thing that gives doubt, and warns of it.

A check is a function from `Checked` to messages, and its line in `CHECKS`; what it says
then stands in `Estimate.warnings`, with its code in the output for machines.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.mass_reading import EXAMPLE, MassReading
from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array
from hefting.estimators import Estimator
from hefting.identification.identifiability import identifiability
from hefting.ingest.free_fit import TYPICAL_SIZE
from hefting.ingest.ingested import Ingested
from hefting.ingest.plausibility import com_warnings, misfit_warnings
from hefting.ingest.rivals.consequence import SUPERSEDED
from hefting.shapes import Shape


@dataclass(frozen=True, eq=False)
class Checked:
    """An estimate, and all that it rests on."""

    estimate: Estimate
    residual: Array
    """(2,) root mean square of force [N] and torque [N m] that it leaves unexplained"""
    estimator: Estimator
    found: Ingested
    shape: Shape | None


LARGEST_RELATIVE_HALF_WIDTH = 0.5
"""Half-width of the mass's interval over the mass, above which the recording does not
determine the mass."""
LARGEST_CHANGE_BY_SHAPE = 2.0
"""Difference between the mass with a shape and by least squares without one, in
standard deviations, that is attributed to chance."""

Check = Callable[[Checked], Iterable[str]]


def warnings_of(checked: Checked) -> tuple[str, ...]:
    """What all checks say, in their order; without what a mistake that was named
    accounts for."""
    said = tuple(message for check in CHECKS for message in check(checked))
    doubt = checked.found.doubt
    if doubt is None or not (doubt.names_mistake and doubt.is_fatal):
        return said
    return tuple(m for m in said if getattr(m, "code", "") not in SUPERSEDED)


def _of_the_recording(checked: Checked) -> Iterable[str]:
    return checked.found.warnings


def _com_outside_shape(checked: Checked) -> Iterable[str]:
    return com_warnings(checked.found.fit, checked.shape)


def _of_the_shape(checked: Checked) -> Iterable[str]:
    return () if checked.shape is None else checked.shape.warnings


def _of_the_method(checked: Checked) -> Iterable[str]:
    return checked.estimate.warnings


def _misfit(checked: Checked) -> Iterable[str]:
    return misfit_warnings(checked.estimate, checked.residual, checked.found)


def _undetermined(checked: Checked) -> Iterable[Message]:
    """What the motion leaves open: the estimate there follows from the shape, or from
    nothing."""
    fit, estimator = checked.found.fit, checked.estimator
    if not estimator.rests_on_shape or checked.shape is None:
        motion = checked.found.excitation
        summary = identifiability(motion, fit, TYPICAL_SIZE).summary
        return [warning("not-identifiable", line) for line in summary]
    size = float(np.linalg.norm(checked.shape.extents))
    kinds = {name[0] for name in fit.open_parameters(size)}
    names = [n for n, kind in (("the COM", "m"), ("the inertia", "J")) if kind in kinds]
    if not names:
        return []
    what = (
        f"the motion leaves {' and '.join(names)} open: "
        f"what is shown follows from {estimator.assumes}"
    )
    return [warning("open-without-shape", what)]


def _mass_undetermined(checked: Checked) -> Iterable[Message]:
    """A mass whose interval is about as wide as itself."""
    intervals, mass = checked.estimate.intervals, checked.estimate.parameters.mass
    if intervals is None:
        return []
    low, high = (float(end) for end in intervals["mass"])
    if 0.5 * (high - low) <= LARGEST_RELATIVE_HALF_WIDTH * mass:
        return []
    what = (
        f"the recording does not determine the mass ({low:.3g} to {high:.3g} kg): "
        "this answer is not to be used"
    )
    return [error("mass-undetermined", what)]


def _against_least_squares(checked: Checked) -> Iterable[Message]:
    """A mass that a shape moves by more than chance."""
    estimate, fit = checked.estimate, checked.found.fit
    if checked.shape is None or estimate.covariance is None or fit.mass_is_open:
        return []
    variance = float(estimate.covariance[0, 0] + fit.covariance[0, 0])
    mass, free = float(estimate.sensed_vector[0]), float(fit.vector[0])
    if not abs(mass - free) > LARGEST_CHANGE_BY_SHAPE * variance**0.5:
        return []
    what = (
        f"the shape moves the mass from {free:.3g} kg, by least squares, to "
        f"{mass:.3g} kg: does it fit the object, and is its pose right?"
    )
    return [warning("mass-moved-by-shape", what, "shape")]


def _scale_assumed(checked: Checked) -> Iterable[Message]:
    """A scale of which nobody said how sure it is."""
    reading = getattr(checked.estimator, "mass", None)
    if not isinstance(reading, MassReading) or not reading.assumed:
        return []
    what = (
        f"the scale's {reading.mass:g} kg are taken as right to {1e3 * reading.std:g} "
        f"g, the last digit: say how sure it is, as in `mass` {EXAMPLE}"
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
    return [warning("not-physical", what)]


CHECKS: list[Check] = [
    _of_the_recording,
    _com_outside_shape,
    _of_the_shape,
    _of_the_method,
    _misfit,
    _undetermined,
    _mass_undetermined,
    _against_least_squares,
    _scale_assumed,
    _not_converged,
    _not_physical,
]
"""Every check, in the order in which their messages are shown."""

"""Checks of an estimate: each looks for one thing that gives doubt, and warns of it.

A check is a function from `Checked` to messages, and its line in `CHECKS`; what it says
then stands in `Estimate.warnings`, with its code in the output for machines.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.messages import Message, warning
from hefting.core.spatial import Array
from hefting.estimators import Estimator
from hefting.identification.identifiability import identifiability
from hefting.ingest.free_fit import TYPICAL_SIZE
from hefting.ingest.ingested import Ingested
from hefting.ingest.plausibility import com_warnings, misfit_warnings
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


Check = Callable[[Checked], Iterable[str]]


def warnings_of(checked: Checked) -> tuple[str, ...]:
    """What all checks say, in their order."""
    return tuple(message for check in CHECKS for message in check(checked))


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
    if estimator.needs == "nothing" or checked.shape is None:
        z = checked.found.measurements
        summary = identifiability(z, fit, TYPICAL_SIZE).summary
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


def _not_converged(checked: Checked) -> Iterable[Message]:
    certificate = checked.estimate.certificate
    if certificate is None or certificate.converged:
        return []
    what = f"the solver stopped {certificate.gap:.2g} above its lower bound"
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
    _not_converged,
    _not_physical,
]
"""Every check, in the order in which their messages are shown."""

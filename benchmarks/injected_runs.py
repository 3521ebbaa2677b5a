"""One identification of a body that was added to a real recording, by each method."""

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.bodies import ends, sixteen
from benchmarks.injected import Case
from hefting.core.errors import HeftingError
from hefting.core.estimate import Estimate
from hefting.core.sensor_accuracy import EXACT
from hefting.core.spatial import Array
from hefting.estimators import METHODS as ESTIMATORS
from hefting.estimators import default_method
from hefting.identification.checks import with_diagnostics
from hefting.identification.estimator import estimator_for
from hefting.identification.identify import run
from hefting.ingest.ingest import Ingested, ingest
from hefting.ingest.plausibility import require_object
from hefting.shapes import Shape

METHODS = {"with the shape": True, "without a shape": False}
"""What is identified, and whether the shape is given: the default method of each."""


@dataclass(frozen=True, eq=False)
class Run:
    """What came of one identification."""

    method: str
    """key of `METHODS`"""
    set: str
    """data set"""
    window: str
    """length of the part, or "whole" """
    held: Array | None
    """(10,) booleans: mass, COM, inertia about the sensor; None where the method
    refused"""
    beyond_twice: float = 0.0
    """share of the ten that are beyond twice the interval"""
    error: float = 0.0
    """of the mass [kg]"""
    half_width: float = 0.0
    """of the mass's interval [kg]"""
    doubted: bool = False
    """whether the answer says that its mass is not to be used"""


def identified(case: Case, exact: Collection[str] = ()) -> list[Run]:
    """Identify the body of a case by every method, as `hefting.identify` does; `exact`
    is what is said to have no errors but noise: ``"sensor"``, ``"tool"``."""
    host, runs = case.host, list[Run]()
    tool = host.tool
    if "tool" in exact:
        tool = replace(tool, covariance=np.zeros((10, 10)))
    settings = {"sensor_accuracy": EXACT} if "sensor" in exact else {}
    try:
        found = ingest(case.recording, gravity=host.gravity, tool=tool)
    except HeftingError:
        return [Run(method, host.set, case.name, None) for method in METHODS]
    for method, with_shape in METHODS.items():
        try:
            estimate = _estimate(
                found, case.body.shape if with_shape else None, settings
            )
        except HeftingError:
            runs.append(Run(method, host.set, case.name, None))
            continue
        runs.append(_judged(method, case, estimate))
    return runs


def _estimate(
    found: Ingested, shape: Shape | None, settings: dict[str, Any]
) -> Estimate:
    require_object(found, shape)
    kind = ESTIMATORS[default_method(shape is not None)]
    estimator = estimator_for(kind, found, shape, settings)
    estimate, used = run(estimator, found)
    return with_diagnostics(estimate, estimator, used, shape)


def _judged(method: str, case: Case, estimate: Estimate) -> Run:
    truth = sixteen(case.body.parameters)[:10]
    assert estimate.intervals is not None
    low, high = ends(estimate.intervals)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return Run(
        method,
        case.host.set,
        case.name,
        (low <= truth) & (truth <= high),
        float(np.mean(np.abs(truth - middle) > 2.0 * half)),
        abs(estimate.parameters.mass - truth[0]),
        float(half[0]),
        any(getattr(w, "code", "") == "mass-undetermined" for w in estimate.warnings),
    )

"""Identification: from ingested recordings to an estimate; and calibration of a tool."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.estimate_json import coded
from hefting.core.gravity import ON_EARTH, GravityLike
from hefting.core.measurements import Measurements
from hefting.core.messages import Verdict, warning
from hefting.core.progress import report
from hefting.core.recording import Recording
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array
from hefting.core.summary import Shown
from hefting.core.undetermined import Covariance
from hefting.estimators import LMI, OLS, Estimator, default_method
from hefting.identification.checks import with_diagnostics
from hefting.identification.estimator import Method, estimator_of, known_of
from hefting.identification.run import run
from hefting.ingest.conditioned import WrenchSign
from hefting.ingest.ingest import Ingested, ingest
from hefting.ingest.plausibility import require_object
from hefting.shapes import Shape
from hefting.shapes.checks import REACH

PLAUSIBLE_DISTANCE = 18.3
"""Squared distance from the nearest body, in standard deviations, up to which errors
explain parameters that no body has: 95 % of a chi-square of ten degrees of freedom."""


class Answer(Shown):
    """Base of results with an estimate in `estimate`."""

    estimate: Estimate

    def __repr__(self) -> str:
        return self.estimate.summary(type(self).__name__)

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.estimate.mass

    @property
    def center_of_mass(self) -> Array:
        """Centre of mass (3,) [m] in the sensor frame."""
        return self.estimate.center_of_mass

    @property
    def inertia(self) -> Array:
        """Inertia tensor (3, 3) [kg m²] about the centre of mass, in sensor axes."""
        return self.estimate.inertia

    def interval(self, name: str) -> Array:
        """Lower and upper ends of a 95 % interval; see `hefting.Estimate.interval`."""
        return self.estimate.interval(name)

    def save(self, path: str | Path) -> None:
        """Write the estimate as JSON; see `hefting.Estimate.save`."""
        self.estimate.save(path)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Doubts about the estimate, and assumptions."""
        return self.estimate.warnings

    @property
    def verdict(self) -> Verdict:
        """Whether to trust it, and why not: see `hefting.core.messages`."""
        return self.estimate.verdict


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
    """In the sign convention of `hefting.core.spatial`, without a given bias, and with
    the weights that were used."""
    sign: WrenchSign | None
    """Sign convention of the wrench by the data; None if it was given."""
    source: str
    """Source of the motion: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    ingested: Ingested
    """The used part of the recording, with findings and samples left out."""
    estimator: Estimator
    """The estimator, with all hyperparameters."""


def identify_understood(
    found: Ingested,
    shape: Shape | None,
    method: Method | None,
    hyperparameters: dict[str, Any],
    stop: bool = True,
) -> Identification:
    """Identify the object in ingested recordings; for other arguments and errors see
    `hefting.identify`. With `stop` only as much is used as the accuracy asked for
    requires; without, all is used and the accuracy reported."""
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
    estimate, found = run(estimator, found, stop)
    estimate = with_diagnostics(estimate, estimator, found, shape)
    estimate = replace(estimate, warnings=(*warnings, *estimate.warnings))
    return _identification(estimate, estimator, found)


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

    By ten-parameter least squares, whose lack of a prior avoids a bias of the object's
    estimate. Of a recording in which an object is picked up or placed, the longest part
    with an empty gripper is used. The wrench's bias is in ``Estimate.bias``, the noise
    levels in ``provenance["noise"]``. Errors as for `identify`; `NotIdentifiableError`
    also if the motion leaves the COM open.

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
    how = partial(
        ingest, recording, gravity=gravity, bias="estimate", accuracy=sensor_accuracy
    )
    found = how()
    empty = None if found.changes is None else found.changes.gripper
    if empty is not None:
        found = how(start=empty.start, duration=empty.duration)
        what = f"only {empty.start:.2f} to {empty.end:.2f} s is used, where the gripper is empty"
        part = warning("change-gripper-used", what, "start")
        found = replace(found, warnings=(part, *found.warnings))
    require_object(found, None)
    settings = OLS.settings(known_of(found, None))
    estimator = OLS(**settings, sensor_accuracy=sensor_accuracy)
    state = estimator.update(estimator.start(), found.measurements)
    estimate = with_diagnostics(estimator.estimate(state), estimator, found, None)
    # with all errors, as they are errors of every object
    covariance = np.asarray(estimate.covariance)
    if not np.isfinite(covariance.diagonal()[:4]).all():
        what = "the motion leaves the tool's centre of mass open"
        fix = "turn the sensor about two axes or more"
        raise NotIdentifiableError(what, found.log, fix)
    nearest = LMI(**LMI.settings(known_of(found, None))).estimate(state).parameters
    if _is_within_noise(nearest.vector - estimate.parameters.vector, covariance):
        doubts = (m for m in map(coded, estimate.warnings) if m.code != "not-physical")
        estimate = replace(estimate, warnings=tuple(doubts))
    return _identification(estimate, estimator, found)


def _is_within_noise(difference: Array, covariance: Array) -> bool:
    """Whether a difference (10,) of parameters is no larger than 95 % of those by errors
    of a covariance (10, 10); an infinite variance allows any."""
    information = Covariance.of(covariance).information
    return bool(difference @ information @ difference < PLAUSIBLE_DISTANCE)

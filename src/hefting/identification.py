"""Recording -> Estimate: the whole way, with what has to be found out on it (sign, bias, weights) and told."""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.calibration import (
    FreeFit,
    WrenchSign,
    bias_is_significant,
    fit_freely,
    residuals,
    wrench_sign,
)
from hefting.errors import InputError, NotIdentifiableError, nearest
from hefting.estimate import Estimate
from hefting.estimators import METHODS, PMD, Estimator
from hefting.logs import read_log
from hefting.measurements import Measurements
from hefting.motion import Measured, measure, sample_weights
from hefting.motion.measure import DESCRIPTIONS, Source
from hefting.plausibility import check_shape, check_wrench, com_warnings, gravity_warnings, misfit_warnings
from hefting.recording import Recording
from hefting.shapes import PointMasses
from hefting.spatial import STANDARD_GRAVITY, frozen

DEFAULT_BOX = (-0.25, 0.25, -0.25, 0.25, -0.25, 0.25)
"""Where mass may be when no shape is given [m, sensor frame]."""
DEFAULT_BOX_POINTS = 512
SMOOTHED_C1 = 1.0
"""PMD's c1 for poses smoothed here. The paper's 300 suits accelerations as noisy as a causal filter's; with these it
biases the answer: on simulated recordings of 1.5 to 10 s, 0.7 and 1.5 rad/s, two bodies, mean errors at 300 over those
at 1 were 0.95 to 19 for the COM, 0.99 to 8 for the inertia about the sensor, 0.8 to 4 for that about the COM."""


@dataclass(frozen=True, eq=False)
class Identification:
    """An estimate and the measurements it was made from."""

    estimate: Estimate
    measurements: Measurements
    """With the sign convention of `hefting.spatial`, a given bias removed, and the weights that were used."""
    sign: WrenchSign | None
    """What the data say of the wrench's sign; None when it was given."""
    source: str
    """How the motion was found: a key of `hefting.motion.measure.DESCRIPTIONS`."""


def identify(
    recording: Recording | str | Path,
    shape: PointMasses | None = None,
    *,
    method: str = "PMD",
    gravity: ArrayLike = STANDARD_GRAVITY,
    wrench: Literal["auto", "on-object", "on-sensor"] = "auto",
    bias: Literal["auto", "none", "estimate"] | ArrayLike = "auto",
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
    **hyperparameters: Any,
) -> Identification:
    """Identify the object a recording shows.

    Parameters
    ----------
    recording : a recording or the path of a log.
    shape : where the object may have mass, in the sensor frame; a stated default box if None.
    method : name of an estimator (`hefting.estimators.METHODS`).
    gravity : (3,) in world axes [m/s²].
    wrench : which way the sensor counts; ``"auto"`` finds out from gravity.
    bias : ``"estimate"`` finds a constant bias with the object, ``"none"`` assumes there is none, ``"auto"`` keeps
        one that exceeds three standard deviations; or six numbers [N, N m], as recorded, to subtract.
    motion : where velocities and accelerations come from, see `hefting.motion.measure.measure`.
    start, duration : part of the recording to use [s].
    hyperparameters : fields of the estimator, such as ``c1``; PMD's is `SMOOTHED_C1` where poses are smoothed here,
        else the paper's.

    Raises `InputError` for input that cannot be right (names what, where and what to do) and
    `NotIdentifiableError` when the recording determines nothing.
    """
    if not isinstance(recording, Recording):
        recording = read_log(recording)
    if method not in METHODS:
        raise InputError(f"unknown method '{method}'{nearest(method, METHODS)}", fix=f"use {', '.join(METHODS)}")
    check_shape(shape)
    if start or duration is not None:
        recording = recording.slice(start, duration)
    measured = measure(recording, gravity, motion)
    z, source = measured.measurements, measured.source
    warnings = [*recording.warnings, *measured.warnings]
    given = None
    if not isinstance(bias, str):
        given = frozen(bias)
        if given.shape != (6,) or not np.isfinite(given).all():
            raise InputError(f"a bias is six finite numbers [N, N m], not {np.asarray(bias).tolist()}")
        z = replace(z, force=z.force - given[:3], torque=z.torque - given[3:])
    elif bias not in ("auto", "none", "estimate"):
        raise InputError(f"unknown bias model '{bias}'", fix="use auto, none, estimate or six numbers")
    searched = given is None and bias == "auto"
    may_be_biased = given is None and bias != "none"
    if not np.any(z.wrench):
        raise InputError("the wrench is zero throughout", where=recording.source, fix="check its columns")

    z, sign = _with_sign(z, wrench, may_be_biased, warnings)
    fit = fit_freely(z, may_be_biased)
    if searched and not bias_is_significant(fit):
        if fit.mass_is_open:
            warnings.append("this motion cannot tell a bias from the object's weight: assumed no bias")
        fit, may_be_biased = fit_freely(z, False), False
    check_wrench(z, fit, shape, recording.source)
    if fit.mass_is_open:
        raise NotIdentifiableError(
            "the motion is too poor to determine even the mass" + (" beside a bias" if may_be_biased else ""),
            where=recording.source,
            fix="turn the sensor to other orientations" + (", or give --bias none" if may_be_biased else ""),
        )
    warnings += [*com_warnings(fit, shape), *gravity_warnings(z, fit)]
    if measured.motion is not None and source != "orientation" and len(z) > 1:
        z = replace(z, weights=_weights(fit, measured))

    settings: dict[str, Any] = {"bias": "estimate" if may_be_biased else "none"}
    if method == "PMD":
        if shape is None:
            shape = PointMasses.from_box(*DEFAULT_BOX, points=DEFAULT_BOX_POINTS)
            warnings.append(
                "no shape given: mass may be anywhere in a box of ±0.25 m about the sensor; give --shape for a better "
                "answer"
            )
        settings["shape"] = shape
        if source == "smooth":
            settings["c1"] = SMOOTHED_C1
    if method == "OLS":
        settings["noise"] = fit.noise
    if shape is not None:
        warnings.extend(shape.warnings)
    known = [field.name for field in fields(METHODS[method])]
    for name in hyperparameters:
        if name not in known:
            raise InputError(f"{method} has no '{name}'{nearest(name, known)}", fix=f"it has {', '.join(known)}")
    estimator = METHODS[method](**{**settings, **hyperparameters})
    estimate = estimator.fit(z)
    if recording.static:
        estimate = replace(estimate, duration=None)
    if estimate.covariance is not None:
        estimate = replace(estimate, covariance=estimate.covariance * fit.autocorrelation)
    if not estimate.parameters.mass > 0.0:
        raise NotIdentifiableError(
            "no positive mass explains the wrench",
            where=recording.source,
            fix="check --wrench (sign) and --gravity",
        )
    return Identification(
        _finished(
            estimate,
            estimator,
            z,
            fit,
            warnings,
            {
                "log": recording.source,
                "gravity": np.asarray(gravity, dtype=float),
                "wrench": "on-object" if (sign.on_object if sign else wrench == "on-object") else "on-sensor",
                "wrench_found": sign is not None,
                "bias": "given" if given is not None else settings["bias"],
                "bias_searched": searched,
                "bias_subtracted": given,
                "motion": DESCRIPTIONS[source],
                "points": shape.n if shape is not None and method != "OLS" else None,
            },
        ),
        z,
        sign,
        source,
    )


def _with_sign(
    z: Measurements, wrench: str, may_be_biased: bool, warnings: list[str]
) -> tuple[Measurements, WrenchSign | None]:
    """The measurements with the wrench exerted on the object, and what decided."""
    if wrench not in ("auto", "on-object", "on-sensor"):
        raise InputError(f"unknown wrench convention '{wrench}'", fix="use auto, on-object or on-sensor")
    sign = wrench_sign(z, may_be_biased) if wrench == "auto" else None
    if sign is not None and not sign.certain:
        warnings.append(
            f"the wrench's sign is uncertain (t = {abs(sign.t):.1f}); assumed "
            f"{'on-object' if sign.on_object else 'on-sensor'}: give --wrench on-object or on-sensor"
        )
    on_object = sign.on_object if sign is not None else wrench == "on-object"
    return z if on_object else replace(z, force=-z.force, torque=-z.torque), sign


def _weights(fit: FreeFit, measured: Measured) -> np.ndarray:
    """Weights (K,) of the samples from the spread of the smoothed motion, one on average: PMD's lambda keeps its
    meaning. What the data leave open counts as zero."""
    assert measured.motion is not None
    known = np.where(np.isfinite(fit.covariance.diagonal()[:10]), fit.vector, 0.0)
    weights = sample_weights(known, measured.motion, fit.noise.force, fit.noise.torque)
    return weights / weights.mean()


def _finished(
    estimate: Estimate,
    estimator: Estimator,
    z: Measurements,
    fit: FreeFit,
    warnings: list[str],
    provenance: dict[str, Any],
) -> Estimate:
    """The estimate with residual, warnings and provenance."""
    r = residuals(z, estimate.parameters.vector, estimate.bias)
    rms = np.sqrt(np.mean(r.reshape(-1, 2, 3) ** 2, axis=(0, 2)))
    warnings += misfit_warnings(estimate, rms, z, fit)
    if isinstance(estimator, PMD):
        free = fit.open_parameters(float(np.linalg.norm(estimator.shape.extents)))
        provenance |= {"c1": estimator.c1, "regularization": estimator.regularization}
        if free:
            names = " and ".join(n for n, c in (("the COM", "m"), ("the inertia", "J")) if any(f[0] == c for f in free))
            warnings.append(f"the motion leaves {names} open: what is shown follows from the shape and equal masses")
        if estimate.certificate is not None and not estimate.certificate.converged:
            warnings.append(f"the solver stopped {estimate.certificate.gap:.2g} above its lower bound")
    consistency = estimate.parameters.consistency()
    if not consistency.is_consistent:
        warnings.append(f"no body has these parameters: {consistency}")
    return replace(estimate, residual=rms, warnings=(*warnings, *estimate.warnings), provenance=provenance)

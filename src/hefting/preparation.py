"""Preparation: what must be known of a recording before any method can use it: motion, sign, bias, noise, weights."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.calibration import FreeFit, WrenchSign, bias_is_significant, fit_freely, wrench_sign
from hefting.errors import InputError, NotIdentifiableError
from hefting.estimators.base import BiasModel
from hefting.logs import read_log
from hefting.measurements import Measurements
from hefting.motion import Measured, measure, sample_weights
from hefting.motion.measure import DESCRIPTIONS, Source
from hefting.motion.state import Motion
from hefting.plausibility import check_shape, check_wrench, com_warnings, gravity_warnings
from hefting.recording import Recording
from hefting.shapes import PointMasses
from hefting.spatial import STANDARD_GRAVITY, Array, frozen


@dataclass(frozen=True, eq=False)
class Prepared:
    """A recording as estimators take it, and what was found out and assumed."""

    log: str
    """Where it came from."""
    static: bool
    """Whether it is poses without time."""
    measurements: Measurements
    """With the sign convention of `hefting.spatial`, a given bias removed, and weights."""
    motion: Motion | None
    """Smoothed motion with its standard deviations; None where the log gave it."""
    source: str
    """How the motion was found: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    sign: WrenchSign | None
    """What the data say of the wrench's sign; None when it was given."""
    bias: BiasModel
    """Whether a constant bias is to be found with the object."""
    fit: FreeFit
    """Unconstrained least squares: what the data say before any prior, and their noise."""
    warnings: tuple[str, ...]
    provenance: dict[str, Any]
    """What was read and assumed, as in an estimate."""


def prepare(
    recording: Recording | str | Path,
    shape: PointMasses | None = None,
    gravity: ArrayLike = STANDARD_GRAVITY,
    wrench: str = "auto",
    bias: str | ArrayLike = "auto",
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
) -> Prepared:
    """Prepare a recording; parameters and errors as for `hefting.identification.identify`.

    The shape serves to tell a wrong unit or pose.
    """
    if not isinstance(recording, Recording):
        recording = read_log(recording)
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
    if fit.mass_t < 0.0:
        fix = "check the wrench's sign (--wrench) and --gravity"
        raise NotIdentifiableError("no positive mass explains the wrench", where=recording.source, fix=fix)
    warnings += [*com_warnings(fit, shape), *gravity_warnings(z, fit)]
    moved = measured.motion is not None and source != "orientation" and len(z) > 1
    if moved:
        z = replace(z, weights=_weights(fit, measured))
    model: BiasModel = "estimate" if may_be_biased else "none"
    on_object = sign.on_object if sign else wrench == "on-object"
    return Prepared(
        log=recording.source,
        static=recording.static,
        measurements=z,
        motion=measured.motion if moved else None,
        source=source,
        sign=sign,
        bias=model,
        fit=fit,
        warnings=tuple(warnings),
        provenance={
            "log": recording.source,
            "gravity": np.asarray(gravity, dtype=float),
            "wrench": "on-object" if on_object else "on-sensor",
            "wrench_found": sign is not None,
            "bias": "given" if given is not None else model,
            "bias_searched": searched,
            "bias_subtracted": given,
            "noise": {"force": fit.noise.force, "torque": fit.noise.torque},
            "motion": DESCRIPTIONS[source],
        },
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


def _weights(fit: FreeFit, measured: Measured) -> Array:
    """Weights (K,) of the samples from the spread of the smoothed motion, one on average: PMD's lambda keeps its
    meaning. What the data leave open counts as zero."""
    assert measured.motion is not None
    known = np.where(np.isfinite(fit.covariance.diagonal()[:10]), fit.vector, 0.0)
    weights = sample_weights(known, measured.motion, fit.noise.force, fit.noise.torque)
    return weights / weights.mean()

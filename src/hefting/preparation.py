"""Preparation: what must be known of a recording before any method can use it: motion, sign, bias, noise, weights."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.calibration import FreeFit, WrenchSign, bias_is_significant, fit_freely, wrench_sign
from hefting.conditioning import NO_BIAS, Conditioned, condition
from hefting.errors import InputError, NotIdentifiableError
from hefting.estimate import Estimate
from hefting.estimators.base import BiasModel
from hefting.estimators.bayes.white_noise import white_motion_noise
from hefting.logs import read_log
from hefting.measurements import Measurements, MotionNoise
from hefting.motion import Measured, measure, sample_weights
from hefting.motion.measure import DESCRIPTIONS, Source
from hefting.plausibility import check_shape, check_wrench, com_warnings, gravity_warnings
from hefting.recording import Recording
from hefting.shapes import PointMasses
from hefting.spatial import STANDARD_GRAVITY, Array, frozen
from hefting.tool import tool_warnings, with_tool_spread, without_tool

VAGUE_TILT = np.radians(10.0)
"""Standard deviation of gravity's direction beyond which it is not found [rad]."""
LEAST_TILT = np.radians(3.0)
"""Of a base that may be tilted [rad]."""
POOR, BETTER = 0.1, 0.6
"""Residual over the force's changes, or share left out, that makes one wonder about gravity; and the ratio of
residuals that is worth telling. Tilted by 15° they are 0.2 to 0.3 and 0.1 to 0.3; Panda's are 0.08 and 0.8 to 1."""
WIDE = 1.0
"""What the tool's recording left open of its inertia, in m²: as much as a metre's distance of its whole mass."""
THIN = 5_000
"""Samples that suffice to find gravity's direction."""
ENOUGH = 50_000
"""Samples that suffice to tell the wrench's sign, and what is plausible."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """A recording as estimators take it, and what was found out and assumed."""

    log: str
    """Where it came from."""
    static: bool
    """Whether it is poses without time."""
    measurements: Measurements
    """With the sign convention of `hefting.spatial`, a given bias removed, and weights."""
    source: str
    """How the motion was found: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    sign: WrenchSign | None
    """What the data say of the wrench's sign; None when it was given."""
    bias: BiasModel
    """Whether a constant bias is to be found with the object."""
    conditioned: Conditioned
    """What was found of clocks, drift, gravity and bad samples."""
    tool: Estimate | None
    """What was subtracted."""
    fit: FreeFit
    """Unconstrained least squares: what the data say before any prior, and their noise."""
    systematic: Array | None
    """(10, 10) covariance of what the tool and gravity's direction put into it, the same for all samples; None where
    nothing."""
    warnings: tuple[str, ...]
    provenance: dict[str, Any]
    """What was read and assumed, as in an estimate."""


def prepare(
    recording: Recording | str | Path,
    shape: PointMasses | None = None,
    gravity: ArrayLike | Literal["estimate"] = STANDARD_GRAVITY,
    wrench: str = "auto",
    bias: str | ArrayLike = "auto",
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
    tool: Estimate | None = None,
) -> Prepared:
    """Prepare a recording; parameters and errors as for `hefting.identification.identify`.

    The shape serves to tell a wrong unit or pose.
    """
    if not isinstance(recording, Recording):
        recording = read_log(recording)
    check_shape(shape)
    if start or duration is not None:
        recording = recording.slice(start, duration)
    recording, given = _less_bias(recording, bias)
    free_bias = given is None and bias != "none"
    logged, conditioned = recording, _conditioned(recording, gravity, motion)
    recording = conditioned.corrected(recording, drift=free_bias)
    measured = measure(recording, conditioned.gravity, motion, conditioned.curves)
    z = measured.measurements
    doubts = (line for line in conditioned.warnings if line != NO_BIAS)  # of the bias below
    warnings = [*recording.warnings, *measured.warnings, *doubts, *_tilt_doubts(logged, conditioned, motion)]
    if not free_bias and conditioned.bias.kind != "constant":
        warnings.append("a bias given, or none, leaves its drift in: --bias estimate removes it")
    if not np.any(z.wrench):
        raise InputError("the wrench is zero throughout", where=recording.source, fix="check its columns")

    z, sign = _with_sign(z, wrench, free_bias, warnings)
    whole = fit_freely(z, free_bias)
    drifts = free_bias and conditioned.bias.kind != "constant"
    if free_bias and bias == "auto" and not drifts and not bias_is_significant(whole):
        if whole.mass_is_open:
            warnings.append("this motion cannot tell a bias from the object's weight: assumed no bias")
        whole, free_bias = fit_freely(z, False), False
    warnings += gravity_warnings(z.thinned(ENOUGH), fit_freely(z.thinned(ENOUGH), free_bias))
    moved = measured.motion is not None and measured.source != "orientation" and len(z) > 1
    weights = _weights(whole, measured) if moved else None
    tilts = _tilt_effect(recording, conditioned, motion, z, whole, free_bias)
    fit = whole
    if tool is not None:
        z = without_tool(z, tool)
        fit = with_tool_spread(fit_freely(z, free_bias), tool)
        warnings += tool_warnings(tool)
    check_wrench(z.thinned(ENOUGH), fit, shape, recording.source)
    _check_mass(fit, "free" if free_bias else "given" if given is not None else "none", tool, recording.source)
    warnings += com_warnings(fit, shape)
    if weights is not None:
        z = replace(z, weights=weights, motion_noise=_motion_noise(measured, weights))
    elif measured.source == "columns":
        z = replace(z, motion_noise=white_motion_noise(z))
    model: BiasModel = "estimate" if free_bias else "none"
    on_object = sign.on_object if sign else wrench == "on-object"
    return Prepared(
        log=recording.source,
        static=recording.static,
        measurements=z,
        source=measured.source,
        sign=sign,
        bias=model,
        fit=fit,
        conditioned=conditioned,
        systematic=_systematic(tilts, tool),
        tool=tool,
        warnings=tuple(warnings),
        provenance={
            "log": recording.source,
            "gravity": conditioned.gravity,
            "gravity_found": conditioned.tilt_std is not None,
            "wrench": "on-object" if on_object else "on-sensor",
            "wrench_found": sign is not None,
            "bias": "given" if given is not None else model,
            "bias_searched": isinstance(bias, str) and bias == "auto",
            "bias_subtracted": given,
            "noise": {"force": fit.noise.force, "torque": fit.noise.torque},
            "motion": DESCRIPTIONS[measured.source],
            "clock_offset": conditioned.offset,
            "outliers": conditioned.reasons,
            "tool": None if tool is None else tool.parameters.vector.tolist(),
            "notes": [*recording.notes, *measured.notes, *conditioned.findings],
        },
    )


def _less_bias(recording: Recording, bias: str | ArrayLike) -> tuple[Recording, Array | None]:
    """The recording less a bias given as six numbers, and that bias; `InputError` for what is no bias."""
    if isinstance(bias, str):
        if bias not in ("auto", "none", "estimate"):
            raise InputError(f"unknown bias model '{bias}'", fix="use auto, none, estimate or six numbers")
        return recording, None
    given = frozen(bias)
    if given.shape != (6,) or not np.isfinite(given).all():
        raise InputError(f"a bias is six finite numbers [N, N m], not {np.asarray(bias).tolist()}")
    wrench = recording["wrench"]
    less = replace(wrench, values=wrench.values - given)
    return replace(recording, streams={**recording.streams, "wrench": less}), given


def _conditioned(recording: Recording, gravity: ArrayLike | str, motion: Source) -> Conditioned:
    """What is wrong with clocks, bias and samples, and gravity as given or as found."""
    tilt = isinstance(gravity, str)
    if tilt and gravity != "estimate":
        raise InputError(f"unknown gravity '{gravity}'", fix="use X,Y,Z [m/s²] or estimate")
    found = condition(recording, STANDARD_GRAVITY if tilt else gravity, motion, tilt=tilt)  # type: ignore[arg-type]
    if tilt and found.tilt_std is not None and found.tilt_std > VAGUE_TILT:
        known = f" (known to {np.degrees(found.tilt_std):.0f}° at best)" if np.isfinite(found.tilt_std) else ""
        what = f"the motion does not tell the direction of gravity{known}"
        fix = "turn the sensor about two axes (static poses: twelve or more), or give --gravity X,Y,Z"
        raise NotIdentifiableError(what, recording.source, fix)
    return found


def _tilt_doubts(recording: Recording, found: Conditioned, motion: Source) -> list[str]:
    """A sentence when gravity along another direction would explain a poorly explained wrench much better."""
    wrench = recording["wrench"]
    changes = float(np.sqrt(np.mean(np.var(wrench.values[:, :3], axis=0))))
    poor = found.noise.force > POOR * changes or float(found.rejected.mean()) > POOR
    if found.tilt_std is not None or recording.static or not poor:
        return []
    thin = replace(recording, streams={**recording.streams, "wrench": wrench[:: -(-len(wrench) // THIN)]})
    tilted = condition(thin, found.gravity, motion, tilt=True)
    if tilted.tilt_std is None or not tilted.noise.force < BETTER * found.noise.force:
        return []
    size = np.linalg.norm(found.gravity) * np.linalg.norm(tilted.gravity)
    angle = float(np.arccos(np.clip(found.gravity @ tilted.gravity / size, -1.0, 1.0)))
    if not angle > max(LEAST_TILT, 5.0 * tilted.tilt_std):
        return []
    x, y, z = tilted.gravity
    where = f"({x:.2f}, {y:.2f}, {z:.2f}) m/s², {np.degrees(angle):.0f}° off"
    return [
        f"with gravity along {where}, the force residual would be "
        f"{tilted.noise.force:.2g} N in place of {found.noise.force:.2g} N: is the base tilted? see --gravity"
    ]


def _tilt_effect(
    recording: Recording, found: Conditioned, motion: Source, z: Measurements, fit: FreeFit, free_bias: bool
) -> Array | None:
    """(10, 2) change of unconstrained least squares when gravity turns by its standard deviation about either axis
    across it; None where its direction was given."""
    from scipy.spatial.transform import Rotation

    if found.tilt_std is None:
        return None
    changes = []
    for axis in np.linalg.svd(found.gravity[None])[2][1:]:  # across gravity
        turned = Rotation.from_rotvec(found.tilt_std * axis).apply(np.array(found.gravity))
        other = measure(recording, turned, motion, found.curves).measurements
        tilted = replace(z, gravity=other.gravity, linear_acceleration=other.linear_acceleration)
        changes.append(fit_freely(tilted, free_bias).vector[:10] - fit.vector[:10])
    return np.array(changes).T


def _systematic(tilts: Array | None, tool: Estimate | None) -> Array | None:
    """(10, 10) covariance of the errors that all samples share."""
    C = np.zeros((10, 10)) if tilts is None else tilts @ tilts.T
    if tool is not None and tool.covariance is not None:
        open_ = np.isinf(tool.covariance.diagonal())
        own = np.where(np.isinf(tool.covariance), 0.0, tool.covariance)
        own[open_, open_] = np.square(WIDE * tool.parameters.mass)
        C = C + own
    return C if C.any() else None


def _check_mass(fit: FreeFit, bias: Literal["free", "given", "none"], tool: Estimate | None, source: str) -> None:
    """`NotIdentifiableError` unless unconstrained least squares finds a positive mass."""
    also = " and --bias" if bias == "given" else ""
    if tool is not None and (fit.mass_is_open or fit.mass_t < 0.0):
        found = f"{fit.vector[0]:.3g} kg" if np.isfinite(fit.covariance[0, 0]) else "nothing certain"
        raise NotIdentifiableError(
            f"there is {found} beside the tool", source, f"check --tool{also}: was it in the hand?"
        )
    if fit.mass_is_open:
        raise NotIdentifiableError(
            "the motion is too poor to determine even the mass" + (" beside a bias" if bias == "free" else ""),
            where=source,
            fix="turn the sensor to other orientations"
            + {"free": ", or give --bias none", "given": "; or is --bias wrong?", "none": ""}[bias],
        )
    if fit.mass_t < 0.0:
        fix = f"check the wrench's sign (--wrench){also} and --gravity"
        raise NotIdentifiableError("no positive mass explains the wrench", where=source, fix=fix)


def _with_sign(
    z: Measurements, wrench: str, may_be_biased: bool, warnings: list[str]
) -> tuple[Measurements, WrenchSign | None]:
    """The measurements with the wrench exerted on the object, and what decided."""
    if wrench not in ("auto", "on-object", "on-sensor"):
        raise InputError(f"unknown wrench convention '{wrench}'", fix="use auto, on-object or on-sensor")
    sign = wrench_sign(z.thinned(ENOUGH), may_be_biased) if wrench == "auto" else None
    if sign is not None and not sign.certain:
        warnings.append(
            f"the wrench's sign is uncertain (t = {abs(sign.t):.1f}); assumed "
            f"{'on-object' if sign.on_object else 'on-sensor'}: give --wrench on-object or on-sensor"
        )
    on_object = sign.on_object if sign is not None else wrench == "on-object"
    return z if on_object else replace(z, force=-z.force, torque=-z.torque), sign


def _motion_noise(measured: Measured, weights: Array) -> MotionNoise | None:
    """Errors of the accelerations over weighted samples; None where the smoother does not say."""
    motion = measured.motion
    assert motion is not None
    if motion.linear_acceleration_std is None:
        return None
    squares = (motion.linear_acceleration_std**2, motion.angular_acceleration_std**2)
    linear, angular = (float(np.sqrt(weights @ square / weights.sum())) for square in squares)
    return MotionNoise(linear, angular, np.pi / motion.bandwidth)


def _weights(fit: FreeFit, measured: Measured) -> Array:
    """Weights (K,) of the samples from the spread of the smoothed motion, one on average: PMD's lambda keeps its
    meaning. What the data leave open counts as zero."""
    assert measured.motion is not None
    known = np.where(np.isfinite(fit.covariance.diagonal()[:10]), fit.vector, 0.0)
    weights = sample_weights(known, measured.motion, fit.noise.force, fit.noise.torque)
    return weights / weights.mean()

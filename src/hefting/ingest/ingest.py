"""Ingest: Recording -> one value that holds, once, all that must be known before any method can use it."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import STANDARD_GRAVITY, Array, frozen, in_sensor_axes
from hefting.estimators.base import BiasModel
from hefting.estimators.bayes.white_noise import white_motion_noise
from hefting.estimators.sample_state import SampleState
from hefting.ingest.averages import measured_blocks, residual_size
from hefting.ingest.condition import condition
from hefting.ingest.conditioned import Conditioned, WrenchSign
from hefting.ingest.free_fit import FreeFit, free_fit, with_gravity_reversed, wrench_sign
from hefting.ingest.tool import tool_warnings, without_tool
from hefting.logs import read_log
from hefting.motion import Measured, measure
from hefting.motion.measure import DESCRIPTIONS, Source
from hefting.motion.state import Motion
from hefting.motion.weighting import acceleration_variances, sample_weights

UNDETERMINED_TOOL_INERTIA = 1.0
"""[m²] Standard deviation per kilogram of a tool's parameter that its own recording left undetermined: that of the
whole mass at a distance of one metre."""
REVERSED_GRAVITY_RATIO = 0.7
"""Ratio of the force residual with gravity reversed to that with gravity as given, below which a warning is given."""
SMALLEST_SUSPECTED_TILT = np.radians(3.0)
"""[rad] Smallest angle between the given and the estimated gravity for which a tilted base is suspected."""
TILTED_BASE_RATIO = 0.6
"""Ratio of the force residual with estimated gravity to that with gravity as given, below which a tilted base is
suspected. On the Panda recordings, of an imperfect sensor on a level base, it is 0.8 to 1."""


@dataclass(frozen=True, eq=False)
class Ingested:
    """A recording as estimators take it, and what was found out and assumed."""

    log: str
    """Where it came from."""
    static: bool
    """Whether it is poses without time."""
    measurements: Measurements
    """With the sign convention of `hefting.core.spatial`, less a given bias and the tool, with weights: of a fast
    sensor the averages over 10 ms, each with the weight of as many samples."""
    counts: Array
    """(K,) samples of the log that each of these stands for."""
    motion: Motion | None
    """Smoothed motion at the same instants, with standard deviations; None where the log gave it, or there is none."""
    source: str
    """How the motion was found: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    sign: WrenchSign
    """Which way the sensor counts, and what the data say of it."""
    sign_found: bool
    """Whether that was found, not given."""
    bias: BiasModel
    """Whether a constant bias is to be found with the object."""
    bias_found: bool
    """Whether that was found out, not given."""
    given_bias: Array | None
    """(6,) subtracted, as recorded; None where none was given"""
    conditioned: Conditioned
    """What was found of clocks, drift, gravity and bad samples."""
    tool: Estimate | None
    """What was subtracted."""
    fit: FreeFit
    """Unconstrained least squares of the object, with the bias that is to be found: what data say before any prior."""
    beside_bias: FreeFit
    """The same of all that the sensor holds, beside a free bias whether or not that is kept."""
    alone: FreeFit
    """The same with no bias."""
    noise: Noise
    """Root-mean-square residuals of `fit`, of one sample of the log."""
    within: Array
    """(6, 6) covariance of the wrench within the averages: what to add to a residual's to compare it with `noise`"""
    systematic: Array | None
    """(10, 10) covariance of what the tool and gravity's direction put into it, the same for all samples; None where
    nothing."""
    warnings: tuple[Message, ...]
    read_notes: tuple[Message, ...]
    """What reader and smoother chose and found."""

    @property
    def notes(self) -> tuple[Message, ...]:
        """What reader, smoother and conditioning found and did."""
        return (*self.read_notes, *self.conditioned.findings)

    @property
    def weighted_by_count(self) -> Measurements:
        """The measurements with weights of one on average for each sample of the log, not for each row."""
        z = self.measurements
        return z if z.weights is None else replace(z, weights=z.weights * float(self.counts.mean()))

    @cached_property
    def state(self) -> SampleState:
        """The full model's moments of the measurements."""
        return SampleState.of(self.measurements)

    def residual(self, vector: Array, bias: Array | None) -> Array:
        """(2,) root mean square of force [N] and torque [N m] that parameters (10,) and a bias (6,) leave, of one
        sample of the log and one axis."""
        z = self.measurements
        r = z.wrench - predict_wrench(z, vector)
        return residual_size(r if bias is None else r - bias, self.counts, self.within)

    @property
    def provenance(self) -> dict[str, Any]:
        """What was read and assumed, as in an estimate."""
        return {
            "log": self.log,
            "gravity": self.conditioned.gravity,
            "gravity_found": self.conditioned.tilt_std is not None,
            "wrench": self.sign.name,
            "wrench_found": self.sign_found,
            "bias": "given" if self.given_bias is not None else self.bias,
            "bias_searched": self.bias_found,
            "bias_subtracted": self.given_bias,
            "noise": {"force": self.noise.force, "torque": self.noise.torque},
            "motion": DESCRIPTIONS[self.source],
            "clock_offset": self.conditioned.offset,
            "outliers": self.conditioned.reasons,
            "tool": None if self.tool is None else self.tool.parameters.vector.tolist(),
            "notes": list(self.notes),
        }


def ingest(
    recording: Recording | str | Path,
    *,
    gravity: ArrayLike | Literal["estimate"] = STANDARD_GRAVITY,
    wrench: Literal["auto", "on-object", "on-sensor"] = "auto",
    bias: Literal["auto", "none", "estimate"] | ArrayLike = "auto",
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
    tool: Estimate | None = None,
    hint: bool = False,
) -> Ingested:
    """Understand a recording: clock, sign, bias, gravity, outliers, weights, noise and tool, in one pass.

    Parameters
    ----------
    recording : a recording or the path of a log.
    gravity, wrench, bias, motion, start, duration, tool : as for `hefting.identify`.
    hint : whether to find out where the data would have gravity, even where it explains the wrench well.

    Whether that determines an object is another question: see `hefting.ingest.plausibility.require_object`. Raises
    `InputError` for what cannot be read or understood.
    """
    if wrench not in ("auto", "on-object", "on-sensor"):
        raise InputError(f"unknown wrench convention '{wrench}'", fix="use auto, on-object or on-sensor")
    if not isinstance(recording, Recording):
        recording = read_log(recording)
    if start or duration is not None:
        recording = recording.slice(start, duration)
    recording, given = _less_bias(recording, bias)
    may_be_biased = given is None and bias != "none"
    tilt = isinstance(gravity, str)
    if tilt and gravity != "estimate":
        raise InputError(f"unknown gravity '{gravity}'", fix="use X,Y,Z [m/s²] or estimate")
    found = condition(recording, STANDARD_GRAVITY if tilt else gravity, motion, tilt=tilt, hint=hint)  # type: ignore[arg-type]
    measured, counts, within = measured_blocks(recording, found, motion, drift=may_be_biased)
    z = measured.measurements
    if not np.any(z.wrench):
        raise InputError("the wrench is zero throughout", where=recording.source, fix="check its columns")
    warnings: list[Message] = [*recording.warnings, *measured.warnings]  # type: ignore[list-item]
    warnings += [line for line in found.warnings if line.code != "bias-unknown"]  # of the bias below
    warnings += _tilt_doubts(found)
    if not may_be_biased and found.bias.kind != "constant":
        what = "a bias given, or none, leaves its drift in: `bias`='estimate' removes it"
        warnings.append(warning("drift-left-in", what, "bias"))

    z = replace(
        z,
        weights=_weights(found, measured, counts),
        motion_noise=_motion_noise(measured),
    )
    state = SampleState.of(z)
    beside = free_fit(state, True, found.inflation)
    alone = free_fit(state, False, found.inflation)
    sign = _sign(wrench, found, beside if may_be_biased else None, alone)
    if wrench == "auto" and not sign.certain:
        what = f"the wrench's sign is uncertain (t = {abs(sign.t):.1f}); assumed {sign.name}"
        warnings.append(warning("sign-uncertain", f"{what}: give `wrench` on-object or on-sensor", "wrench"))
    drifts = may_be_biased and found.bias.kind != "constant"
    free_bias = may_be_biased
    if may_be_biased and isinstance(bias, str) and bias == "auto" and not drifts and not beside.bias_is_significant:
        free_bias = False
        if beside.mass_is_open:
            what = "this motion cannot tell a bias from the object's weight: assumed no bias"
            warnings.append(warning("bias-unknown", what, "bias"))
    fit = beside if free_bias else alone
    warnings += _gravity_warnings(z, state, fit)
    tilts = _tilt_effect(recording, motion, may_be_biased, found, measured, z, fit, free_bias)
    if not sign.on_object:
        z = replace(z, force=-z.force, torque=-z.torque)
        fit, beside, alone = fit.flipped(), beside.flipped(), alone.flipped()
    r = z.wrench - predict_wrench(z, fit.vector)
    level = residual_size(r if fit.bias is None else r - fit.bias, counts, within)
    if tool is not None:
        z = without_tool(z, tool)
        fit = fit.less(tool.parameters.vector, tool.covariance)
        warnings += tool_warnings(tool)
    return Ingested(
        log=recording.source,
        static=recording.static,
        measurements=z,
        counts=counts,
        motion=measured.motion,
        source=measured.source,
        sign=sign,
        sign_found=wrench == "auto",
        bias="estimate" if free_bias else "none",
        bias_found=isinstance(bias, str) and bias == "auto",
        given_bias=given,
        conditioned=found,
        tool=tool,
        fit=fit,
        beside_bias=beside,
        alone=alone,
        noise=Noise(float(level[0]), float(level[1])),
        within=within,
        systematic=_systematic(tilts, tool),
        warnings=tuple(warnings),
        read_notes=(*recording.notes, *measured.notes),  # type: ignore[arg-type]
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


def _weights(found: Conditioned, measured: Measured, counts: Array) -> Array | None:
    """Weights (K,), one on average, by the samples of the log that each row stands for and by the smoothed motion's
    spread; None where the motion is exact and each row one sample."""
    smoothed = measured.motion is not None and measured.source != "orientation" and len(counts) > 1
    if not smoothed and (counts == 1.0).all():
        return None
    weights = counts
    if smoothed:
        phi = np.where(np.isfinite(found.covariance.diagonal()), found.parameters, 0.0)
        noise = (max(found.noise.force, 1e-12), max(found.noise.torque, 1e-12))
        each = np.array(noise) / max(float(counts.mean()), 1.0) ** 0.5
        assert measured.motion is not None
        weights = counts * sample_weights(phi, measured.motion, *each)
    return weights / weights.mean()


def _motion_noise(measured: Measured) -> MotionNoise | None:
    """Errors of the accelerations, as smoothing or filter say, or, of logged ones, as their differences do."""
    motion = measured.motion
    if motion is None:
        return white_motion_noise(measured.measurements) if measured.source == "columns" else None
    if motion.linear_acceleration_std is None:
        return None
    linear, angular = np.sqrt(acceleration_variances(motion).mean(axis=1))
    return MotionNoise(float(linear), float(angular), float(np.pi / motion.bandwidth))


def _sign(wrench: str, found: Conditioned, beside: FreeFit | None, alone: FreeFit) -> WrenchSign:
    """Which way the sensor counts: as given, or as the robust fit says, or with a known bias the free fit."""
    sign = found.sign if beside is not None and found.sign.t else wrench_sign(beside, alone)
    return sign if wrench == "auto" else WrenchSign(wrench == "on-object", sign.t)


def _gravity_warnings(z: Measurements, state: SampleState, fit: FreeFit) -> list[Message]:
    """A message when gravity the other way round explains a moving recording much better."""
    if not z.linear_acceleration.any():
        return []
    other = free_fit(with_gravity_reversed(state), fit.bias is not None).noise.force
    if other > REVERSED_GRAVITY_RATIO * fit.noise.force:
        return []
    what = f"with gravity reversed the force residual would be {other:.2g} N in place of {fit.noise.force:.2g} N"
    return [warning("gravity-reversed", f"{what}: check `gravity`", "gravity")]


def _tilt_doubts(found: Conditioned) -> list[Message]:
    """A message when gravity along another direction would explain a poorly explained wrench much better."""
    tilted = found.tilted
    if tilted is None or not tilted.suspected or not tilted.force_ratio < TILTED_BASE_RATIO:
        return []
    angle = tilted.angle(found.gravity)
    if not angle > max(SMALLEST_SUSPECTED_TILT, 5.0 * tilted.std):
        return []
    x, y, z = tilted.gravity
    where = f"({x:.2f}, {y:.2f}, {z:.2f}) m/s², {np.degrees(angle):.0f}° off"
    less = f"{tilted.force_ratio * found.noise.force:.2g} N in place of {found.noise.force:.2g} N"
    what = f"with gravity along {where}, the force residual would be {less}: is the base tilted? see `gravity`"
    return [warning("base-tilted", what, "gravity")]


def _tilt_effect(
    recording: Recording,
    motion: Source,
    drift: bool,
    found: Conditioned,
    measured: Measured,
    z: Measurements,
    fit: FreeFit,
    free_bias: bool,
) -> Array | None:
    """(10, 2) change of unconstrained least squares when gravity turns by its standard deviation about either axis
    across it; None where its direction was given."""
    if found.tilt_std is None or not np.isfinite(found.tilt_std):
        return None
    from scipy.spatial.transform import Rotation

    changes = []
    for axis in np.linalg.svd(found.gravity[None])[2][1:]:  # across gravity
        turned = Rotation.from_rotvec(found.tilt_std * axis).apply(np.array(found.gravity))
        if measured.motion is None:  # of as many rows, as nothing was averaged
            other = measure(found.corrected(recording, drift), turned, motion, found.curves).measurements
            tilted = replace(z, gravity=other.gravity, linear_acceleration=other.linear_acceleration)
        else:
            change = in_sensor_axes(measured.motion.orientation, turned - found.gravity)
            tilted = replace(z, gravity=z.gravity + change)
            if measured.source == "accelerometer":  # it measures a - g
                tilted = replace(tilted, linear_acceleration=z.linear_acceleration + change)
        changes.append(free_fit(SampleState.of(tilted), free_bias).vector - fit.vector)
    return np.array(changes).T


def _systematic(tilts: Array | None, tool: Estimate | None) -> Array | None:
    """(10, 10) covariance of the errors that all samples share."""
    C = np.zeros((10, 10)) if tilts is None else tilts @ tilts.T
    if tool is not None and tool.covariance is not None:
        open_ = np.isinf(tool.covariance.diagonal())
        own = np.where(np.isinf(tool.covariance), 0.0, tool.covariance)
        own[open_, open_] = np.square(UNDETERMINED_TOOL_INERTIA * tool.parameters.mass)
        C = C + own
    return C if C.any() else None

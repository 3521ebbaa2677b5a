"""From a settled fit to what is told of a recording."""

from dataclasses import dataclass, replace

import numpy as np

from hefting.calibration import MASS_CONFIDENCE, WrenchSign
from hefting.conditioning.drift import Drift
from hefting.conditioning.fit import Fit, Problem
from hefting.conditioning.outliers import Outliers
from hefting.conditioning.report import findings_of, warnings_of
from hefting.conditioning.result import Conditioned
from hefting.conditioning.uncertainty import Uncertainty
from hefting.measurements import Noise
from hefting.motion import smooth_poses
from hefting.recording import Recording
from hefting.spatial import skew, vector_to_tensor


@dataclass(frozen=True, eq=False)
class Settled:
    """A fit, how far it may be off, and what it leaves out."""

    fit: Fit
    spread: Uncertainty
    bad: Outliers

    @property
    def biased(self) -> bool:
        """Whether a bias was found beside the object."""
        return bool(self.fit.hats.functions.any())

    @property
    def mass_is_open(self) -> bool:
        """Whether the mass is within three standard deviations of zero, or not determined at all."""
        return not abs(self.fit.phi[0]) >= MASS_CONFIDENCE * self.spread.std(0)

    @property
    def explained(self) -> float:
        """Share of the wrench's changes that the motion and the bias explain."""
        fit = self.fit
        wrench = (fit.residual + fit.model.regressor @ fit.phi + fit.bias_now) * np.repeat(1.0 / fit.scale, 3)
        total = fit.weights @ (wrench - fit.weights @ wrench / max(fit.weights.sum(), 1e-300)) ** 2
        left = fit.weights @ (fit.residual * np.repeat(1.0 / fit.scale, 3)) ** 2
        return float(1.0 - left.sum() / max(total.sum(), 1e-300))


def conclude(
    recording: Recording,
    raw: Problem,
    found: Settled,
    late: tuple[float, float] | None,
    clock: bool,
    tilt: bool,
    few: bool = False,
) -> Conditioned:
    """The result, in the project's sign.

    `late` is an offset that was not significant, and its deviation; `few`: there were too few samples to condition.
    """
    fit, spread, bad = found.fit, found.spread, found.bad
    moving = raw.signal.kind != "static"
    std, no_bias = spread.std(0), not found.biased
    doubtful = found.mass_is_open or no_bias
    t = 0.0 if doubtful else float(fit.phi[0]) / max(std, 1e-12 * abs(float(fit.phi[0])), 1e-300)
    sign = WrenchSign(bool(fit.phi[0] >= 0.0), t)
    turn = 1.0 if sign.on_object else -1.0
    offset_std: float | None = None
    if clock and moving:
        offset_std = late[1] if late else spread.offset_std
    tilt_std = None
    if tilt and not raw.signal.gravity_measured:
        tilt_std = np.inf
    if raw.free_gravity and len(spread.covariance) >= 12:
        at = len(spread.covariance) - 2
        tilt_std = float(np.sqrt(np.mean(spread.covariance.diagonal()[at:])) / np.linalg.norm(fit.gravity))
    bias_std = np.where(no_bias, np.inf, spread.bias)
    weights = np.where(fit.weights > 0.0, 1.0, 0.0)
    mean = weights @ fit.bias_now / max(weights.sum(), 1.0)
    bias = Drift(fit.hats.knots, fit.bias, bias_std, mean)
    reasons = {name: int(getattr(bad, name).sum()) for name in ("contact", "spike", "saturation")}
    result = Conditioned(
        parameters=turn * fit.phi,
        covariance=spread.covariance[:10, :10],
        offset=fit.offset if raw.free_offset else 0.0,
        offset_std=offset_std,
        sign=sign,
        bias=bias,
        gravity=fit.gravity,
        tilt_std=tilt_std,
        noise=_noise(raw, fit),
        rejected=bad.rejected,
        reasons=reasons,
        autocorrelation=spread.autocorrelation,
        findings=(),
        curves=raw.signal.curves,
    )
    if (
        tilt_std is not None and np.isfinite(tilt_std) and result.curves is not None
    ):  # an accelerometer beside them feels gravity
        result = replace(result, curves=smooth_poses(recording, fit.gravity, result.curves.alone))
    findings = findings_of(result, recording, bad, late)
    warnings = warnings_of(result, raw.signal, found.explained, late, clock, tilt, few, no_bias)
    return replace(result, findings=findings, warnings=warnings)


def _noise(problem: Problem, fit: Fit) -> Noise:
    """Of the wrench, what the residuals hold beside the motion's errors; of the accelerations, those."""
    used = fit.weights > 0.0
    seen = problem.signal.at(problem.time[:: max(len(problem.time) // 1000, 1)] - fit.offset)
    a = 0.0 if seen.linear_std is None else float(np.mean(seen.linear_std**2))
    alpha = float(np.mean(seen.angular_std**2))
    lever = float(np.sum(skew(fit.phi[1:4]) ** 2)) / 3.0
    inertia = float(np.sum(vector_to_tensor(fit.phi[4:]) ** 2)) / 3.0
    spent = used.sum() / max(used.sum() - len(fit.phi) / 6.0 - fit.hats.n, 1.0)
    force, torque = (float(s) for s in fit.scale**2 * spent)
    return Noise(
        force=max(force - float(fit.phi[0]) ** 2 * a - lever * alpha, 0.01 * force) ** 0.5,
        torque=max(torque - lever * a - inertia * alpha, 0.01 * torque) ** 0.5,
        linear_acceleration=a**0.5,
        angular_acceleration=alpha**0.5,
    )

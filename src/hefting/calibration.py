"""What must be known of the sensor before an object can be: the wrench's sign and its bias."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.errors import InputError
from hefting.estimators.blend import Blend
from hefting.estimators.ols import least_squares
from hefting.files import read_json
from hefting.measurements import Measurements, Noise
from hefting.recording import Recording
from hefting.regressor import predict_wrench
from hefting.spatial import CHUNK, PARAMETERS, Array, skew

SIGN_CONFIDENCE = 10.0
"""|t| of the mass below which its sign is not trusted."""
MASS_CONFIDENCE = 3.0
"""|t| of the mass below which it is not determined."""
BIAS_CONFIDENCE = 3.0
"""Standard deviations a component must be away from zero for a bias to be kept."""

TYPICAL_SIZE = 0.2
"""Size of a held object [m], by which to judge what is known well enough where no shape says."""


@dataclass(frozen=True, eq=False)
class FreeFit:
    """Unconstrained least squares, whitened by its own residuals: what the data say before any prior."""

    vector: Array
    """(10,) parameters, with the wrench's sign as recorded"""
    bias: Array | None
    """(6,) constant bias, when it was free"""
    covariance: Array
    """(10, 10) or (16, 16), widened by the residuals' autocorrelation; infinite where undetermined"""
    noise: Noise
    """wrench noise: root-mean-square residuals"""
    autocorrelation: float
    """integrated autocorrelation time of the residuals, in samples"""

    @property
    def mass_t(self) -> float:
        """Mass over its standard deviation; 0 when undetermined."""
        std = float(np.sqrt(self.covariance[0, 0]))
        return float(self.vector[0]) / max(std, 1e-12 * abs(float(self.vector[0])), 1e-300)

    @property
    def mass_is_open(self) -> bool:
        """Whether the mass is within three standard deviations of zero, or not determined at all."""
        return not abs(self.mass_t) >= MASS_CONFIDENCE

    def open_parameters(self, size: float) -> tuple[str, ...]:
        """Names of the parameters the data leave open for an object of `size` [m].

        Those whose standard deviation is over a third of the mass, half the size for the COM, m size² / 12 for an
        inertia.
        """
        std = np.sqrt(self.covariance.diagonal()[:10])
        mass = abs(float(self.vector[0]))
        limits = np.concatenate(
            ([mass / MASS_CONFIDENCE], np.full(3, mass * size / 2), np.full(6, mass * size**2 / 12))
        )
        return tuple(PARAMETERS[i] for i in np.flatnonzero(~(std <= limits)))

    @property
    def bias_t(self) -> Array:
        """(6,) each component of the bias over its standard deviation; 0 where undetermined."""
        if self.bias is None:
            return np.zeros(6)
        std = np.sqrt(self.covariance.diagonal()[10:])
        return self.bias / np.maximum(std, 1e-300)


def fit_freely(measurements: Measurements, free_bias: bool) -> FreeFit:
    """Ten parameters, and a constant bias if free, by least squares in two passes: plain, then whitened.

    The noise is the residual of the full model, so it holds what the motion's errors add to the wrench's own.
    """
    state = Blend.of(measurements)
    fit = least_squares(state, free_bias, None)
    for _ in range(2):
        vector, bias = fit.solution[:10], fit.solution[10:] if free_bias else None
        r = residuals(measurements, vector, bias)
        spent = max(1.0 - (len(fit.solution) - len(fit.free)) / r.size, 1.0 / r.size)
        size = np.sqrt(np.mean(measurements.wrench**2)) or 1.0
        force, torque = (max(float(np.sqrt(np.mean(part**2) / spent)), 1e-9 * size) for part in (r[:, :3], r[:, 3:]))
        noise = Noise(force=force, torque=torque)
        fit = least_squares(state, free_bias, noise)
    tau = autocorrelation_time(r / np.repeat((force, torque), 3))
    return FreeFit(fit.solution[:10], fit.solution[10:] if free_bias else None, fit.covariance * tau, noise, tau)


@dataclass(frozen=True)
class WrenchSign:
    """Which way the sensor counts, from the sign of the mass that gravity makes it feel."""

    on_object: bool
    """True: the log holds what the sensor exerts on the object; False: what the object exerts on it."""
    t: float
    """Mass over its standard deviation, as recorded: positive for on-object."""

    @property
    def certain(self) -> bool:
        """Whether the data decide."""
        return abs(self.t) >= SIGN_CONFIDENCE


def wrench_sign(measurements: Measurements, free_bias: bool) -> WrenchSign:
    """Sign of the wrench from the least-squares mass, with or without a constant bias beside it.

    Where a free bias leaves the mass undetermined (one orientation), the sign is that of the mass without one
    and t is 0: not certain.
    """
    fit = fit_freely(measurements, free_bias)
    if not free_bias or not fit.mass_is_open:
        return WrenchSign(bool(fit.vector[0] >= 0.0), fit.mass_t)
    return WrenchSign(bool(fit_freely(measurements, False).vector[0] >= 0.0), 0.0)


def bias_is_significant(fit: FreeFit) -> bool:
    """Whether a component of a fitted bias is more than three standard deviations from zero.

    False where the motion cannot tell a bias from the object.
    """
    known = not fit.mass_is_open and np.isfinite(fit.covariance[10:, 10:]).all()
    return bool(known and (np.abs(fit.bias_t) > BIAS_CONFIDENCE).any())


def lever(measurements: Measurements, free_bias: bool) -> float:
    """Distance [m] of the COM from the sensor by gravity alone: first moment by the torque over mass by the force.

    Rough, as motion is ignored, but the two are found apart: a torque in another unit shows. 0 where undetermined:
    beside a bias, when gravity turns by less than about 3° in sensor axes.
    """
    if free_bias and np.ptp(measurements.gravity, axis=0).max() < 0.1 * np.linalg.norm(measurements.gravity[0]):
        return 0.0
    force = -measurements.gravity[:, :, None]
    torque = skew(measurements.gravity)
    wrench = measurements.force, measurements.torque
    sizes = []
    for A, b in zip((force, torque), wrench, strict=True):
        if free_bias:
            A, b = A - A.mean(axis=0), b - b.mean(axis=0)
        sizes.append(float(np.linalg.norm(np.linalg.lstsq(A.reshape(b.size, -1), b.ravel(), rcond=1e-3)[0])))
    return sizes[1] / sizes[0] if sizes[0] > 0.0 else 0.0


def autocorrelation_time(series: Array) -> float:
    """Integrated autocorrelation time of the columns of `series` (K, d), averaged; 1 for white noise, never less.

    Long series are cut into stretches of `CHUNK` samples whose autocovariances are averaged.
    """
    x = series - series.mean(axis=0)
    stretches = max(len(x) // CHUNK, 1)
    n = len(x) // stretches
    if n < 8 or not x.any():
        return 1.0
    size = 1 << (2 * n - 1).bit_length()
    times = []
    for column in x.T:
        power = sum(np.abs(np.fft.rfft(column[k * n : (k + 1) * n], size)) ** 2 for k in range(stretches))
        covariance = np.fft.irfft(power, size)[: n // 2]
        if covariance[0] <= 0.0:
            continue
        rho = covariance / covariance[0]
        below = np.flatnonzero(rho < 0.05)
        times.append(1.0 + 2.0 * float(rho[1 : below[0] if len(below) else len(rho)].sum()))
    return max(1.0, float(np.mean(times))) if times else 1.0


def residuals(measurements: Measurements, vector: Array, bias: Array | None) -> Array:
    """Measured minus predicted wrench (K, 6) for ten parameters and a bias (6,)."""
    r = measurements.wrench - predict_wrench(measurements, vector)
    return r if bias is None else r - bias


def tare(recording: Recording, start: float, end: float) -> Array:
    """Mean wrench (6,), as recorded, between two times [s] counted from the first sample, when nothing was held.

    Raises `InputError` when no wrench was measured then.
    """
    wrench = recording["wrench"]
    chosen = (wrench.time >= recording.start + start) & (wrench.time <= recording.start + end)
    if not chosen.any():
        raise InputError(f"no wrench between {start:g} and {end:g} s to tare with", where=recording.source)
    return wrench.values[chosen].mean(axis=0)


def load_bias(path: str | Path) -> Array:
    """Bias (6,) [N, N m] of a JSON file: its ``bias`` key, as in an estimate, or six numbers."""
    data = read_json(path)
    try:
        values = np.asarray(data["bias"] if isinstance(data, dict) else data, dtype=float)
        if isinstance(data, dict) and (data.get("provenance") or {}).get("wrench") == "on-sensor":
            values = -values  # an estimate holds it in the project's sign, a log in the sensor's
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise InputError(
            f"holds no bias ({str(error)[:80]})", where=path, fix='write {"bias": [fx,fy,fz,tx,ty,tz]}'
        ) from error
    if values.shape != (6,) or not np.isfinite(values).all():
        raise InputError("a bias is six finite numbers [N, N m]", where=path)
    return values

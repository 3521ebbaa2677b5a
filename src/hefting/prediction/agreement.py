"""Agreement: how well an estimate explains a wrench that was measured, of this
recording or another."""

from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.messages import Message, warning
from hefting.core.regressor import predict_wrench
from hefting.core.sensor_accuracy import Z95, SensorAccuracy
from hefting.core.spatial import Array, frozen
from hefting.ingest.conditioned import WrenchSign
from hefting.ingest.ingest import Ingested
from hefting.prediction.spread import Spread, reading_std

FEWEST = 12
"""Samples below which a fit of their own says nothing of their noise."""
MOSTLY = 0.5
"""Share of the squared difference that varies below which its constant part is worth a
word."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """A measured wrench, put right and beside the predicted one, at L instants of its
    own."""

    time: Array
    """(L,) [s], on the motion's clock"""
    wrench: Array
    """(L, 6) [N, N m] in the sign of `hefting.core.spatial`, less the estimate's bias
    and what drifts"""
    difference: Array
    """(L, 6) that wrench minus the predicted one"""
    rms: Array
    """(2,) root mean square an axis of the difference: force [N], torque [N m]"""
    varying: Array
    """(2,) the same of the difference less its mean, which another bias of the sensor
    would be"""
    own: Array | None
    """(2,) the same of what least squares on this recording itself, with a free bias,
    leave; None of a few samples"""
    within: Array | None
    """(2,) shares of forces and torques inside the band widened by ``own``: 0.95 where
    all is as it should be"""
    sign: WrenchSign
    """which way the sensor counts"""
    notes: tuple[Message, ...] = ()
    """What was found of clock, drift and outliers, and put right."""
    warnings: tuple[Message, ...] = ()

    def __post_init__(self):
        for name in ("time", "wrench", "difference", "rms", "varying", "own", "within"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, frozen(getattr(self, name)))


def agreement(
    estimate: Estimate,
    spread: Spread | None,
    found: Ingested,
    accuracy: SensorAccuracy | None = None,
) -> Agreement:
    """How well `estimate` explains the wrench of a recording, as ingested with a free
    bias, by a sensor of an `accuracy`."""
    z, sign = found.measurements, found.sign
    warnings = []
    if not sign.certain:
        what = (
            "the sign of the measured wrench is uncertain "
            f"({abs(sign.t):.1f} standard deviations); assumed {sign.name}"
        )
        warnings.append(warning("sign-uncertain", what, "wrench"))
    predicted = predict_wrench(z, estimate.parameters.vector)
    difference = z.wrench - predicted
    bias = estimate.common_bias
    if bias is not None:
        difference = difference - bias
    rms, varying = _rms(difference), _rms(difference - difference.mean(axis=0))
    own = within = None
    if len(z) >= FEWEST:
        fit = found.beside_bias
        left = z.wrench - predict_wrench(z, fit.vector)
        own = _rms(left if fit.bias is None else left - fit.bias)
    if own is not None and spread is not None:
        known = np.hypot(spread.of_wrench(z), reading_std(predicted, accuracy))
        wide = Z95 * np.hypot(known, np.repeat(own, 3))
        within = np.mean((np.abs(difference) <= wide).reshape(-1, 2, 3), axis=(0, 2))
    if own is not None:
        warnings += _doubts(difference.mean(axis=0), rms, varying, own)
    wrench = z.wrench if bias is None else z.wrench - bias
    notes = found.conditioned.findings
    return Agreement(
        z.time,
        wrench,
        difference,
        rms,
        varying,
        own,
        within,
        sign,
        notes,
        tuple(warnings),
    )


def _rms(difference: Array) -> Array:
    """(2,) an axis of forces and torques (L, 6)."""
    return np.sqrt(np.mean(difference.reshape(-1, 2, 3) ** 2, axis=(0, 2)))


def _doubts(mean: Array, rms: Array, varying: Array, own: Array) -> list[Message]:
    """A message where a constant is most of a difference that noise does not
    explain."""
    if not ((rms > 2.0 * own) & (varying**2 < MOSTLY * rms**2)).any():
        return []
    force, torque = (
        ", ".join(f"{x:.3g}" for x in part) for part in (mean[:3], mean[3:])
    )
    what = (
        f"most of the difference is constant, ({force}) N, ({torque}) N m: a bias other than the estimate's? was the "
        "sensor zeroed in between?"
    )
    return [warning("constant-difference", what)]

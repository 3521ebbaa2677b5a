"""Result of a prediction, its agreement with a measured wrench, and its JSON and CSV."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.estimate_json import json_ready, subtracted_tool
from hefting.core.messages import Message, Verdict, error, verdict_of, warning
from hefting.core.quantity import wrench_text
from hefting.core.regressor import predict_wrench
from hefting.core.sensor_accuracy import EXACT, Z95, SensorAccuracy
from hefting.core.spatial import WRENCH, Array, freeze, immutable
from hefting.core.summary import warning_lines
from hefting.core.undetermined import Covariance
from hefting.ingest.conditioned import WrenchSign
from hefting.ingest.free_fit import residuals
from hefting.ingest.ingest import Ingested

FEWEST = 12
"""Fewest samples from whose own fit their noise is estimated."""
SEVERAL = 3.0
"""Ratio of the varying part of the difference to its standard deviation by noise and the
estimate's covariance above which the object is taken for another one."""
LARGELY = 0.1
"""Ratio of the varying part of that difference to the variation of the wrench above which
the prediction is not to be used: 8 % more mass, or a COM off by 1 cm."""
MOSTLY = 0.5
"""Varying share of the squared difference below which its constant part is reported."""


@immutable
class Agreement:
    """A corrected wrench, compared with the predicted one at its L instants."""

    time: Array
    """(L,) [s], on the motion's clock"""
    wrench: Array
    """(L, 6) [N, N m] in the sign of `hefting.core.spatial`, without drift and the
    estimate's bias; of several biases the one that fits best"""
    difference: Array
    """(L, 6) ``wrench`` minus the predicted one"""
    rms: Array
    """(2,) root mean square of one axis of the difference: force [N], torque [N m]"""
    varying: Array
    """(2,) the same after subtraction of the mean, which may be another sensor bias"""
    own: Array | None
    """(2,) the same for the residuals of least squares with a free bias on this
    recording; None with fewer than `FEWEST` samples"""
    within: Array | None
    """(2,) shares of forces and torques in the band with ``own``; 0.95 is expected"""
    sign: WrenchSign
    """sign convention of the measured wrench"""
    notes: tuple[Message, ...] = ()
    """Corrections of clock, drift and outliers."""
    warnings: tuple[Message, ...] = ()

    def __post_init__(self):
        arrays = ("time", "wrench", "difference", "rms", "varying", "own", "within")
        freeze(self, *arrays)


def agreement(
    estimate: Estimate,
    spread: Covariance | None,
    found: Ingested,
    accuracy: SensorAccuracy | None = None,
) -> Agreement:
    """Agreement of an estimate with the wrench of a recording.

    Parameters
    ----------
    estimate : Estimate
        Its bias, of several the one that fits best, is taken off the wrench.
    spread : Covariance or None
        Of the parameters; without it ``within`` is None.
    found : Ingested
        The recording, ingested with a free bias.
    accuracy : SensorAccuracy or None
        Accuracy of the sensor that measured the wrench.
    """
    z, sign = found.measurements, found.sign
    warnings: list[Message] = []
    if not sign.certain:
        what = f"the sign of the measured wrench is uncertain ({sign.doubt}); assumed {sign.name}"
        warnings.append(warning("sign-uncertain", what, "wrench"))
    predicted = predict_wrench(z, estimate.parameters.vector)
    difference = z.wrench - predicted
    varying = _rms(difference - difference.mean(axis=0))
    bias = _closest_bias(estimate, difference, varying)
    difference = difference - bias
    mean, rms = difference.mean(axis=0), _rms(difference)
    is_constant = varying**2 < MOSTLY * rms**2  # (2,) of forces and torques, mostly
    own = within = None
    if len(z) >= FEWEST:
        fit = found.beside_bias
        own = _rms(residuals(z, fit.vector, fit.bias))
    if own is not None and spread is not None:
        known = np.hypot(
            spread.of_wrench(z), (accuracy or EXACT).reading_std(predicted)
        )
        std = np.hypot(known, np.repeat(own, 3))
        inside = np.abs(difference - np.repeat(is_constant, 3) * mean) <= Z95 * std
        within = np.mean(inside.reshape(-1, 2, 3), axis=(0, 2))
        changes = _rms(z.wrench - z.wrench.mean(axis=0))
        has_tool = subtracted_tool(estimate.provenance) is not None
        warnings += _other_object(varying, _rms(std), changes, has_tool)
    if own is not None and ((rms > 2.0 * own) & is_constant).any():
        warnings.append(_constant_difference(mean))
    return Agreement(
        z.time,
        z.wrench - bias,
        difference,
        rms,
        varying,
        own,
        within,
        sign,
        notes=found.conditioned.findings,
        warnings=tuple(warnings),
    )


def _closest_bias(estimate: Estimate, difference: Array, varying: Array) -> Array:
    """The bias (6,) of an estimate, zeros without one, that leaves least of the
    difference (L, 6) between a measured and a predicted wrench. Forces and torques are
    in units of their part that varies (2,)."""
    return min(
        np.atleast_2d(np.zeros(6) if estimate.bias is None else estimate.bias),
        key=lambda each: float(np.sum(_rms(difference - each) / (varying + 1e-9))),
    )


def _constant_difference(mean: Array) -> Message:
    """A message on a difference whose mean (6,) [N, N m] is most of it."""
    what = (
        f"most of the difference is constant, {wrench_text(mean)}: a bias "
        "other than the estimate's? was the sensor zeroed in between?"
    )
    return warning("constant-difference", what)


def _other_object(
    varying: Array, expected: Array, changes: Array, has_tool: bool
) -> list[Message]:
    """A message if the difference varies far more than expected; `changes` is the
    variation of the wrench, all (2,) root mean squares, force [N] and torque [N m]."""
    beyond = varying > SEVERAL * expected
    if not beyond.any():
        return []
    (force, torque), (usual, turning) = varying, expected
    cause = "is it another object, or another grasp?"
    if has_tool:
        cause = "is the tool on the sensor here too (give `tool`), or is it another object, or another grasp?"
    what = (
        f"the difference varies by {force:.2g} N and {torque:.2g} N m, and is "
        f"expected to by {usual:.2g} N and {turning:.2g} N m: {cause}"
    )
    is_large = (beyond & (varying > LARGELY * changes)).any()
    say = error if is_large else warning
    return [say("another-object", what)]


def _rms(difference: Array) -> Array:
    """Root mean square (2,) of one axis of forces and of torques (L, 6)."""
    return np.sqrt(np.mean(difference.reshape(-1, 2, 3) ** 2, axis=(0, 2)))


SCHEMA = "hefting.prediction/1"


@dataclass(frozen=True)
class Peak:
    """An extreme of one quantity."""

    value: float
    """[N] or [N m]"""
    time: float
    """[s]; of static poses the row, counted from 0"""
    std: float | None
    """standard deviation of the value; None if the estimate has no covariance"""

    @property
    def reach(self) -> float | None:
        """Half the width of the 95 % band there."""
        return None if self.std is None else Z95 * self.std

    def to_dict(self) -> dict[str, Any]:
        """Value, time and ends of its 95 % band, null where these do not exist."""
        reach = self.reach
        ends = (
            (None, None) if reach is None else (self.value - reach, self.value + reach)
        )
        return {"value": self.value, "time": self.time, "low": ends[0], "high": ends[1]}


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """Wrench along a motion, exerted by the sensor on the object, in sensor axes about
    the sensor's origin.

    The band holds the true wrench with 95 % probability, for each component and instant
    separately, if the motion is exact and only the parameters are uncertain. A sensor's
    reading has noise and bias in addition.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv").estimate
    >>> hefting.predict(found, "demo/log.csv").wrench.shape
    (1000, 6)
    """

    trajectory: str
    """Source of the motion."""
    method: str
    """Method of the estimate, and of an added tool."""
    static: bool
    """Whether the rows are static poses; ``time`` then counts them from 0."""
    time: Array
    """(K,) [s]"""
    wrench: Array
    """(K, 6) force [N] and torque [N m]"""
    std: Array | None
    """(K, 6) standard deviations; infinite where the estimate leaves a parameter open
    that matters, None if it has no covariance"""
    peaks: dict[str, Peak]
    """Largest norms of ``force`` and ``torque``; standard deviations to first order."""
    gravity: Array
    """(3,) in world axes [m/s²]"""
    source: str
    """Source of the derivatives: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    motion_std: Array | None = None
    """(2,) root mean square of one axis of the errors of force [N] and torque [N m] by
    errors of a smoothed motion, which the band does not include. They are those that
    smoothing estimates, which are too low for motion without noise. None if the log gave
    the motion."""
    agreement: Agreement | None = None
    """Agreement with the wrench of the log, if it has one."""
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self):
        freeze(self, "time", "wrench", "std", "gravity", "motion_std")

    def __repr__(self) -> str:
        """The verdict, its reasons, the largest force and torque, and the arrays."""
        largest = (
            f"  largest {name}  {peak.value:.4g}"
            f"{'' if not peak.reach else f' ± {peak.reach:.2g}'} {unit}"
            for (name, peak), unit in zip(self.peaks.items(), ("N", "N m"), strict=True)
        )
        return "\n".join(
            (
                f"Prediction by {self.method}, verdict: {self.verdict}",
                *largest,
                f"  at hand         {len(self)} instants in .time, .wrench, .low, .high",
                *warning_lines(self.warnings),
            )
        )

    def __len__(self) -> int:
        return len(self.time)

    @property
    def verdict(self) -> Verdict:
        """Whether to trust it; doubts about the estimate are part of the warnings."""
        return verdict_of(self.warnings)

    @property
    def low(self) -> Array | None:
        """(K, 6) lower end of the 95 % band; minus infinity where open."""
        return None if self.std is None else self.wrench - Z95 * self.std

    @property
    def high(self) -> Array | None:
        """(K, 6) upper end of the 95 % band."""
        return None if self.std is None else self.wrench + Z95 * self.std

    @property
    def extremes(self) -> dict[str, tuple[Peak, Peak]]:
        """Lowest and highest value of each component ``fx`` .. ``tz``."""
        extremes = {}
        for i, name in enumerate(WRENCH):
            at = int(np.argmin(self.wrench[:, i])), int(np.argmax(self.wrench[:, i]))
            extremes[name] = tuple(
                Peak(
                    float(self.wrench[k, i]),
                    float(self.time[k]),
                    None if self.std is None else float(self.std[k, i]),
                )
                for k in at
            )
        return extremes

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values; null where the band is infinite.

        ``peaks`` by ``force`` and ``torque``, ``extremes`` by component with ``lowest``
        and ``highest``: each ``{"value", "time", "low", "high"}``. ``time`` (K),
        ``wrench``, ``low`` and ``high`` (K x 6); the last two are null without a
        covariance. ``agreement`` with a measured wrench, null without one: ``rms``,
        ``varying``, ``own``, ``within`` (force, torque), ``wrench`` (the log's
        convention), ``samples``, ``notes``.
        """
        from hefting import __version__

        a = self.agreement
        return json_ready(
            {
                "schema": SCHEMA,
                "version": __version__,
                "trajectory": self.trajectory,
                "method": self.method,
                "frame": "sensor",
                "verdict": self.verdict.level,
                "reasons": list(self.verdict.reasons),
                "gravity": self.gravity,
                "motion": self.source,
                "motion_std": self.motion_std,
                "static": self.static,
                "samples": len(self),
                "peaks": {name: peak.to_dict() for name, peak in self.peaks.items()},
                "extremes": {
                    name: {"lowest": lowest.to_dict(), "highest": highest.to_dict()}
                    for name, (lowest, highest) in self.extremes.items()
                },
                "agreement": a
                and {
                    **{k: getattr(a, k) for k in ("rms", "varying", "own", "within")},
                    "wrench": a.sign.name,
                    "samples": len(a.time),
                    "notes": a.notes,
                },
                "warnings": self.warnings,
                "notes": self.notes,
            }
        ) | {
            name: _rows(getattr(self, name))
            for name in ("time", "wrench", "low", "high")
        }

    def csv(self) -> bytes:
        """A table with one row for each instant: ``time`` and ``fx`` .. ``tz``, named as
        in a log, which makes it readable as one, then ``fx_low``, ``fx_high`` and so
        on. Infinite ends are blank; static poses have no time, as in a log."""
        import pyarrow as pa

        from hefting.logs.canonical import csv_of

        columns = {} if self.static else {"time": pa.array(self.time)}
        columns |= {name: pa.array(self.wrench[:, i]) for i, name in enumerate(WRENCH)}
        for i, name in enumerate(WRENCH):
            for end, values in (("low", self.low), ("high", self.high)):
                if values is not None:
                    columns[f"{name}_{end}"] = pa.array(
                        values[:, i], mask=~np.isfinite(values[:, i])
                    )
        return csv_of(pa.table(columns))


def _rows(values: Array | None) -> list | None:
    """An array as lists, with None for values that are not finite."""
    if values is None:
        return None
    return values.tolist() if np.isfinite(values).all() else json_ready(values)

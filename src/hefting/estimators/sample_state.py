"""SampleState: samples divided between the reduced (gravity) and full models."""

from collections.abc import Iterable
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.measurements import Measurements
from hefting.core.moments import Moments
from hefting.core.regressor import features, full_model_weight
from hefting.core.spatial import CHUNK, Array, immutable
from hefting.estimators.time_record import TimeRecord

Model = Literal["full", "reduced", "blended"]
MODELS: dict[str, str] = {
    "full": "Newton-Euler",
    "reduced": "gravity only: mass and centre of mass",
    "blended": "by the motion's dynamism: w = tanh(3 nu / c1) of the full model, 1 - w of the reduced",
}

SMOOTHED_C1 = 1.0
"""c1 of the blended model for poses smoothed here. The paper's 300 suits accelerations
as noisy as a causal filter's; with these it biases PMD's answer: on simulated
recordings of 1.5 to 10 s, 0.7 and 1.5 rad/s, two bodies, mean errors at 300 over those
at 1 were 0.95 to 19 for the COM, 0.99 to 8 for the inertia about the sensor, 0.8 to 4
about the COM."""


@immutable
class SampleState:
    """Moments of the samples with their equations scaled by 1 - w for the reduced model
    and by w for the full one.

    This is the state of every estimator: w is 1 throughout for those that know the full
    model only.
    """

    reduced: Moments
    full: Moments
    samples: int = 0
    """Samples seen."""
    record: TimeRecord | None = None
    """Time record, for estimators that find their own noise; None for others."""

    @classmethod
    def empty(cls, with_record: bool = False) -> Self:
        """Without samples."""
        return cls(
            Moments.empty(),
            Moments.empty(),
            record=TimeRecord() if with_record else None,
        )

    @classmethod
    def of(cls, measurements: Measurements, weight: Array | float = 1.0) -> Self:
        """Of `measurements` alone."""
        return cls.empty().fold(measurements, weight)

    def fold(self, measurements: Measurements, weight: Array | float = 1.0) -> Self:
        """With the samples of `measurements` added; `weight` w (K,) is the share of the
        full model in each, or one for all."""
        if len(measurements) > CHUNK:
            return self._fold_in_chunks(measurements, weight)
        x, time = features(measurements), measurements.time
        samples, record = self.samples + len(time), self.record
        if record is not None and len(time):
            errors = measurements.acceleration_errors
            record = record.fold(x, measurements.weights, errors)
        if isinstance(weight, float) and weight == 1.0:
            return type(self)(
                self.reduced, self.full.fold_features(x, time), samples, record
            )
        if isinstance(weight, float) and weight == 0.0:
            return type(self)(
                self.reduced.fold_features(x, time), self.full, samples, record
            )
        w = np.asarray(weight, dtype=float)
        ends = (w.item(),) if w.size == 1 else (w.min(initial=0.0), w.max(initial=0.0))
        if w.shape not in ((), time.shape) or not 0.0 <= min(ends) <= max(ends) <= 1.0:
            raise InputError(
                f"weights are one number or one for each of {len(time)} samples, from 0 to 1"
            )
        if not w.shape:
            w = np.full(time.shape, w)
        reduced = self.reduced.fold_features(x, time, 1.0 - w)
        full = self.full.fold_features(x, time, w)
        return type(self)(reduced, full, samples, record)

    def _fold_in_chunks(
        self, measurements: Measurements, weight: Array | float
    ) -> Self:
        state = self
        for first in range(0, len(measurements), CHUNK):
            part = slice(first, first + CHUNK)
            own = (
                weight[part]
                if isinstance(weight, np.ndarray) and weight.ndim
                else weight
            )
            state = state.fold(measurements[part], own)
        return state

    def merge(self, other: "SampleState", *, one_bias: bool = False) -> Self:
        """With the samples of both. `one_bias` states that they have the same bias or
        none, as parts of one recording; states of several recordings are joined instead
        (`hefting.estimators.joint_state`). Raises `InputError` if both have samples and
        `one_bias` is not stated."""
        if not (one_bias or self.is_empty or other.is_empty):
            raise InputError(
                "each of the states may have a wrench bias of its own",
                fix="use the estimator's merge, or say one_bias=True of parts of one "
                "recording",
            )
        samples, record = self.samples + other.samples, None
        if self.record is not None and other.record is not None:
            first, later = (self, other) if self.end <= other.end else (other, self)
            record = first.record.merge(later.record)  # type: ignore[union-attr]
        return type(self)(
            self.reduced.merge(other.reduced, one_bias=True),
            self.full.merge(other.full, one_bias=True),
            samples,
            record,
        )

    def scaled(self, weight: float) -> Self:
        """With every weight multiplied by `weight`."""
        record = None if self.record is None else self.record.scaled(weight)
        reduced, full = self.reduced.scaled(weight), self.full.scaled(weight)
        return type(self)(reduced, full, self.samples, record)

    @property
    def is_empty(self) -> bool:
        """Whether no sample was seen, including those that a method leaves out."""
        return not self.samples and (self.record is None or not self.record.motion[0])

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        return max(self.reduced.end, self.full.end)

    @property
    def duration(self) -> float:
        """Time between the first and the last sample [s]."""
        start = min(self.reduced.start, self.full.start)
        end = max(self.reduced.end, self.full.end)
        return max(0.0, end - start)


def model_weight(measurements: Measurements, model: str, c1: float) -> Array | float:
    """Share w of the full model: 1, 0, or (K,) by the dynamism (Nadeau 2022, eq. 9)."""
    if model == "blended":
        return full_model_weight(measurements, c1)
    return float(model == "full")


def require_model(model: str, c1: float) -> None:
    """`InputError` unless `model` names one and c1 is positive and finite."""
    require_one_of("model", model, MODELS)
    require_positive("c1", c1)


def require_one_of(name: str, value: object, choices: Iterable[str]) -> None:
    """`InputError` unless `value` is one of `choices`."""
    if not isinstance(value, str) or value not in choices:
        raise InputError(f"unknown {name} '{value}'", fix=f"use {', '.join(choices)}")


def require_positive(name: str, value: object) -> None:
    """`InputError` unless `value` is a positive, finite number."""
    if not (isinstance(value, int | float) and 0.0 < value < np.inf):
        raise InputError(f"{name} must be positive and finite, not {value}")


def require_carried(value: ArrayLike | None) -> None:
    """`InputError` unless what is carried is None or ten finite parameters."""
    if value is not None and not (np.shape(value) == (10,) and _all_finite(value)):
        what = f"what is carried is ten finite parameters, not {np.shape(value)}"
        raise InputError(what)


def require_common_covariance(value: ArrayLike | None) -> None:
    """`InputError` unless `value` is None or the covariance (10, 10) of an error that
    all samples share."""
    if value is None:
        return
    if not (np.shape(value) == (10, 10) and _all_finite(value)):
        raise InputError(
            f"a systematic error's covariance is (10, 10) and finite, not {np.shape(value)}"
        )
    C = np.asarray(value, dtype=float)
    scale = np.sqrt(np.where(C.diagonal() > 0.0, C.diagonal(), 1.0))
    if np.linalg.eigvalsh(C / np.outer(scale, scale)).min() < -1e-6:
        raise InputError("a systematic error's covariance is positive semidefinite")


def require_weight(states: Iterable[SampleState]) -> None:
    """`NotIdentifiableError` if no sample has a positive weight."""
    if not any(state.full.ones.any() for state in states):
        raise NotIdentifiableError(
            "no sample has any weight", fix="give weights above zero"
        )


def _all_finite(value: ArrayLike) -> bool:
    return bool(np.isfinite(np.asarray(value, dtype=float)).all())

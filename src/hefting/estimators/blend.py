"""Blend: samples divided between the reduced (gravity-only) and the full Newton-Euler model."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np

from hefting.errors import InputError
from hefting.measurements import Measurements
from hefting.moments import Moments
from hefting.regressor import features, full_model_weight
from hefting.spatial import Array

Model = Literal["full", "reduced", "blended"]
MODELS: dict[str, str] = {
    "full": "Newton-Euler",
    "reduced": "gravity only: mass and centre of mass",
    "blended": "by the motion's dynamism: w = tanh(3 nu / c1) of the full model, 1 - w of the reduced",
}


@dataclass(frozen=True, eq=False)
class Blend:
    """Moments of the samples with their equations scaled by 1 - w for the reduced model and by w for the full one.

    This is the state of every estimator: w is 1 throughout for those that know the full model only.
    """

    reduced: Moments
    full: Moments

    @classmethod
    def empty(cls) -> Self:
        """No samples yet."""
        return cls(Moments.empty(), Moments.empty())

    @classmethod
    def of(cls, measurements: Measurements, weight: Array | float = 1.0) -> Self:
        """Of `measurements` alone."""
        return cls.empty().fold(measurements, weight)

    def fold(self, measurements: Measurements, weight: Array | float = 1.0) -> Self:
        """With the samples of `measurements` added; `weight` w (K,) is the full model's share, or one for all."""
        x, time = features(measurements), measurements.time
        if np.ndim(weight) == 0 and weight in (0.0, 1.0):
            if weight:
                return type(self)(self.reduced, self.full.fold_features(x, time))
            return type(self)(self.reduced.fold_features(x, time), self.full)
        w = np.broadcast_to(np.asarray(weight, dtype=float), time.shape)
        return type(self)(self.reduced.fold_features(x, time, 1.0 - w), self.full.fold_features(x, time, w))

    def merge(self, other: "Blend") -> Self:
        """Of the samples of both."""
        return type(self)(self.reduced.merge(other.reduced), self.full.merge(other.full))

    @property
    def samples(self) -> int:
        """Samples seen."""
        return max(self.reduced.samples, self.full.samples)

    @property
    def duration(self) -> float:
        """Time between the first and the last sample [s]."""
        return max(self.reduced.duration, self.full.duration)


def model_weight(measurements: Measurements, model: str, c1: float) -> Array | float:
    """Share w of the full model: 1, 0, or (K,) by the samples' dynamism (Nadeau et al. 2022, eq. 11)."""
    return full_model_weight(measurements, c1) if model == "blended" else float(model == "full")


def require_model(model: str, c1: float) -> None:
    """`InputError` unless `model` names a model of the motion and c1 is positive and finite."""
    if model not in MODELS:
        raise InputError(f"unknown model '{model}'", fix=f"use {', '.join(MODELS)}")
    if not 0.0 < c1 < np.inf:
        raise InputError(f"c1 must be positive and finite, not {c1}")

"""States of several recordings, or sensors.

A `JointState` is of several recordings of one object, each with a wrench bias of its own.
Its parts are the states of the recordings, whole. What depends on the bias is
eliminated when an estimate is made, in closed form on the triangular factors: those of
one recording's equations are

    [C B b; 0 A a]    of the columns [bias | ten parameters | wrench],

and whatever the parameters phi, the bias beta = C^-1 (b - B phi) fulfils the first six
rows. The last rows [A a] of all recordings stand below one another, and are
triangularised again.

A `WhitenedState` is what is known of the ten parameters as equations of unit noise,
whatever sensor they came from. Offsets, frictions and whatever else was unknown are
eliminated, and the noise was found beforehand: A phi = b + e, e of unit variance, holds
all that is left. Equations of several sensors simply stand below one another.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property, reduce
from typing import NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements
from hefting.core.moments import Moments, triangular
from hefting.core.spatial import Array, frozen, immutable
from hefting.estimators.raw_motion import NO_ROUGHNESS
from hefting.estimators.sample_state import SampleState
from hefting.estimators.time_record import TimeRecord

_MASS_LAST = np.array((*range(1, 10), 0, 10))


@immutable
class WhitenedState:
    """Equations of the ten parameters with unit noise.

    It is a state of the estimators that take the parameters' equations alone (`Bayes`,
    `GEO`, `LMI`, `OLS`, `PMD`), with ``bias="none"``.
    """

    factor: Array
    """(11, 11) triangular [A | b]"""
    samples: int
    """Number of samples they were made from."""
    duration: float
    """Time between the first and the last of them [s]."""
    noise: float = 1.0
    """Standard deviation [N or N m] by which a typical equation was divided; methods
    that weigh residuals against something else multiply by it."""

    def __post_init__(self):
        factor = frozen(self.factor)
        if factor.shape != (11, 11) or not np.isfinite(factor).all():
            raise InputError(
                f"equations of ten parameters are a finite factor (11, 11), not "
                f"{factor.shape}"
            )
        object.__setattr__(self, "factor", factor)

    @classmethod
    def of_information(
        cls,
        precision: ArrayLike,
        shift: ArrayLike,
        samples: int,
        duration: float,
        noise: float = 1.0,
    ) -> Self:
        """From a Gaussian likelihood exp(-½ phi' precision phi + shift' phi) with
        precision (10, 10) and shift (10,). Combinations of parameters without
        information have zero equations."""
        P = np.asarray(precision, dtype=float)
        scale = np.sqrt(np.maximum(P.diagonal(), 0.0))
        scale[scale <= 1e-13 * scale.max(initial=0.0)] = np.inf
        values, vectors = np.linalg.eigh(P / np.outer(scale, scale))
        kept = values > 1e-12 * values[-1]
        unit = vectors[:, kept] / np.sqrt(values[kept])
        right = unit.T @ (np.asarray(shift, dtype=float) / scale)
        finite = np.where(np.isfinite(scale), scale, 0.0)
        left = (vectors[:, kept] * np.sqrt(values[kept])).T * finite
        rows = np.column_stack((left, right))
        return cls(triangular(rows), samples, duration, noise)

    def stacked(self, other: WhitenedState) -> Self:
        """With an independent sensor's equations, of the same object and frame."""
        return type(self)(
            triangular(np.vstack((self.factor, other.factor))),
            self.samples + other.samples,
            max(self.duration, other.duration),
            self.noise,
        )

    @property
    def is_empty(self) -> bool:
        """Whether no sample was seen."""
        return self.samples == 0

    @cached_property
    def mass_last(self) -> Array:
        """(10, 11) equivalent equations, of which the last contains only the mass."""
        return triangular(self.factor[:, _MASS_LAST])[:10, np.argsort(_MASS_LAST)]

    def fold(self, measurements: Measurements, weight: Array | float = 1.0) -> NoReturn:
        """Raises `InputError`: no samples can be added to whitened equations."""
        what = "the noise of these equations was found already"
        raise InputError(what, fix="fold samples into the moments they came from")


@immutable
class JointState:
    """States of two or more recordings of the same object, sensor and frame."""

    states: tuple[SampleState, ...]

    @property
    def samples(self) -> int:
        """Samples seen in all recordings."""
        return sum(state.samples for state in self.states)

    @property
    def duration(self) -> float:
        """Sum of the time between first and last sample of each recording [s]."""
        return sum(state.duration for state in self.states)

    @cached_property
    def as_one(self) -> SampleState:
        """State of all samples as of one recording, with a common bias or none."""
        return reduce(lambda a, b: a.merge(b, one_bias=True), self.states)

    def fold(self, measurements: Measurements, weight: Array | float = 1.0) -> NoReturn:
        """Raises `InputError`: samples belong to one recording."""
        fix = "update the state of each recording, then merge them"
        raise InputError("the state is that of several recordings", fix=fix)


State = SampleState | JointState | WhitenedState
"""State of an estimator."""


def join(first: State, second: State) -> State:
    """State of the recordings of both, each with its own bias."""
    return join_all((first, second))


def join_all(states: Iterable[State]) -> State:
    """State of all recordings, each with its own bias."""
    every = tuple(each for state in states for each in states_of(state))
    every = tuple(state for state in every if not state.is_empty) or every[:1]
    return every[0] if len(every) == 1 else JointState(every)


def states_of(state: State) -> tuple[SampleState, ...]:
    """State of each recording. Raises `InputError` for equations without a wrench."""
    if isinstance(state, WhitenedState):
        raise _no_wrench()
    return state.states if isinstance(state, JointState) else (state,)


def as_one(state: State) -> SampleState:
    """State of all samples, with a common bias or none. Raises `InputError` for
    equations without a wrench."""
    if isinstance(state, WhitenedState):
        raise _no_wrench()
    return state.as_one if isinstance(state, JointState) else state


def states_by_bias(state: State, free_bias: bool) -> tuple[SampleState, ...]:
    """States each of which has its own bias: of each recording, or without a free bias
    of all samples."""
    return states_of(state) if free_bias else (as_one(state),)


def full_without_bias(state: State) -> Moments:
    """Moments of the full model, with the bias of each recording eliminated."""
    return reduce(
        Moments.merge, (each.full.without_bias() for each in states_of(state))
    )


def motion_record(state: State) -> TimeRecord | None:
    """Time record from which the errors of the motion in all recordings follow; None if
    a state has none."""
    if isinstance(state, WhitenedState):
        return None
    records = [each.record for each in states_of(state)]
    kept = [record for record in records if record is not None]
    if len(kept) < len(records):
        return None
    if len(kept) == 1:
        return kept[0]
    motions = [record.motion for record in kept]
    return TimeRecord(
        motion=tuple(map(sum, zip(*motions, strict=True))),
        rough=sum((record.rough_whole for record in kept), NO_ROUGHNESS),
    )


def _no_wrench() -> InputError:
    fix = "stack them (`WhitenedState.stacked`), and use Bayes, GEO, LMI, OLS or PMD"
    return InputError("these equations have no samples of a wrench left", fix=fix)

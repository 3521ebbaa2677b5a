"""JointState: several recordings of one object, each with a wrench bias of its own.

Its parts are the states of the recordings, whole. What depends on the bias is
eliminated when an estimate is made, in closed form on the triangular factors: those of
one recording's equations are

    [C B b; 0 A a]    of the columns [bias | ten parameters | wrench],

and whatever the parameters phi, the bias beta = C^-1 (b - B phi) fulfils the first six
rows. The last rows [A a] of all recordings stand below one another, and are
triangularised again.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import NoReturn

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements
from hefting.core.moments import Moments
from hefting.core.spatial import Array
from hefting.estimators.raw_motion import NO_ROUGHNESS
from hefting.estimators.sample_state import SampleState
from hefting.estimators.time_record import TimeRecord
from hefting.estimators.whitened_state import WhitenedState


@dataclass(frozen=True, eq=False)
class JointState:
    """States of two or more recordings; of the same object, sensor frame and sensor."""

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
        """All samples as of one recording with one bias, or none."""
        return reduce(lambda a, b: a.merge(b, one_bias=True), self.states)

    def fold(self, measurements: Measurements, weight: Array | float = 1.0) -> NoReturn:
        """Raises `InputError`: samples belong to one recording."""
        raise InputError(
            "the state is that of several recordings",
            fix="update the state of each recording, then merge them",
        )


State = SampleState | JointState | WhitenedState
"""What an estimator has seen."""


def join(first: State, second: State) -> State:
    """State of the recordings of both, each with a bias of its own."""
    return join_all((first, second))


def join_all(states: Iterable[State]) -> State:
    """State of all recordings, each with a bias of its own."""
    every = tuple(each for state in states for each in states_of(state))
    every = tuple(state for state in every if not state.is_empty) or every[:1]
    return every[0] if len(every) == 1 else JointState(every)


def states_of(state: State) -> tuple[SampleState, ...]:
    """State of each recording. Raises `InputError` for equations without a wrench."""
    if isinstance(state, WhitenedState):
        raise _no_wrench()
    return state.states if isinstance(state, JointState) else (state,)


def as_one(state: State) -> SampleState:
    """The state of all samples, their bias taken for the same or none. Raises
    `InputError` for equations without a wrench."""
    if isinstance(state, WhitenedState):
        raise _no_wrench()
    return state.as_one if isinstance(state, JointState) else state


def states_by_bias(state: State, free_bias: bool) -> tuple[SampleState, ...]:
    """States each of which has a bias of its own: those of the recordings; without a
    free bias the one of all samples."""
    return states_of(state) if free_bias else (as_one(state),)


def full_without_bias(state: State) -> Moments:
    """Moments of the full model, the bias of each recording taken out."""
    return reduce(
        Moments.merge, (each.full.without_bias() for each in states_of(state))
    )


def motion_record(state: State) -> TimeRecord | None:
    """Time record that tells the errors of the motion in all recordings; None where a
    state has none."""
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
    return InputError(
        "these equations have no samples of a wrench left",
        fix="stack them (`WhitenedState.stacked`), and use Bayes, GEO, LMI, OLS or PMD",
    )

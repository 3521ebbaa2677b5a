"""The contract of an estimator.

An estimator is a frozen dataclass whose fields are its hyperparameters. Its state is an explicit value:

    state = estimator.start()
    state = estimator.update(state, measurements)    # any number of samples, as often as wanted
    estimate = estimator.estimate(state)             # any time; cost independent of the samples seen
    estimate = estimator.fit(measurements)           # all three
    state = estimator.merge(state_a, state_b)        # samples seen apart, by time or by machine
"""

from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

from hefting.errors import InputError, NotIdentifiableError
from hefting.estimate import Estimate
from hefting.measurements import Measurements

State = TypeVar("State")
BiasModel = Literal["none", "estimate"]


@dataclass(frozen=True)
class Estimator(Generic[State]):
    """Base of all estimators; a method implements `start`, `update`, `merge` and `estimate`."""

    @property
    def name(self) -> str:
        """The method's name, as the command line spells it."""
        return type(self).__name__

    def start(self) -> State:
        """The state before any sample."""
        raise NotImplementedError

    def update(self, state: State, measurements: Measurements) -> State:
        """The state with the samples of `measurements` added."""
        raise NotImplementedError

    def merge(self, first: State, second: State) -> State:
        """The state of an estimator that has seen the samples of both."""
        raise NotImplementedError

    def estimate(self, state: State) -> Estimate:
        """The estimate from the samples seen. Raises `NotIdentifiableError` when there are none."""
        raise NotImplementedError

    def fit(self, measurements: Measurements) -> Estimate:
        """The estimate from `measurements` alone."""
        return self.estimate(self.update(self.start(), measurements))


def require_samples(count: int) -> None:
    """`NotIdentifiableError` unless there is at least one sample."""
    if count == 0:
        raise NotIdentifiableError("no samples to estimate from", fix="record at least one pose with its wrench")


def require_bias_model(bias: str) -> None:
    """`InputError` unless `bias` names a bias model."""
    if not isinstance(bias, str) or bias not in ("none", "estimate"):
        raise InputError(f"unknown bias model '{bias}'", fix="use 'none' or 'estimate'")

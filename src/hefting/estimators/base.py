"""The contract of an estimator.

An estimator is a frozen dataclass whose fields are its hyperparameters. Its state is an explicit value:

    state = estimator.start()
    state = estimator.update(state, measurements)    # any number of samples, as often as wanted
    estimate = estimator.estimate(state)             # any time; cost independent of the samples seen
    estimate = estimator.fit(measurements)           # all three
    state = estimator.merge(state_a, state_b)        # samples seen apart, by time or by machine
"""

from dataclasses import dataclass
from typing import ClassVar, Literal

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.spatial import Array
from hefting.estimators.sample_state import SampleState

BiasModel = Literal["none", "estimate"]
Needs = Literal["nothing", "a bounding box", "a shape", "labelled parts"]

INVARIANCES = {
    "world frame": "another world frame",
    "sample order": "the samples in another order",
    "merging": "samples seen apart and merged",
    "sensor rotation": "another orientation of the sensor's axes",
    "sensor origin": "another point of reference, the noise covariance moved along",
    "units": "other units of length, mass and time, the noise covariance converted along",
    "wrench scale": "a wrench (and its noise) so many times as large: a body so many times as heavy",
}
"""What an estimator may be indifferent to: the estimate is the same body."""


@dataclass(frozen=True, eq=False)
class Estimator:
    """Base of all estimators; a method implements `estimate`, and `weight` if it uses the reduced model."""

    needs: ClassVar[Needs] = "nothing"
    """What the method must know of the object beforehand."""
    consistent: ClassVar[bool] = False
    """Whether every estimate of a positive mass is a body that can exist."""
    invariances: ClassVar[frozenset[str]] = frozenset()
    """Which of `INVARIANCES` hold where the motion determines all ten parameters and, for some, the noise is known: the
    class's docstring says when."""
    keeps_time_record: ClassVar[bool] = False
    """Whether its state keeps how the samples followed one another (`TimeRecord`), to judge their noise."""
    depends_on_count: ClassVar[bool] = False
    """Whether twice as many of the same samples would change the estimate: averages then weigh as many as they are."""
    source: ClassVar[str] = ""
    """Where the method was published."""
    best_for: ClassVar[str] = ""
    """When to think of it first."""

    @property
    def name(self) -> str:
        """The method's name, as the command line spells it; with the model, where that is not its own."""
        name, model = type(self).__name__, getattr(self, "model", None)
        return name if model == getattr(type(self), "model", None) else f"{name}-{model}"

    def start(self) -> SampleState:
        """The state before any sample."""
        return SampleState.empty(self.keeps_time_record)

    def weight(self, measurements: Measurements) -> Array | float:
        """Share w of the full model in each sample (K,), or one number for all."""
        return 1.0

    def update(self, state: SampleState, measurements: Measurements) -> SampleState:
        """The state with the samples of `measurements` added."""
        return state.fold(measurements, self.weight(measurements))

    def merge(self, first: SampleState, second: SampleState) -> SampleState:
        """The state of an estimator that has seen the samples of both."""
        return first.merge(second)

    def estimate(self, state: SampleState) -> Estimate:
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

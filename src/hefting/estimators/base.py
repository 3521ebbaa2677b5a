"""The contract of an estimator.

An estimator is a frozen dataclass whose fields are its hyperparameters. Its state is an
explicit value:

    state = estimator.start()
    state = estimator.update(state, measurements)    # any number of samples, as often as wanted
    estimate = estimator.estimate(state)             # any time; cost independent of the samples seen
    estimate = estimator.fit(measurements)           # all three
    state = estimator.merge(state_a, state_b)        # samples of two recordings
    state = estimator.merge(part_a, part_b, one_bias=True)   # of two parts of one

What the rest of the library must know of a method, the class declares here: a new one
is a file, and its line in `hefting.estimators.methods`. Some fields have the same
meaning in every method that has them: `bias` (all have it), `noise` of the wrench,
`shape`, and `model` with `c1`. A field with the metadata ``help`` (and, if wanted,
``metavar``) is a number that users may give, and an option of ``hefting identify``:

    stiffness: float = field(default=2.0, metadata={"help": "pull to the mean; default
    2"})
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import reduce
from typing import Any, ClassVar, Literal

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.quantity import MassReading
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array, immutable
from hefting.estimators.joint_state import State, as_one, join, join_all
from hefting.estimators.quadratic import whitening
from hefting.estimators.sample_state import (
    SampleState,
    model_weight,
    require_carried,
    require_common_covariance,
    require_model,
)
from hefting.shapes import Shape

BiasModel = Literal["none", "estimate"]
Needs = Literal["nothing", "a bounding box", "a shape", "labelled parts"]
Role = Literal["posterior", "prior", "shape", "free", "none"]

ROLES: dict[Role, str] = {
    "posterior": "knows how sure it is: the one to trust where it explains the wrench",
    "prior": "keeps to the shape where the recording leaves something open",
    "shape": "rests on the shape: for recordings too poor to do without",
    "free": "does without the shape: for recordings that suffice alone, or contradict it",
    "none": "recommended where there is no other",
}
"""What a method may be recommended for, see `hefting.identification.compare`."""

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


@immutable
class Known:
    """Facts about a recording and its object from which hyperparameters follow."""

    bias: BiasModel
    """Whether a constant bias is to be found with the object."""
    noise: Noise
    """Of the wrench, by the residuals of least squares."""
    motion_noise: MotionNoise | None
    """Of the accelerations, where they were found from noisy poses."""
    smoothed: bool
    """Whether the motion comes from poses smoothed over the whole recording."""
    systematic: Array | None
    """(10, 10) covariance of an error in the parameters that is the same for all
    samples; None where there is none."""
    carried: Array | None
    """(10,) parameters of a tool whose wrench was subtracted; None where there is
    none."""
    shape: Shape | None
    """Where the object may have mass, if that is known."""


@dataclass(frozen=True, eq=False)
class Estimator:
    """Base of all estimators: a method implements `estimate`, and overrides the
    declarations that differ."""

    needs: ClassVar[Needs] = "nothing"
    """What the method must know of the object beforehand."""
    instead_of_shape: ClassVar[tuple[str, ...]] = ()
    """Hyperparameters each of which replaces the shape if it is given."""
    takes_shape: ClassVar[Mapping[str, Needs]] = {}
    """Hyperparameters that may be ``"shape"``, the known shape, and what it must be."""
    assumes: ClassVar[str] = "the shape"
    """What decides the parameters that the motion leaves open, in words, if the method
    needs a shape."""
    fills_in: ClassVar[str] = "the method"
    """What decides the parameters that neither motion nor shape determines, in
    words."""
    consistent: ClassVar[bool] = False
    """Whether every estimate of a positive mass is a body that can exist."""
    gives_covariance: ClassVar[bool] = False
    """Whether its estimates have a covariance."""
    invariances: ClassVar[frozenset[str]] = frozenset()
    """Which of `INVARIANCES` hold if the motion determines all ten parameters and, for
    some, the noise is known; the class's docstring says when."""
    keeps_time_record: ClassVar[bool] = False
    """Whether its state keeps a `TimeRecord`, from which the colour of the noise is
    found."""
    depends_on_count: ClassVar[bool] = False
    """Whether the number of samples matters, so averages are weighted by theirs."""
    source: ClassVar[str] = ""
    """Where the method was published."""
    best_for: ClassVar[str] = ""
    """The case for which it is recommended, in words."""
    rank: ClassVar[int] = 1000
    """Order among the methods. The first is the default; without a shape it is the
    first that needs nothing."""
    role: ClassVar[Role] = "none"
    """What it may be recommended for, see `ROLES`; of several methods with a role the
    first by rank."""
    variants: ClassVar[Mapping[str, Mapping[str, Any]]] = {}
    """Hyperparameters of its variants, by the ending of their names: another `model` of
    the motion, or one more condition."""
    when_smoothed: ClassVar[Mapping[str, Any]] = {}
    """Hyperparameters that differ from their defaults with smoothed poses."""

    def __post_init__(self):
        """Check the hyperparameters that several methods have. Raises `InputError`."""
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        if "bias" in own:
            require_bias_model(own["bias"])
        if "model" in own:
            require_model(own["model"], own["c1"])
        whitening(own.get("noise"))
        needed = self.needs != "nothing" and not self.instead_of_shape
        if "shape" in own and (needed or own["shape"] is not None):
            require_shape(own["shape"])

    @property
    def name(self) -> str:
        """The method's name on the command line; with the model if not the default."""
        name, model = type(self).__name__, getattr(self, "model", None)
        return (
            name if model == getattr(type(self), "model", None) else f"{name}-{model}"
        )

    @classmethod
    def hyperparameters(cls, model: str | None = None) -> list[str]:
        """Names of its hyperparameters; `c1` only for the blended model, which `model`
        or the default may be."""
        blended = (model or getattr(cls, "model", None)) == "blended"
        return [field.name for field in fields(cls) if field.name != "c1" or blended]

    @classmethod
    def settings(cls, known: Known, model: str | None = None) -> dict[str, Any]:
        """Hyperparameters that follow from known facts, for `model` or the default."""
        found = {
            "shape": known.shape,
            "noise": known.noise,
            **(cls.when_smoothed if known.smoothed else {}),
        }
        names = cls.hyperparameters(model)
        return {"bias": known.bias} | {
            name: value for name, value in found.items() if name in names
        }

    @property
    def provenance(self) -> dict[str, Any]:
        """Plain values of the hyperparameters, for an estimate's provenance."""
        names = self.hyperparameters(getattr(self, "model", None))
        values = {name: getattr(self, name) for name in names if name != "bias"}
        return {
            name: value
            for name, value in values.items()
            if isinstance(value, int | float | str | tuple)
        }

    @property
    def rests_on_shape(self) -> bool:
        """Whether a known shape determines what the motion leaves open."""
        own = getattr(self, "shape", None)
        known = isinstance(own, Shape) and own.known != "reach"
        return known or self.needs != "nothing"

    @property
    def asked(self) -> Accuracy | None:
        """Accuracy at which to stop using more of a recording; None: use all of it."""
        return None

    def start(self) -> SampleState:
        """The state before any sample."""
        return SampleState.empty(self.keeps_time_record)

    def weight(self, measurements: Measurements) -> Array | float:
        """Share w of the full model in each sample (K,), or one for all, from `model`
        and `c1`."""
        model = getattr(self, "model", "full")
        return model_weight(measurements, model, getattr(self, "c1", 0.0))

    @property
    def sampling(self) -> tuple[Any, ...] | None:
        """Key of the states that `update` makes: methods with equal keys can share a
        state. None if `update` or `weight` is the method's own."""
        kind = type(self)
        if kind.update is not Estimator.update or kind.weight is not Estimator.weight:
            return None
        model = getattr(self, "model", "full")
        return (model, getattr(self, "c1", 0.0)) if model == "blended" else (model,)

    def update(self, state: SampleState, measurements: Measurements) -> SampleState:
        """The state with the samples of `measurements` added."""
        return state.fold(measurements, self.weight(measurements))

    def merge(self, first: State, second: State, *, one_bias: bool = False) -> State:
        """The state of an estimator that has seen the samples of both.

        Where a bias is estimated, each recording has its own; `one_bias` says that the
        two are parts of one recording, seen apart by time or by machine. Raises
        `InputError` where that is said of several recordings.
        """
        if getattr(self, "bias", "none") == "none":
            return as_one(first).merge(as_one(second), one_bias=True)
        if not one_bias:
            return join(first, second)
        if not (isinstance(first, SampleState) and isinstance(second, SampleState)):
            what = "a state of several recordings has more than one bias"
            fix = "merge the parts of one recording before others join it"
            raise InputError(what, fix=fix)
        return first.merge(second, one_bias=True)

    def merge_all(self, states: Sequence[State]) -> State:
        """The state of an estimator that has seen all recordings, as by `merge`."""
        merges = type(self).merge is not Estimator.merge
        if getattr(self, "bias", "none") == "estimate" and not merges:
            return join_all(states)
        return reduce(self.merge, states)

    def estimate(self, state: State) -> Estimate:
        """The estimate from the samples seen; `NotIdentifiableError` without any."""
        raise NotImplementedError

    def continued(self, state: Any, before: Any) -> tuple[Estimate, Any]:
        """The estimate, and a value that may be passed as `before` with more samples to
        save time, or None. `before` may also be an earlier estimate over the same
        shape."""
        return self.estimate(state), None

    def prepared(self, state: Any, before: Any) -> Any:
        """The value that `continued` returns for later ones, without the estimate."""
        return self.continued(state, before)[1]

    def of_more(self, state: Any, prepared: Any) -> tuple[Estimate, Any]:
        """A quick estimate from a state with some more samples than the one for which
        `prepared` was made, and the value to pass as `prepared` next."""
        return self.continued(state, prepared)

    def prior_intervals(self, mass: float) -> dict[str, Array] | None:
        """Intervals, as in `Estimate.intervals`, of a body of a given mass [kg] before
        any sample; None for methods without such a prior."""
        return None

    def fit(self, measurements: Measurements) -> Estimate:
        """The estimate from `measurements` alone."""
        return self.estimate(self.update(self.start(), measurements))


def take_errors(method: Any) -> None:
    """Convert and check what methods with intervals know of errors: the sensor's
    accuracy, a scale's reading, what is carried, and the error of all samples."""
    accuracy = SensorAccuracy.of(method.sensor_accuracy)
    object.__setattr__(method, "sensor_accuracy", accuracy)
    object.__setattr__(method, "mass", MassReading.of(method.mass))
    require_carried(method.carried)
    require_common_covariance(method.systematic)


def stated_errors(method: Any) -> dict[str, str]:
    """The sensor's accuracy and scale's reading, as far as given, for a provenance."""
    values = {name: getattr(method, name) for name in ("sensor_accuracy", "mass")}
    return {name: str(value) for name, value in values.items() if value is not None}


def require_samples(count: int) -> None:
    """`NotIdentifiableError` unless there is at least one sample."""
    if count == 0:
        what = "no samples to estimate from"
        raise NotIdentifiableError(what, fix="record at least one pose with its wrench")


def require_bias_model(bias: str) -> None:
    """`InputError` unless `bias` names a bias model."""
    if not isinstance(bias, str) or bias not in ("none", "estimate"):
        raise InputError(f"unknown bias model '{bias}'", fix="use 'none' or 'estimate'")


def require_shape(shape: object) -> None:
    """`InputError` unless `shape` is a `Shape`."""
    if not isinstance(shape, Shape):
        raise InputError(
            "the shape must be a Shape", fix="use Shape(positions) or load_shape(file)"
        )

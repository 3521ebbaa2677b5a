"""Viewer: object, wrench and arm along a recording, identified up to any instant of it.

    session = Session(found, shape)
    answer = session.answer(2.5, Settings("PMD", {"c1": 10.0}))

Session and playback are plain data. What draws them needs viser.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from threading import Lock
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.immutable import immutable
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array, Indices
from hefting.estimators import METHODS, Estimator, default_method, method_named, spelled
from hefting.identification.convergence import estimate_until
from hefting.identification.estimator import estimator_for
from hefting.ingest.ingested import Ingested
from hefting.ingest.plausibility import require_object
from hefting.scene import Headline, Scene, headline_of, scene_of
from hefting.shapes import Shape

__all__ = ["Answer", "Frame", "Playback", "Session", "Settings"]

MOST_FRAMES = 1_200
"""Instants that are drawn at most, evenly chosen: a minute of 20 a second."""
RATE = 20.0
"""Instants a second that are drawn at most."""
MOST_ANSWERS = 500
"""Answers that are kept, so that going back in time costs nothing."""


@immutable
class Frame:
    """An instant of a recording."""

    sample: int
    """Index of the sample of the measurements"""
    time: float
    """[s] since the first sample; of static poses their number, from 1"""
    position: Array
    """(3,) of the sensor in the world [m]; zero where the log does not tell it"""
    orientation: Array
    """(4,) x, y, z, w, of the sensor in the world"""
    measured: Array
    """(6,) wrench on the object in sensor axes [N, N m], with the bias"""


class Playback:
    """A recording as it is played, of `len` frames, the last one at the last sample: as
    read, with the sensor's poses, and as conditioned, whose samples are those that are
    played."""

    def __init__(self, recording: Recording, found: Ingested):
        self.recording, self.found = recording, found
        self.static = found.static
        self.samples = _chosen(found)

    def __len__(self) -> int:
        return len(self.samples)

    @cached_property
    def instants(self) -> Array:
        """(N,) times of the frames on the clock of the measurements [s]."""
        return self.found.measurements.time[self.samples]

    @cached_property
    def times(self) -> Array:
        """(N,) the same since the first sample [s]; of static poses their number, from
        1."""
        if self.static:
            return self.instants + 1.0
        return self.instants - self.found.measurements.time[0]

    def __getitem__(self, index: int) -> Frame:
        sample = int(self.samples[index])
        position, orientation = self.poses
        return Frame(
            sample,
            float(self.times[index]),
            position[index],
            orientation[index],
            self.found.measurements.wrench[sample],
        )

    def instant(self, time: float) -> float:
        """A time as those of `times` on the clock of the measurements [s]."""
        start = -1.0 if self.static else float(self.found.measurements.time[0])
        return start + time

    def nearest(self, time: float) -> int:
        """Index of the frame nearest to a time of `times`."""
        return int(np.argmin(np.abs(self.times - time)))

    @cached_property
    def poses(self) -> tuple[Array, Array]:
        """Position (N, 3) [m] and orientation (N, 4) of the sensor at each frame, those
        that were logged nearest to it."""
        turned = self.at("orientation")
        place = self.at("position")
        return np.zeros((len(self), 3)) if place is None else place, turned  # type: ignore[return-value]

    def at(self, name: str) -> Array | None:
        """Values (N, d) of a stream logged nearest to each frame; None where there is
        no such stream."""
        if not self.recording.has(name):
            return None
        stream = self.recording[name]
        return stream.values[_nearest(stream, self.instants)]

    def bias(self, estimate: Estimate | None) -> Array:
        """(6,) bias of the wrench that an estimate found [N, N m]; zero where it found
        none."""
        known = None if estimate is None else estimate.common_bias
        return np.zeros(6) if known is None else known

    def predicted(self, estimate: Estimate, sample: int) -> Array:
        """(6,) wrench [N, N m] that the object needs at a sample, without bias."""
        z = self.found.measurements[sample : sample + 1]
        return predict_wrench(z, estimate.sensed_vector)[0]

    @cached_property
    def largest(self) -> Array:
        """(2,) largest force [N] and torque [N m] of the measured wrench less a
        constant bias that least squares found."""
        bias = self.found.fit.bias
        wrench = self.found.measurements.wrench - (0.0 if bias is None else bias)
        sizes = np.linalg.norm(wrench.reshape(-1, 2, 3), axis=2).max(axis=0)
        return np.maximum(sizes, 1e-9)


def _chosen(found: Ingested) -> Indices:
    count = len(found.measurements)
    most = MOST_FRAMES
    if not found.static:
        most = min(most, 2 + int(RATE * float(np.ptp(found.measurements.time))))
    chosen = np.linspace(0, count - 1, max(1, min(count, most)))
    return np.unique(chosen.round().astype(np.intp))


def _nearest(stream: Stream, instants: Array) -> Indices:
    time = stream.time
    after = np.clip(np.searchsorted(time, instants), 1, max(len(time) - 1, 1))
    after = np.minimum(after, len(time) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(instants - time[before] <= time[after] - instants, before, after)


@dataclass(frozen=True)
class Settings:
    """A method, and hyperparameters that were set by hand."""

    method: str
    """Name of a method, of a variant, or of an estimate that was given"""
    hyperparameters: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """By name; those that the method does not have are left out"""

    @property
    def key(self) -> tuple[Any, ...]:
        """What tells these settings from others."""
        return self.method, tuple(sorted(self.hyperparameters.items()))


@immutable
class Answer:
    """What is known of the object at an instant."""

    estimate: Estimate | None
    """None where there is none"""
    scene: Scene
    """What is to be drawn, in sensor axes"""
    refusal: str = ""
    """Why there is no estimate"""

    @property
    def headline(self) -> Headline | None:
        """Verdict and numbers."""
        return None if self.estimate is None else headline_of(self.estimate)


class Session:
    """A recording that was read and conditioned, and what methods find from it.

    `shape` is where the object may have mass, in the sensor frame; `hyperparameters`
    are values by name, for methods that have them, where `Settings` say nothing else;
    `given` are estimates made elsewhere, by the names that they are to have among the
    methods; the `truth` is drawn beside the estimate. Raises `InputError` if the
    recording determines no object.
    """

    def __init__(
        self,
        found: Ingested,
        shape: Shape | None = None,
        hyperparameters: Mapping[str, Any] | None = None,
        given: Mapping[str, Estimate] | None = None,
        truth: InertialParameters | None = None,
    ):
        require_object(found, shape)
        self.found, self.shape, self.truth = found, shape, truth
        self.given = dict(given or {})
        self._fixed = dict(hyperparameters or {})
        self._answers: dict[tuple[Any, ...], Answer] = {}
        self._estimators: dict[tuple[Any, ...], Estimator] = {}
        self._lock = Lock()

    @cached_property
    def methods(self) -> tuple[str, ...]:
        """Names of the methods for which enough is known of the object, after those of
        the estimates that were given."""
        return (*self.given, *(name for name in METHODS if self._serves(name)))

    @property
    def default(self) -> Settings:
        """The first estimate that was given; else the method that `hefting.identify`
        would take."""
        name = next(iter(self.given), default_method(self.shape is not None))
        return Settings(name)

    def estimator(self, settings: Settings) -> Estimator:
        """The estimator that `hefting.identify` would use with these settings.

        Raises `InputError` for an unknown method, or a hyperparameter that cannot be.
        """
        name = spelled(settings.method)
        key = settings.key
        if key not in self._estimators:
            kind, own = method_named(name)
            known = set(kind.hyperparameters(own.get("model")))
            chosen = self._fixed | dict(settings.hyperparameters)
            chosen = {k: v for k, v in chosen.items() if k in known and k != "until"}
            made = estimator_for(kind, self.found, self.shape, chosen | own)
            self._estimators[key] = made
        return self._estimators[key]

    def estimate(self, instant: float, settings: Settings) -> Estimate:
        """The estimate from the samples up to an instant [s], see `estimate_until`; one
        that was given does not depend on it. Errors are those of `estimate_until`."""
        if settings.method in self.given:
            return self.given[settings.method]
        estimator = self.estimator(settings)
        return estimate_until(self.found, estimator, self.shape, instant)

    def answer(self, instant: float, settings: Settings) -> Answer:
        """The same with its scene; where there is no estimate, why."""
        key = (float(instant), *settings.key)
        with self._lock:
            known = self._answers.get(key)
            if known is None:
                known = self._answer(instant, settings)
                while len(self._answers) >= MOST_ANSWERS:
                    del self._answers[next(iter(self._answers))]
                self._answers[key] = known
        return known

    def _answer(self, instant: float, settings: Settings) -> Answer:
        try:
            estimate = self.estimate(instant, settings)
        except InputError as error:
            return Answer(None, self.scene(None), str(error))
        return Answer(estimate, self.scene(estimate))

    def scene(self, estimate: Estimate | None) -> Scene:
        """What is drawn of the object, with the masses that a method put at the points
        of the shape."""
        found, known = {"estimate": estimate}, {"truth": self.truth}
        return scene_of(found, self.shape, known, masses=self._has_masses(estimate))

    def _has_masses(self, estimate: Estimate | None) -> bool:
        if estimate is None or estimate.point_masses is None or self.shape is None:
            return False
        return len(estimate.point_masses) == self.shape.n

    def _serves(self, name: str) -> bool:
        needs = METHODS[name].needs
        if needs == "labelled parts":
            return self.shape is not None and self.shape.labels is not None
        return needs == "nothing" or self.shape is not None

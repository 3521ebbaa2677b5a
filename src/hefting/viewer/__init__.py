"""Viewer: object, wrench and arm along a recording, identified up to any instant of it.

    session = Session(found, shape)
    answer = session.answer(2.5, Settings("PMD", {"c1": 10.0}))

Session and playback are plain data. The files that draw them need viser.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from threading import Lock
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array, Indices, immutable
from hefting.estimators import METHODS, Estimator, default_method, method_named, spelled
from hefting.identification.convergence import estimate_until
from hefting.identification.estimator import estimator_for
from hefting.ingest.ingested import Ingested
from hefting.ingest.plausibility import require_object
from hefting.scene import Headline, Scene, headline_of, scene_of
from hefting.shapes import Shape

__all__ = ["Answer", "Frame", "Playback", "Session", "Settings"]

MOST_FRAMES = 1_200
"""Most instants that are drawn, evenly chosen: a minute at `RATE`."""
RATE = 20.0
"""[Hz] Largest rate of drawn instants."""
MOST_ANSWERS = 500
"""Most answers that are cached."""


@immutable
class Frame:
    """An instant of a recording."""

    sample: int
    """Index of the sample of the measurements"""
    time: float
    """[s] since the first sample; the number of a static pose, from 1"""
    position: Array
    """(3,) of the sensor in the world [m]; zero if not logged"""
    orientation: Array
    """(4,) quaternion x, y, z, w of the sensor in the world"""
    measured: Array
    """(6,) wrench on the object in sensor axes [N, N m], with the bias"""


class Playback:
    """A recording as a sequence of N frames, the last one at the last sample. Frames are
    samples of the ingested recording `found`, with poses of the `recording` as read."""

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
        """(N,) times since the first sample [s]; numbers of static poses, from 1."""
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
        """Time on the clock of the measurements [s] of a time of `times`."""
        start = -1.0 if self.static else float(self.found.measurements.time[0])
        return start + time

    def nearest(self, time: float) -> int:
        """Index of the frame nearest to a time of `times`."""
        return int(np.argmin(np.abs(self.times - time)))

    @cached_property
    def poses(self) -> tuple[Array, Array]:
        """Position (N, 3) [m] and orientation (N, 4) of the sensor, as logged nearest to
        each frame."""
        orientation = self.at("orientation")
        position = self.at("position")
        if position is None:
            position = np.zeros((len(self), 3))
        return position, orientation  # type: ignore[return-value]

    def at(self, name: str) -> Array | None:
        """Values (N, d) of a stream nearest to each frame; None without the stream."""
        if not self.recording.has(name):
            return None
        stream = self.recording[name]
        return stream.values[_nearest(stream, self.instants)]

    def bias(self, estimate: Estimate | None) -> Array:
        """(6,) bias of the wrench by an estimate [N, N m], zero if it has none."""
        known = None if estimate is None else estimate.common_bias
        return np.zeros(6) if known is None else known

    def predicted(self, estimate: Estimate, sample: int) -> Array:
        """(6,) predicted wrench [N, N m] at a sample, without bias."""
        z = self.found.measurements[sample : sample + 1]
        return predict_wrench(z, estimate.sensed_vector)[0]

    @cached_property
    def largest(self) -> Array:
        """(2,) largest force [N] and torque [N m] of the measured wrench without the
        constant bias found by least squares."""
        bias = self.found.fit.bias
        wrench = self.found.measurements.wrench - (0.0 if bias is None else bias)
        sizes = np.linalg.norm(wrench.reshape(-1, 2, 3), axis=2).max(axis=0)
        return np.maximum(sizes, 1e-9)


def _chosen(found: Ingested) -> Indices:
    """(N,) evenly chosen samples, within `MOST_FRAMES` and `RATE`."""
    count = len(found.measurements)
    limit = MOST_FRAMES
    if not found.static:
        limit = min(limit, 2 + int(RATE * float(np.ptp(found.measurements.time))))
    chosen = np.linspace(0, count - 1, max(1, min(count, limit)))
    return np.unique(chosen.round().astype(np.intp))


def _nearest(stream: Stream, instants: Array) -> Indices:
    """(N,) rows of a stream nearest in time to the instants (N,) [s]."""
    time = stream.time
    after = np.clip(np.searchsorted(time, instants), 1, max(len(time) - 1, 1))
    after = np.minimum(after, len(time) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(instants - time[before] <= time[after] - instants, before, after)


@dataclass(frozen=True)
class Settings:
    """A method, and hyperparameters set by hand."""

    method: str
    """Name of a method, of a variant, or of a given estimate"""
    hyperparameters: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """By name; those that the method does not have are ignored"""

    @property
    def key(self) -> tuple[Any, ...]:
        """Hashable value of these settings."""
        return self.method, tuple(sorted(self.hyperparameters.items()))


@immutable
class Answer:
    """The estimate at an instant, or why there is none."""

    estimate: Estimate | None
    scene: Scene
    """The object to draw, in sensor axes"""
    refusal: str = ""
    """Reason why there is no estimate"""

    @property
    def headline(self) -> Headline | None:
        """Verdict and numbers."""
        return None if self.estimate is None else headline_of(self.estimate)


class Session:
    """An ingested recording, and estimates of methods from it.

    `shape` is where the object may have mass, in the sensor frame; `hyperparameters` are
    defaults by name, for methods that have them; `given` are estimates made elsewhere,
    listed with the methods by their names here; the `truth` is drawn too. Raises
    `InputError` if the recording determines no object.
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
        """Names of given estimates, then of methods whose needs the shape meets."""
        return (*self.given, *(name for name in METHODS if self._needs_are_met(name)))

    @property
    def default(self) -> Settings:
        """The first given estimate; else the default of `hefting.identify`."""
        name = next(iter(self.given), default_method(self.shape is not None))
        return Settings(name)

    def estimator(self, settings: Settings) -> Estimator:
        """The estimator that `hefting.identify` would use with these settings.

        Raises `InputError` for an unknown method or an invalid hyperparameter.
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
        """The estimate from the samples up to an instant [s], as by `estimate_until`, with
        its errors; a given estimate does not depend on the instant."""
        if settings.method in self.given:
            return self.given[settings.method]
        estimator = self.estimator(settings)
        return estimate_until(self.found, estimator, self.shape, instant)

    def answer(self, instant: float, settings: Settings) -> Answer:
        """The estimate with its scene, or the reason why there is none; cached."""
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
        """The object to draw, with point masses of the estimate at the shape's points."""
        found, known = {"estimate": estimate}, {"truth": self.truth}
        return scene_of(found, self.shape, known, masses=self._has_masses(estimate))

    def _has_masses(self, estimate: Estimate | None) -> bool:
        if estimate is None or estimate.point_masses is None or self.shape is None:
            return False
        return len(estimate.point_masses) == self.shape.n

    def _needs_are_met(self, name: str) -> bool:
        needs = METHODS[name].needs
        if needs == "labelled parts":
            return self.shape is not None and self.shape.labels is not None
        return needs == "nothing" or self.shape is not None

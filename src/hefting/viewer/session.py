"""Session: a recording understood once, and its estimate up to any instant of it by any
method and hyperparameters."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from threading import Lock
from typing import Any

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.estimators import METHODS, Estimator, default_method, method_named, spelled
from hefting.identification.identify import estimator_for
from hefting.identification.instant import estimate_until
from hefting.ingest.ingested import Ingested
from hefting.ingest.plausibility import require_object
from hefting.scene import Headline, Scene, headline_of, scene_of
from hefting.shapes import Shape

MOST_ANSWERS = 500
"""Answers that are kept, so that going back in time costs nothing."""


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


@dataclass(frozen=True, eq=False)
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

    Parameters
    ----------
    found : Ingested
        One recording. Refused where it determines no object.
    shape : Shape, optional
        Where the object may have mass, in the sensor frame.
    hyperparameters : mapping, optional
        Values by name, for methods that have them, where `Settings` say nothing else.
    given : mapping of str to Estimate, optional
        Estimates made elsewhere, by the name that they are to have among the methods.
    truth : InertialParameters, optional
        Drawn beside the estimate.

    Raises
    ------
    InputError
        If the recording determines no object.
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
        found = {} if estimate is None else {"estimate": estimate}
        known = {} if self.truth is None else {"truth": self.truth}
        return scene_of(found, self.shape, known, masses=self._has_masses(estimate))

    def _has_masses(self, estimate: Estimate | None) -> bool:
        """Whether an estimate has a mass for each point of the shape."""
        if estimate is None or estimate.point_masses is None or self.shape is None:
            return False
        return len(estimate.point_masses) == self.shape.n

    def _serves(self, name: str) -> bool:
        """Whether enough is known for a method."""
        needs = METHODS[name].needs
        if needs == "labelled parts":
            return self.shape is not None and self.shape.labels is not None
        return needs == "nothing" or self.shape is not None

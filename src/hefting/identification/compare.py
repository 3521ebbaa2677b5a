"""Comparison: several methods on one recording, and a choice among them without the
truth.

The rule was chosen among several by its error relative to the best method of each case,
on simulated recordings with the right shape, a bounding box, a shape 20 % too large and
one misplaced by 5 mm and 5°, and on grossly wrong shapes. An approximate shape improves
the estimate more than a smaller residual does: noise of the accelerations alone makes
least squares contradict the true body. The data overrule the shape only where they
determine all parameters. In each of the four cases, the Bayesian estimate, where it
explains the wrench, had the smallest median error of COM and inertia.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hefting.core.errors import InputError, NeedError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.progress import each
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.summary import LABEL, body_lines
from hefting.estimators import METHODS, VARIANTS, Estimator, method_named, spelled
from hefting.estimators.base import Role
from hefting.estimators.quadratic import Quadratic
from hefting.identification.checks import with_diagnostics
from hefting.identification.estimator import Method, estimator_of
from hefting.identification.identify import Answer
from hefting.identification.run import run, understand
from hefting.ingest.ingest import Ingested
from hefting.ingest.joint import Log
from hefting.ingest.plausibility import require_object
from hefting.shapes import Shape

MISFIT = 100.0
"""Excess chi² above which an estimate contradicts the recording; it is 10 for the true
parameters and perfect motion."""
PRECISE = 0.1
"""Uncertainty of least squares up to which the recording may overrule the shape."""
SUFFICIENT = 0.2
"""Uncertainty of least squares to which a body without a shape beats point masses."""
LARGER_RESIDUAL = 1.1
"""Ratio of a residual to the least of all methods above which it is mentioned."""
OUTSIDE = 0.02
"""Depth outside the shape's hull, over its largest side, from which the COM contradicts
the shape."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Answer):
    """Estimates of several methods from one recording; attributes of an estimate are
    those of the recommended one.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv", method=["LMI", "OLS"])
    >>> sorted(found.results), found.recommended in found.results
    (['LMI', 'OLS'], True)
    """

    results: dict[str, Estimate]
    """By method; variants are last."""
    seconds: dict[str, float]
    """Time that each took from the measurements [s]."""
    skipped: dict[str, str]
    """Methods that could not be used, with the reasons."""
    recommended: str
    """Name of the method to trust."""
    reason: str
    """Reason for the recommendation."""
    ingested: Ingested
    """The recording, the same for all methods."""
    estimators: dict[str, Estimator] = field(default_factory=dict[str, Estimator])
    """Estimator of each estimate, with all hyperparameters."""
    seen: dict[str, Ingested] = field(default_factory=dict[str, Ingested])
    """The part of the recording that each method used."""

    def __repr__(self) -> str:
        rows = []
        for name, e in self.shown.items():
            body = e.parameters, e.intervals, e.undetermined
            mass, com = (line[LABEL:] for line in body_lines(*body)[:2])
            rows.append(f"  {name:<14} {mass}, COM {com}")
        return "\n".join((super().__repr__(), f"recommended: {self.reason}", *rows))

    @property
    def estimate(self) -> Estimate:
        """The estimate to trust."""
        return self.results[self.recommended]

    @property
    def shown(self) -> dict[str, Estimate]:
        """Results side by side: those asked for, without the variants if all were."""
        is_of_all = set(METHODS) <= {*self.results, *self.skipped}
        if not is_of_all or self.recommended in VARIANTS:
            return self.results
        return {name: e for name, e in self.results.items() if name not in VARIANTS}


def compare(
    recording: Log | Sequence[Log],
    shape: Shape | None = None,
    methods: Sequence[Method] | str = "all",
    *,
    hyperparameters: dict[str, Any] | None = None,
    **reading: Any,
) -> Comparison:
    """Identify the object by several methods from one recording, or from several of it.

    `methods` are names of methods and variants, separated by commas if in one string, of
    which ``"all"`` stands for all that can be used, classes of estimators, or complete
    ones. `hyperparameters`, such as ``c1``, are for those of the others that have them,
    `reading` other arguments of `hefting.identify`. Raises `InputError` for an unknown
    method or hyperparameter, for a named method whose needs are not given, and as
    `hefting.identify` does.
    """
    words = methods.split(",") if isinstance(methods, str) else methods
    named = _by_name(words)
    everything = "all" in (str(word).strip().lower() for word in words)
    wanted = hyperparameters or {}
    given = _hyperparameters_by_method(named, wanted)
    found = understand(recording, wanted.get("sensor_accuracy"), **reading)
    require_object(found, shape)
    results, seconds, skipped, seen, made = {}, {}, {}, {}, {}
    for name, method in each("identifying", list(named.items())):
        try:
            estimator = estimator_of(method, found, shape, given[name])
            start = time.perf_counter()
            estimate, used = run(estimator, found)
            elapsed = time.perf_counter() - start
            results[name] = with_diagnostics(estimate, estimator, used, shape)
            seconds[name], seen[name], made[name] = elapsed, used, estimator
        except (NeedError, NotIdentifiableError) as error:
            if not everything:
                raise
            if name in METHODS:
                skipped[name] = str(error)
    if not results:
        raise InputError(
            "no method could be used", found.log, next(iter(skipped.values()))
        )
    proper = {name: e for name, e in results.items() if name not in VARIANTS}
    recommended, reason = recommend(proper or results, found, shape, seen)
    return Comparison(results, seconds, skipped, recommended, reason, found, made, seen)


def _by_name(methods: Sequence[Method]) -> dict[str, Method]:
    """Methods and variants by their names, which may be in any case; ``"all"`` stands for
    all. Further ones of a name are numbered. `InputError` for an unknown one, and for
    none."""
    pairs: list[tuple[str, Method]] = []
    for method in methods:
        if isinstance(method, type):
            pairs.append((method.__name__, method))
        elif isinstance(method, Estimator):
            pairs.append((method.name, method))
        else:
            word = str(method).strip()
            every = (*METHODS, *VARIANTS)
            names = every if word.lower() == "all" else (spelled(word),)
            pairs += ((name, name) for name in names)
    named: dict[str, Method] = {}
    for name, method in pairs:
        if method not in named.values():
            count = sum(other.partition(" ")[0] == name for other in named)
            named[f"{name} {count + 1}" if count else name] = method
    if not named:
        raise InputError(
            "no method is named", fix=f"use all or some of {', '.join(METHODS)}"
        )
    return named


def _hyperparameters_by_method(
    named: dict[str, Method], wanted: dict[str, Any]
) -> dict[str, dict[str, Any]]:
    """Of the wanted hyperparameters those that each method has, none of a complete
    estimator. `InputError` for one that none has."""
    taken: dict[str, list[str]] = {}
    for name, method in named.items():
        taken[name] = []
        if not isinstance(method, Estimator):
            kind, settings = method_named(method)
            taken[name] = kind.hyperparameters(settings.get("model"))
    for key in wanted:
        if not any(key in known for known in taken.values()):
            raise InputError(f"none of {', '.join(named)} has a '{key}'")
    return {
        name: {key: value for key, value in wanted.items() if key in known}
        for name, known in taken.items()
    }


def misfit(estimate: Estimate, found: Ingested) -> float:
    """Sum of squared residuals above that of unconstrained least squares, in units of
    the noise's variance.

    For the true parameters this is chi² distributed with as many degrees of freedom as
    the data determine parameters, at most ten; the residuals' correlation in time is
    taken into account. If a scale showed a gain of the sensor, or the user gave its
    accuracy, single channels may be wrong by as much: that share of the wrench is no
    misfit.
    """
    problem = Quadratic.of(found.state, found.fit.noise, found.bias == "estimate")
    excess = problem.square(estimate.sensed_vector) - problem.square(
        problem.least_squares()
    )
    gain = abs(float(estimate.provenance.get("sensor_gain", 0.0)))
    if accuracy := estimate.provenance.get("sensor_accuracy"):
        gain = max(gain, SensorAccuracy.parse(accuracy).gain_std)
    explained = problem.A @ estimate.sensed_vector
    excess -= gain**2 * float(explained @ explained)
    return max(0.0, excess) / found.fit.autocorrelation


def uncertainty(found: Ingested, shape: Shape) -> float:
    """Largest relative standard deviation of the ten parameters by unconstrained least
    squares.

    That of the mass is relative to the mass m, that of the first moment to m times the
    size of the shape, that of the inertia to a rod of mass m and that size. Infinite if
    a parameter is undetermined.
    """
    std = np.sqrt(found.fit.covariance.diagonal()[:10])
    size = float(np.linalg.norm(shape.extents))
    scale = abs(found.fit.mass) * np.concatenate(
        ([1.0], np.full(3, size), np.full(6, size**2 / 12.0))
    )
    return float(np.max(std / scale)) if scale.all() else np.inf


def recommend(
    results: dict[str, Estimate],
    found: Ingested,
    shape: Shape | None,
    seen: dict[str, Ingested] | None = None,
) -> tuple[str, str]:
    """Choose an estimate: the name of its method, and a sentence that gives the reason.

    Parameters
    ----------
    results : estimates by method.
    found : the recording as read and conditioned.
    shape : of the object.
    seen : the part of the recording that a method used, by method; by default all of it.
    """
    bodies = {
        name: e
        for name, e in results.items()
        if e.parameters.consistency().is_consistent
    }
    if not bodies:
        why = "no method found a body that can exist; this one explains the wrench best"
        return _closest(results, found), why
    posterior = _first("posterior", bodies)
    if posterior is not None:
        own = (seen or {}).get(posterior, found)
        if not misfit(bodies[posterior], own) <= MISFIT:
            posterior = None
    if shape is not None:
        return _recommend_with_shape(bodies, posterior, found, shape)
    if posterior is not None:
        return posterior, explanation(posterior, bodies)
    free = _first("free", bodies)
    if free is None:
        return _closest(bodies, found), "a body that can exist"
    return free, "the body that explains the wrench best; no shape is known"


def _closest(results: dict[str, Estimate], found: Ingested) -> str:
    return min(results, key=lambda name: misfit(results[name], found))


def _recommend_with_shape(
    bodies: dict[str, Estimate], posterior: str | None, found: Ingested, shape: Shape
) -> tuple[str, str]:
    """As `recommend`, from consistent estimates and a shape; `posterior` is the method of
    that role if it explains the wrench."""
    free, prior = _first("free", bodies), _first("prior", bodies)
    margin = bodies[prior].hull_margin if prior is not None else None
    outside = margin is not None and margin < -OUTSIDE
    if free is not None and (outside or _is_outside(bodies[free], found, shape)):
        why = "without the shape the COM is outside it: check the shape's pose and unit"
        return free, why
    if posterior is not None:
        return posterior, explanation(posterior, bodies)
    s = uncertainty(found, shape)
    if prior is not None:
        if misfit(bodies[prior], found) <= MISFIT:
            why = (
                "it explains the wrench to within the noise and else keeps to the shape"
            )
            return prior, why
        if s > PRECISE or free is None:
            left = f"the recording alone leaves {100 * s:.0f} % open"
            return prior, f"{left}: the shape is worth more than a closer fit"
        return free, "the recording contradicts the shape and suffices alone"
    if free is not None and s < SUFFICIENT:
        known = f"the recording determines all parameters to {100 * s:.0f} %"
        return free, f"{known} of a body of this size"
    if (inside := _first("shape", bodies)) is not None:
        return inside, "the recording is too poor to do without the shape"
    only = "the only body" if len(bodies) == 1 else "a body"
    return next(iter(bodies)), f"{only} that can exist"


def explanation(name: str, bodies: dict[str, Estimate]) -> str:
    """Reason to recommend a posterior, with its residual relative to the least one."""
    own = bodies[name].residual
    others = [e.residual for e in bodies.values() if e.residual is not None]
    ratio = 1.0
    if own is not None and others:
        ratio = float(np.max(own / np.maximum(np.min(others, axis=0), 1e-300)))
    if ratio > LARGER_RESIDUAL:
        return (
            f"it says how sure it is; it leaves {ratio:.1f} times the residual of the "
            f"closest fit, which noise that changes slowly explains"
        )
    return "it explains the wrench to within the noise and says how sure it is"


def _first(role: Role, bodies: dict[str, Estimate]) -> str | None:
    names = (name for name, kind in METHODS.items() if kind.role == role)
    return next((name for name in names if name in bodies), None)


def _is_outside(estimate: Estimate, found: Ingested, shape: Shape) -> bool:
    """Whether a COM estimated without the shape is outside its hull by more than
    `OUTSIDE` and three standard deviations."""
    variance = found.fit.covariance.diagonal()[1:4]
    if estimate.hull_margin is None or not np.isfinite(variance).all():
        return False
    spread = float(np.sqrt(variance.max())) / estimate.parameters.mass
    size = float(shape.extents.max()) or 1.0
    return estimate.hull_margin < -OUTSIDE - 3.0 * spread / size

"""Comparison: several methods on one recording, and which of them to trust."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from hefting.core.errors import InputError, NeedError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.progress import each
from hefting.estimators import METHODS, VARIANTS, Estimator, method_named, spelled
from hefting.identification.diagnostics import with_diagnostics
from hefting.identification.estimator import estimator_for
from hefting.identification.identify import Answer
from hefting.identification.recommend import recommend
from hefting.identification.run import run, understand
from hefting.ingest.ingest import Ingested
from hefting.ingest.plausibility import require_object
from hefting.ingest.several import Log
from hefting.shapes import Shape


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Answer):
    """Estimates of several methods from one recording; at hand are the values of the
    one that is recommended.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv", method=["LMI", "OLS"])
    >>> sorted(found.results), found.recommended in found.results
    (['LMI', 'OLS'], True)
    """

    results: dict[str, Estimate]
    """By method; variants after the methods proper."""
    seconds: dict[str, float]
    """How long each took from the measurements [s]."""
    skipped: dict[str, str]
    """Methods that could not be used, and why."""
    recommended: str
    """Name of the one to trust."""
    reason: str
    """Why that one."""
    ingested: Ingested
    """The recording as all of them took it."""
    estimators: dict[str, Estimator] = field(default_factory=dict[str, Estimator])
    """What made each estimate, with all hyperparameters."""
    seen: dict[str, Ingested] = field(default_factory=dict[str, Ingested])
    """The recording as far as each used it."""

    def __repr__(self) -> str:
        return f"{super().__repr__()}\n  recommended of  {', '.join(self.results)}"

    @property
    def estimate(self) -> Estimate:
        """The estimate to trust."""
        return self.results[self.recommended]


def compare(
    recording: Log | Sequence[Log],
    shape: Shape | None = None,
    methods: Sequence[str] | str = "all",
    *,
    hyperparameters: dict[str, Any] | None = None,
    **reading: Any,
) -> Comparison:
    """Identify the object by several methods from one recording, or from several of it.

    Parameters
    ----------
    methods : names of methods and variants, separated by commas if in one string;
        ``"all"`` stands for all that can be used, variants included.
    hyperparameters : fields of estimators, such as ``c1``, for those that have them.
    reading : gravity, wrench, bias, motion, start, duration as for
        `hefting.identification.identify`.

    Raises `InputError` for an unknown method or hyperparameter, or one named that needs
    what is not given; and as `identify` does.
    """
    if isinstance(methods, str):
        methods = methods.split(",")
    everything = False
    kinds = {}
    for word in methods:
        if word.strip().lower() == "all":
            everything = True
            kinds |= {
                name: method_named(name)
                for name in (*METHODS, *VARIANTS)
                if name not in kinds
            }
            continue
        kind, settings = method_named(word.strip())
        kinds.setdefault(spelled(word.strip()), (kind, settings))
    if not kinds:
        raise InputError(
            "no method is named", fix=f"use all or some of {', '.join(METHODS)}"
        )
    wanted = hyperparameters or {}
    taken = {
        name: kind.hyperparameters(settings.get("model"))
        for name, (kind, settings) in kinds.items()
    }
    for key in wanted:
        if not any(key in known for known in taken.values()):
            raise InputError(f"none of {', '.join(kinds)} has a '{key}'")
    found = understand(recording, **reading)
    require_object(found, shape)
    results, seconds, skipped, seen, made = {}, {}, {}, {}, {}
    for name, (kind, settings) in each("identifying", list(kinds.items())):
        own = {key: value for key, value in wanted.items() if key in taken[name]}
        try:
            estimator = estimator_for(kind, found, shape, own | settings)
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
    proper = {
        name: estimate for name, estimate in results.items() if name not in VARIANTS
    }
    recommended, reason = recommend(proper or results, found, shape, seen)
    return Comparison(results, seconds, skipped, recommended, reason, found, made, seen)

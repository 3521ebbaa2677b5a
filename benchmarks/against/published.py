"""The paper's table of 150 observations, beside its experiment as it is reproduced.

Published figures are cited, not measured: Nadeau, Giamou & Kelly 2022, table III. Ours
are of `hefting.reproduction`: its eight objects in MuJoCo, 1.5 s of noisy poses, the
motion by a causal filter that has run before (*warm*) or begins with them (*cold*).
`docs/reproduction.md` says why the two differ.
"""

from typing import Any

import numpy as np

from benchmarks.accuracy_objects import informed, seen
from benchmarks.against.runs import QUANTITIES, rounded
from hefting.estimators import Bayes
from hefting.reproduction.experiment import (
    DURATION,
    METHODS,
    MOSTLY_WRONG,
    OBJECTS,
    thing,
    wielded,
)
from hefting.reproduction.filtered import Observed
from hefting.reproduction.observations import PUBLISHED
from hefting.simulation import WRENCH_NOISE

SPEEDS = (1.0, 1.5, 2.0)
"""Mean angular speeds [rad/s]."""
SETTINGS = ("warm", "cold")
QUICK = {"objects": ("tee",), "speeds": (1.5,), "duration": 3.6}

Scores = dict[tuple[str, str, float], list[tuple[float, float, float]]]
"""By setting, method and speed: errors [%] of every window."""


def beside(
    objects: tuple[str, ...] = OBJECTS,
    speeds: tuple[float, ...] = SPEEDS,
    duration: float = DURATION,
) -> list[dict[str, Any]]:
    """A row for each method and source, mean errors by quantity and speed."""
    scores: Scores = {}
    for speed in speeds:
        for index, name in enumerate(objects):
            score(scores, name, index, speed, duration)
    return [*cited(speeds), *reproduced(scores, speeds)]


def score(scores: Scores, name: str, index: int, speed: float, duration: float) -> None:
    """Add every window of an object at a speed."""
    subject, exact = thing(name), wielded(name, speed, duration=duration)
    seed = (1, index, round(10 * speed))
    observed = Observed.of(exact, WRENCH_NOISE["moderate"], seed)
    for setting, _, z, motion in seen(observed):
        if setting not in SETTINGS:
            continue
        found = {name: make(subject, z).fit(z) for name, make in METHODS.items()}
        told = informed(setting, z, motion)
        found["Bayes"] = Bayes(subject.shape).fit(told)
        for method, estimate in found.items():
            e = subject.errors(estimate)
            errors = (e.mass, e.center_of_mass, e.inertia_at_origin)
            scores.setdefault((setting, method, speed), []).append(errors)


def cited(speeds: tuple[float, ...]) -> list[dict[str, Any]]:
    """The published rows."""
    columns = [SPEEDS.index(speed) for speed in speeds]
    return [
        row(
            "published",
            method,
            speeds,
            [[errors[i] for i in columns] for errors in every],
        )
        for method, every in PUBLISHED.items()
    ]


def reproduced(scores: Scores, speeds: tuple[float, ...]) -> list[dict[str, Any]]:
    """Our rows."""
    found = []
    for setting, method in dict.fromkeys(key[:2] for key in scores):
        means = [np.mean(scores[setting, method, speed], axis=0) for speed in speeds]
        found.append(row(setting, method, speeds, np.transpose(means).tolist()))
    return found


def row(
    source: str,
    method: str,
    speeds: tuple[float, ...],
    errors: list[list[float]],
) -> dict[str, Any]:
    """As JSON-ready values; errors from `MOSTLY_WRONG` on are not told apart."""
    clipped = [rounded(min(e, MOSTLY_WRONG) for e in each) for each in errors]
    return {
        "source": source,
        "method": method,
        "speeds": list(speeds),
        "errors": dict(zip(QUANTITIES, clipped, strict=True)),
    }

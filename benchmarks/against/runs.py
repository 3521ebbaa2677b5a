"""All parties on the same recordings: errors, consistency, intervals and times."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from benchmarks.against.party import Answer, NoAnswerError, Party, Task
from benchmarks.against.recordings import Recorded
from benchmarks.bodies import sixteen
from benchmarks.timing import Timing, collected, timed
from hefting.core.spatial import Array

QUANTITIES = ("mass", "COM", "inertia")
ROUNDING = 1e-6
"""Of a relative margin, by which a body may be inconsistent: an interior-point solver's
answer on the boundary is as exact as that."""


@dataclass(eq=False)
class Outcome:
    """What one party did with the recordings of a set."""

    party: Party
    errors: list[tuple[float, float, float]] = field(default_factory=list)
    """[%] of mass, COM and inertia, infinite where there is no answer"""
    consistent: list[bool] = field(default_factory=list)
    held: list[Array] = field(default_factory=list)
    """(10,) one where an interval holds the truth, NaN where there is none"""
    records: list[tuple[float, float, Any]] = field(default_factory=list)
    """of `timed`"""

    def judge(self, answer: Answer | None, recorded: Recorded) -> None:
        """Put one answer beside the truth; None: there is none."""
        if answer is None:
            self.errors.append((np.inf,) * 3)
            self.consistent.append(False)
            self.held.append(np.full(10, np.nan))
            return
        self.errors.append(recorded.errors(answer.body))
        margins = answer.body.consistency().margins
        self.consistent.append(min(margins.values()) >= -ROUNDING)
        self.held.append(held(answer, sixteen(recorded.truth)[:10]))

    @property
    def timing(self) -> Timing:
        """Of all repetitions on all recordings."""
        return collected(self.records)

    @property
    def median_errors(self) -> Array:
        """(3,) [%]"""
        return np.median(np.array(self.errors), axis=0)

    def to_dict(self) -> dict[str, Any]:
        """As JSON-ready values."""
        inside = np.array(self.held)
        known = np.isfinite(inside)
        return {
            "party": self.party.name,
            "peer": self.party.peer,
            "beside": self.party.beside,
            "errors": dict(zip(QUANTITIES, rounded(self.median_errors), strict=True)),
            "unanswered": int(np.isinf(np.array(self.errors)[:, 0]).sum()),
            "consistent": rounded([100.0 * np.mean(self.consistent)])[0],
            "intervals": int(known.any(axis=0).sum()),
            "held": rounded([100.0 * inside[known].mean()])[0] if known.any() else None,
            "seconds": rounded([self.timing.median])[0],
        }


def held(answer: Answer, truth: Array) -> Array:
    """(10,) whether each interval holds the truth, NaN where there is none."""
    if answer.low is None or answer.high is None:
        return np.full(10, np.nan)
    inside = ((answer.low <= truth) & (truth <= answer.high)).astype(float)
    return np.where(np.isfinite(answer.low + answer.high), inside, np.nan)


def rounded(values: Iterable[float]) -> list[float | None]:
    """To four digits; None for what is not finite."""
    return [float(f"{v:.4g}") if np.isfinite(v) else None for v in values]


def measured(parties: Sequence[Party], recordings: Sequence[Recorded]) -> list[Outcome]:
    """Every party on every recording; they take turns, and the first time of each is
    not counted. Of one recording that of those which take long is."""
    outcomes = [Outcome(party) for party in parties]
    for outcome in outcomes:
        if len(recordings) == 1 and outcome.party.calls == 1:
            continue
        task = recordings[0].task
        attempted(outcome.party, task, outcome.party.prepare(task))
    for recorded in recordings:
        for outcome in outcomes:
            answer = repeated(outcome, recorded.task)
            outcome.judge(answer, recorded)
    return outcomes


def repeated(outcome: Outcome, task: Task) -> Answer | None:
    """As often as the party is to be timed; what it says the last time."""
    party = outcome.party
    for _ in range(party.calls):
        prepared = party.prepare(task)
        record = timed(lambda ready: attempted(party, task, ready), prepared)
        outcome.records.append(record)
    return outcome.records[-1][2]


def attempted(party: Party, task: Task, prepared: Any) -> Answer | None:
    """What it says; None where its solver fails."""
    try:
        return party.identify(task, prepared)
    except NoAnswerError:
        return None

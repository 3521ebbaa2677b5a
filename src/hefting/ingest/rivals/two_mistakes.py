"""Two mistakes: a first one without unknowns is undone, and a second one is searched
for beside it.

Free channels show beforehand beside which first mistakes a second may explain enough. With
a real sensor, whose imperfections remain, pairs leave 15 to 40 % of what is unexplained as
given, in simulated recordings next to nothing.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from hefting.core.progress import each as each_of
from hefting.core.spatial import distinct, immutable
from hefting.ingest.rivals import BESIDE_ANOTHER, UNDONE, bias
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.elastic import Vibration
from hefting.ingest.rivals.evidence import NEGLIGIBLE_UNEXPLAINED, missing
from hefting.ingest.rivals.explanation import (
    Explanation,
    Undone,
    explained_by_motion,
)
from hefting.ingest.rivals.judge import (
    CLEAR_EVIDENCE,
    FEWEST_SAMPLES,
    MANY_POSES,
    Judged,
    cost_of,
    independent_samples,
    judge_one,
)

LARGE_UNEXPLAINED = 0.2
"""Residual over the wrench's changes from which on two mistakes are searched for: for
pairs of common ones in a recording of a real sensor it is 0.23 and more."""
ENOUGH_EXPLAINED = 0.25
"""Share of what is unexplained up to which one mistake may leave it without a search
for a second."""
LARGEST_LEFT = 0.5
"""Largest share of what is unexplained that two mistakes may leave to be named."""
LARGEST_AT_FIRST = 1.6
"""What the rough fit of a second mistake may leave, over that."""
LARGEST_LEFT_OF_ONE = 0.4
"""Largest share of what one mistake leaves unexplained that another beside it may
leave: beside a right one, in two recordings of a real sensor, imperfections leave 0.55.
"""
LARGEST_LEFT_OF_ANOTHER = 0.8
"""The same if that one is neither of the two."""
RARITY_OF_TWO = 5.0
"""Rarity of two mistakes at once, of which there are some 150 times as many pairs."""
FARTHEST_COM = 1.0
"""[m] Largest distance of an object's COM from the sensor with two mistakes."""
CLEAR_EFFECT = 3.0
"""Standard deviations from which on a second mistake is significant."""

_ALONE: WeakKeyDictionary[Case, Judged] = WeakKeyDictionary()
"""Results of `judge_alone`."""

Explain = Callable[[Case], Explanation | None]


@immutable
class Pair:
    """Two mistakes at once."""

    undone: Undone
    """the first mistake, and the recording without it"""
    explain: Explain
    """finds the second mistake"""
    second: Explanation
    """the second mistake, fitted to the recording without the first"""

    @classmethod
    def of(cls, undone: Undone, explain: Explain) -> "Pair | None":
        """The pair, or None where there is no second mistake beside the first."""
        second = explain(undone.case)
        if second is None or second.code == undone.code or not _is_held(second):
            return None
        if second.effect is not None and not second.effect > CLEAR_EFFECT:
            return None
        return cls(undone, explain, second)

    @property
    def left(self) -> float:
        """Log-likelihood per sample that is missing, see `evidence.missing`."""
        return missing(self.undone.case, self.second.fitted)

    @property
    def samples(self) -> float:
        """Number of independent samples."""
        return independent_samples(self.undone.case, self.second)

    def value(self, samples: float) -> float:
        """Log-likelihood of a number of independent samples, less the mistakes' cost."""
        cost = cost_of(self.second, samples) + self.undone.rarity + RARITY_OF_TWO
        return samples * (self.second.likelihood + self.undone.log_scale) - cost


def _is_held(second: Explanation) -> bool:
    """Whether a wrist can hold the object: its mass, and the distance of its COM."""
    mass, moment = abs(second.vector[0]), np.linalg.norm(second.vector[1:4])
    return not second.is_too_heavy and bool(moment < FARTHEST_COM * mass)


def judge_alone(case: Case) -> Judged:
    """Search for one mistake; the result is kept for the life of the case."""
    if case not in _ALONE:
        found = judge_one(case)
        if found.named is not None:  # an alternative would keep the case alive
            found = replace(found, named=replace(found.named, alternative=None))
        _ALONE[case] = found
    return _ALONE[case]


def judge(case: Case) -> Judged:
    """Search for one mistake and, where it leaves much that is no vibration, for two."""
    found = judge_alone(case)
    if found.given is None or not _is_worth_a_search(case, found, found.given):
        return found
    pair = _likeliest(case, found.given)
    if pair is None or not _is_named(case, found, pair):
        return found
    first, second = pair.undone.explanation(), None
    alone = missing(pair.undone.case, first.fitted)
    if pair.left < max(LARGEST_LEFT_OF_ONE * alone, NEGLIGIBLE_UNEXPLAINED):
        first = pair.undone.explanation(pair.second.fitted)
        first, second = replace(first, parameters=pair.second.vector), pair.second
    elif not alone < _most_left(case, found.given):
        return found
    whole = min(pair.left, alone) < NEGLIGIBLE_UNEXPLAINED
    return replace(found, named=first, certain=True, whole=whole, beside=second)


def _is_worth_a_search(case: Case, found: Judged, given: Explanation) -> bool:
    """Whether to search for two mistakes: much is left unexplained by one mistake, by a
    bias drift in a short recording, and by a vibration."""
    if found.whole or not found.unexplained > LARGE_UNEXPLAINED:
        return False
    if case.poses < MANY_POSES:
        return False
    little = ENOUGH_EXPLAINED * missing(case, given.fitted)
    if found.named is not None and missing(case, found.named.fitted) < little:
        return False
    drift = bias.explain_drift(case)
    little = max(little, NEGLIGIBLE_UNEXPLAINED)
    if drift is not None and missing(case, drift.fitted) < little:
        return False
    vibration = Vibration.of(case) if case.path.moves else None
    left = found.unexplained
    if vibration is not None:
        left = vibration.beside(left)
    return left > LARGE_UNEXPLAINED


def _is_named(case: Case, found: Judged, pair: Pair) -> bool:
    """Whether to name the pair in place of no mistake, or of the one that was named."""
    assert found.given is not None
    if not pair.left < _most_left(case, found.given):
        return False
    samples, one = pair.samples, found.given
    if found.named is not None:
        one = found.named
        same = one.code == pair.undone.code or one.what == pair.second.what
        share = LARGEST_LEFT_OF_ONE if same else LARGEST_LEFT_OF_ANOTHER
        most = share * missing(case, one.fitted)
        if not pair.left < max(most, NEGLIGIBLE_UNEXPLAINED):
            return False
    alone = samples * one.likelihood - cost_of(one, samples)
    return pair.value(samples) - alone > CLEAR_EVIDENCE


def _most_left(case: Case, given: Explanation) -> float:
    """Log-likelihood per sample that may be missing with two mistakes."""
    return max(NEGLIGIBLE_UNEXPLAINED, LARGEST_LEFT * missing(case, given.fitted))


def _likeliest(case: Case, given: Explanation) -> Pair | None:
    """The likeliest pair of mistakes; None where there is none.

    All pairs are fitted to every n-th average of the wrench, and the likeliest one to all
    averages. A first mistake is skipped where even free channels leave too much beside it.
    """
    nth = max(len(case.time) // FEWEST_SAMPLES, 1)
    most = _most_left(case, given)
    offset_as_given = _clock_offset(case, most)
    found: list[tuple[Pair, Undone]] = []
    for undone, others in _all(case):
        offset = offset_as_given
        if not undone.is_linear:
            offset = _clock_offset(undone.case, most)
        if offset is None:
            continue
        few = tuple(distinct((0.0, case.offset, offset)).tolist())
        other = replace(undone.case, few_offsets=few, most_left=LARGEST_AT_FIRST * most)
        undone = replace(undone, case=other)
        thin = replace(undone, case=undone.case.every(nth))
        pairs = (Pair.of(thin, explain) for explain in others)
        found += [(p, undone) for p in pairs if p is not None and p.left < most]
    if not found:
        return None
    samples = min(found, key=lambda each: each[0].left)[0].samples
    best, undone = max(found, key=lambda each: each[0].value(samples))
    return Pair.of(undone, best.explain)


def _all(case: Case) -> Iterator[tuple[Undone, list[Explain]]]:
    """Each first mistake, undone, with the searches for a second one beside it: those of
    `BESIDE_ANOTHER`, and of the kinds that come before it in `UNDONE`."""
    others: list[Explain] = [*BESIDE_ANOTHER]
    for undone, explain in each_of("looking for two mistakes at once", UNDONE):
        for each in undone(case):
            yield each, others
        if explain is not None:
            others = [*others, explain]


def _clock_offset(case: Case, most: float) -> float | None:
    """The likeliest clock offset [s] with free channels; None where even they leave more
    than `most` unexplained."""
    found = None
    for fitted, offset in explained_by_motion(case):
        found = offset if missing(case, fitted) < most else None
    return found

"""Judge: whether a mistake explains a recording far better than that there is none.

Explanations are compared by the log-likelihood of the independent samples, less what
their unknowns cost (Schwarz's criterion). One is named if it is far likelier than the
recording as given, and leaves little of what that leaves unexplained. A sensor's own
imperfections, which any unknown explains a little of, are not named: of the recordings
of three real sensors the best mistake explains a third at most. Nor is a mistake named
where errors as on data sheets explain the recording better, and are found no larger than
there, or next to nothing is unexplained.
Static poses do not tell how large these are: there a mistake may leave more, if it is far
likelier than they. Where a bias that drifts more freely explains the recording, too, a
mistake is named only beside it: of a sensor that creeps a turn or a cable imitates that.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.progress import each as each_of
from hefting.core.spatial import Array
from hefting.ingest.filtering import SHORTEST_LAG
from hefting.ingest.rivals import (
    EXPLANATIONS,
    LARGE_EXPLANATIONS,
    LINEAR_EXPLANATIONS,
    OF_FEW_POSES,
    short_drift,
    wrench_filtered,
)
from hefting.ingest.rivals.calibration_matrix import (
    LARGE_DATA_SHEET_ERROR,
    errors_on_data_sheet,
)
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    NEGLIGIBLE_UNEXPLAINED,
    Fitted,
    correlation,
    fit_rows,
    is_hopeless,
    missing,
)
from hefting.ingest.rivals.explanation import (
    HEAVIEST_HELD,
    Explanation,
    as_given,
    explained_by_motion,
    newton_euler,
)
from hefting.ingest.rivals.small_mistakes import score
from hefting.ingest.robust_rows import RobustRows

FEWEST_POSES, MANY_POSES = 6, 12
"""Fewest static poses on which explanations are compared: `OF_FEW_POSES`, and all."""
FEWEST_SAMPLES = 60
"""Fewest averages of the wrench of a moving sensor on which they are."""
LEAST_CORRELATION = 4.0
"""Samples that count as one in those on which mistakes are first looked for, where it is
as many in all of them."""
CLEAR_UNEXPLAINED = 0.5
"""Log-likelihood of a sample that is missing to noise alone, from which on all
explanations are tried."""
CLEAR_CORRELATION = 1.5
"""Samples that count as one from which on residuals are no white noise."""
CLEAR_SCORE = 15.0
"""Improvement of the weighted square by small mistakes, in independent samples, from
which on all explanations are tried."""
NOISE_ALLOWANCE = 1.3
"""Factor by which the square of a residual may exceed that of the noise by chance."""
SMALLEST_CHANGE = 1e-6
"""Variance of a wrench over its mean square below which it does not change."""
LARGE_UNEXPLAINED = 0.1
"""Residual over the wrench's changes from which on mistakes that leave much are tried."""
CLEAR_SHARE_OF_POSES = 0.05
"""The same from which on a mistake of static poses may be named though it leaves much:
of 480 right simulated sets beside a sensor's errors of 1 % three in four are below 0.035,
of 150 choices of a real arm's poses all are below 0.025, and a gain of 1.3 or a tilt of
5° are above 0.055."""
CLEAR_EVIDENCE = 12.0
"""Log of the ratio of likelihoods, unknowns counted, from which on a mistake is beyond
doubt."""
POSSIBLE_EVIDENCE = 5.0
"""The same from which on it is possible enough to be told."""
LEAST_WORTH = 0.3
"""Share of the samples that counts at least, however wrong the motion may be: in a wrong
unit its errors are as large as itself."""
EXPLAINED_SHARE = 0.5
"""Share of what is unexplained that a mistake must explain to be named."""
EXPLAINED_IF_WHITE = 1.0 / 3.0
"""The same of a mistake that leaves white residuals of coloured ones: nothing else is to
be explained. Of the recordings of three real sensors none does with more than a fifth."""
OVERWHELMING_EVIDENCE = 50.0
"""The log of the ratio from which on a mistake of many laws is named though it explains
a part only: of three real sensors none has 27."""
EXPLAINED_BESIDE_OTHERS = 0.2
"""Share that such a mistake must explain, or one of static poses beside what nothing
tells."""
EXPLAINED_BY_NOISE = -0.3
"""Log-likelihood of a sample missing to noise alone below which noise explains more than
all, as that of an arm that vibrates; a sensor's imperfections are below it."""
BOUND_MARGIN = 0.9
"""Share of what free channels leave unexplained that counts as the least a mistake
leaves that is linear in the motion: their clock offset is found to half a millisecond.
Where such a mistake was named, in 119 of 612 recordings of three real sensors with one,
they left 0.77 of what it may leave at most; in simulated ones next to nothing."""
NEARLY = 0.9
"""Share of what the best mistake explains that a much simpler one must explain to be
named in its place."""
SIMPLER = 3
"""Difference of unknowns that counts as much simpler."""


Candidates = tuple[Callable[[Case], Explanation | None], ...]


@immutable
class Judged:
    """What was found."""

    unexplained: float
    """residual beyond white noise over the wrench's changes, the larger of force's and
    torque's, as given"""
    named: Explanation | None = None
    """the mistake that explains the recording far better"""
    given: Explanation | None = None
    """the recording as given, where mistakes were tried"""
    certain: bool = False
    """whether the mistake is beyond doubt"""
    whole: bool = False
    """whether it is, and leaves next to nothing unexplained"""
    beside: Explanation | None = None
    """another mistake that is made at once with the one that is named"""


def judge_one(case: Case) -> Judged:
    """Look for a mistake where the recording as given is not explained by noise; where
    none is found, beside a filter that makes the wrench as late as it is. A filter is
    compared with such a one where that is likelier, as the answer will be corrected."""
    found = _judge_beside_drift(case, EXPLANATIONS)
    is_filtered = found.named is not None and found.named.code == wrench_filtered.CODE
    if found.given is None or case.offset < SHORTEST_LAG:
        return found
    if found.named is not None and not is_filtered:
        return found
    slow = wrench_filtered.as_filtered(case)
    if slow is None:
        return found
    if is_filtered:
        given = max((found.given, as_given(slow)), key=lambda each: each.likelihood)
        return replace(found, given=given)
    named = _judge_beside_drift(slow, ()).named
    if named is None or not _is_told(case, found.given, named):
        return found
    certain = evidence(case, found.given, named) > CLEAR_EVIDENCE
    return replace(found, named=named, certain=certain)


def _judge_beside_drift(case: Case, candidates: Candidates) -> Judged:
    """What is found, unless it is not found beside a bias that drifts more freely, where
    that explains part of the recording, too: a turn, a gain or a cable imitates it."""
    found = _judge(case, candidates)
    named, given = found.named, found.given
    if named is None or given is None or not case.path.moves:
        return found
    if named.code == short_drift.CODE:
        return found
    before = missing(case, given.fitted)
    part = EXPLAINED_BESIDE_OTHERS * max(before, NEGLIGIBLE_UNEXPLAINED)
    as_much = max(before - missing(case, named.fitted), part)
    # with one knot more where that explains part, with two where as much as the mistake
    for knots, needed in ((1, part), (2, as_much)):
        freer = case.with_drift(knots)
        if before - missing(case, as_given(freer).fitted) < needed:
            continue
        beside = _judge(freer, candidates).named
        if beside is None or beside.code != named.code:
            break
    else:
        return found
    drift = short_drift.explain(case)
    if drift is None or not _is_told(case, given, drift):
        return Judged(found.unexplained, None, given)
    certain = evidence(case, given, drift) > CLEAR_EVIDENCE
    return Judged(found.unexplained, drift, given, certain)


def _judge(case: Case, candidates: Candidates) -> Judged:
    """Look for a mistake among those that are always looked for and those that are where
    they may explain enough."""
    fewest = FEWEST_SAMPLES if case.path.moves else FEWEST_POSES
    if len(case.time) < fewest or case.poses < FEWEST_POSES:
        return Judged(0.0)
    quick = fit_rows(case, newton_euler(case, case.motion_as_found))
    if not np.isfinite(quick.likelihood[0]):  # the motion is hardly known
        return Judged(0.0)
    share = unexplained_share(case, quick, case.floor)
    if not _is_worth_a_search(case, quick, share):
        return Judged(share)
    given = as_given(case)
    if missing(case, given.fitted) < EXPLAINED_BY_NOISE:
        return Judged(share, None, given)
    if case.poses < MANY_POSES or any(
        _is_explained(case, given, fitted, BOUND_MARGIN)
        for fitted, _ in explained_by_motion(case)
    ):
        candidates += LINEAR_EXPLANATIONS
    if share > LARGE_UNEXPLAINED:
        candidates += LARGE_EXPLANATIONS
    if case.poses < MANY_POSES:
        candidates = tuple(each for each in candidates if each in OF_FEW_POSES)
    found = [explain(case) for explain in _promising(case, given, candidates)]
    tried = [each for each in found if each is not None and not is_too_heavy(each)]
    if not tried:
        return Judged(share, None, given)
    best = max(tried, key=lambda each: evidence(case, given, each))
    if _is_told(case, given, best):
        best = _simplest(case, given, best, tried)
    # a turn beside a lever arm may explain too little alone
    both: list[Explanation] = []
    other: Explanation | None = best
    while other is not None:
        if (
            not is_too_heavy(other)
            and _is_told(case, given, other)
            and (
                other.unknowns < best.unknowns
                or evidence(case, given, other) >= evidence(case, given, best)
            )
        ):
            both.append(other)
        other = None if other.alternative is None else other.alternative()
    if not both:
        return Judged(share, None, given)
    best = max(both, key=lambda each: evidence(case, given, each))
    told = evidence(case, given, best)
    sheet = errors_on_data_sheet(case)
    little = missing(case, given.fitted) < NEGLIGIBLE_UNEXPLAINED
    usual = little or (sheet.effect or 0.0) < 1.0
    if usual and evidence(case, given, sheet) > told:
        return Judged(share, None, given)
    certain = told > CLEAR_EVIDENCE
    whole = certain and missing(case, best.fitted) < NEGLIGIBLE_UNEXPLAINED
    return Judged(share, best, given, certain, whole)


def _promising(case: Case, given: Explanation, candidates: Candidates) -> Candidates:
    """Those that may be told, by fewer averages where neighbouring ones tell the same."""
    stage = "looking for mistakes in the recording"
    alike = correlation(given.fitted) / LEAST_CORRELATION
    nth = min(int(alike), len(case.time) // FEWEST_SAMPLES)
    if nth < 2:
        return tuple(each_of(stage, candidates))
    thin = case.every(nth)
    given = as_given(thin)
    return tuple(
        explain
        for explain in each_of(stage, candidates)
        if _may_be_told(thin, given, explain(thin))
    )


def _may_be_told(case: Case, given: Explanation, other: Explanation | None) -> bool:
    """Whether a mistake may be named by more averages than these."""
    if other is None or evidence(case, given, other) < 0.5 * POSSIBLE_EVIDENCE:
        return False
    if other.of_many_laws or other.alternative is not None:
        return not is_hopeless(case, other.fitted, given.fitted)
    return _is_explained(case, given, other.fitted, BOUND_MARGIN)


def is_too_heavy(other: Explanation) -> bool:
    """Whether an explanation makes the object heavier than a wrist holds, or leaves it
    so: then another mistake is to be found first."""
    return abs(other.vector[0]) > HEAVIEST_HELD


def _is_worth_a_search(case: Case, fitted: Fitted, share: float) -> bool:
    """Whether the recording as given leaves what noise does not: much of the wrench's
    changes, residuals that are no white noise, or what a small mistake would leave."""
    if share > LARGE_UNEXPLAINED:
        return True
    # static poses are few: a search costs little, and their noise is not known
    coloured = not (case.path.moves and _is_white(fitted))
    if coloured and missing(case, fitted) > CLEAR_UNEXPLAINED:
        return True
    return score(case, fitted) > CLEAR_SCORE


def evidence(case: Case, given: Explanation, other: Explanation) -> float:
    """Log of the ratio of likelihoods to that of the recording as given, less the cost
    of unknowns."""
    samples = independent_samples(case, other)
    return samples * (other.likelihood - given.likelihood) - cost_of(other, samples)


def independent_samples(case: Case, other: Explanation) -> float:
    """How many samples count as independent, by what an explanation leaves."""
    fitted = other.fitted
    worth = max(float(case.worth.sum()), LEAST_WORTH * len(case.time))
    return max(worth / correlation(fitted), 2.0)


def cost_of(other: Explanation, samples: float) -> float:
    """Log-likelihood that the unknowns of an explanation cost beside so many independent
    samples, and that it is rare."""
    cost = other.cost
    if cost is None:
        cost = 0.5 * other.unknowns * float(np.log(samples))
    return cost + other.rarity


def _is_told(case: Case, given: Explanation, other: Explanation) -> bool:
    """Whether a mistake is to be named."""
    told = evidence(case, given, other)
    if not told > POSSIBLE_EVIDENCE:
        return False
    if other.effect is not None and not other.effect > 3.0:
        return False
    left, before = missing(case, other.fitted), missing(case, given.fitted)
    explains_part = left < (1.0 - EXPLAINED_BESIDE_OTHERS) * before
    if other.of_many_laws and told > OVERWHELMING_EVIDENCE:
        return explains_part
    if _is_explained(case, given, other.fitted):
        return True
    if case.path.moves or not explains_part:
        return False
    # of static poses nothing tells how much noise and the sensor's errors leave
    share = unexplained_share(case, given.fitted, case.floor)
    if not share > CLEAR_SHARE_OF_POSES:
        return False
    errors = errors_on_data_sheet(case, LARGE_DATA_SHEET_ERROR)
    return told > CLEAR_EVIDENCE + max(evidence(case, given, errors), 0.0)


def _is_explained(
    case: Case, given: Explanation, fitted: RobustRows, share: float = 1.0
) -> bool:
    """Whether a fit, or one that leaves a `share` of what it does, leaves little
    unexplained."""
    left, before = share * missing(case, fitted), missing(case, given.fitted)
    needed = EXPLAINED_SHARE
    if case.path.moves and _is_white(fitted) and not _is_white(given.fitted):
        needed = EXPLAINED_IF_WHITE
    return left < NEGLIGIBLE_UNEXPLAINED or left < (1.0 - needed) * before


def _is_white(fitted: RobustRows) -> bool:
    """Whether the residuals of the likeliest alternative are white noise."""
    return correlation(fitted) < CLEAR_CORRELATION


def _simplest(
    case: Case, given: Explanation, best: Explanation, tried: list[Explanation]
) -> Explanation:
    """The likeliest of those with the fewest unknowns that explain nearly as much as
    the best one: flexible explanations imitate simple ones, and a little besides."""
    before = missing(case, given.fitted)
    needed = NEARLY * (before - missing(case, best.fitted))
    simpler = [
        each
        for each in tried
        if each.unknowns < best.unknowns - SIMPLER
        and before - missing(case, each.fitted) > needed
        and _is_told(case, given, each)
    ]
    return max(simpler, key=lambda each: evidence(case, given, each), default=best)


def unexplained_share(case: Case, fitted: Fitted, level: Array) -> float:
    """Residual of the best alternative beyond a level (2,) that noise explains, over the
    wrench's changes; the larger of force's and torque's."""
    fitted = fitted.of_best()
    changes = np.var(case.wrench, axis=0).reshape(2, 3).mean(axis=1)
    used = fitted.weights[0] > 0.0
    square = np.square(fitted.residual[0][used]).reshape(-1, 2, 3).sum(axis=2)
    # the median of chi-squared with three degrees of freedom is 2.37
    left = np.maximum(np.square(fitted.scale[0]), np.median(square, axis=0) / 2.37)
    excess = np.maximum(left - NOISE_ALLOWANCE * np.square(level), 0.0)
    size = np.mean(case.wrench**2, axis=0).reshape(2, 3).mean(axis=1)
    varies = changes > SMALLEST_CHANGE * size
    share = np.where(varies, excess / np.maximum(changes, 1e-300), 0.0)
    return float(np.sqrt(np.minimum(share, 1.0)).max())

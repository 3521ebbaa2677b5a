"""Judge: whether a mistake explains a recording far better than the recording as given.

Explanations are compared by the log-likelihood of the independent samples, less a penalty
on their unknowns (Schwarz's criterion). A mistake is named if it is far likelier than the
recording as given and explains most of what that leaves unexplained, beside the drift that
is removed. It is not named

- for a sensor's own imperfections, of which every unknown explains a little: in recordings
  of three real sensors the best mistake explains a third at most;
- where calibration errors of the size that data sheets, or the user, give explain the
  recording as well, or next to nothing is unexplained. Static poses do not show the size
  of these errors: there a mistake may leave more unexplained, if it is far likelier;
- where a more freely drifting bias explains the recording as well: a turned sensor or a
  cable imitates a sensor that creeps;
- where it leaves more of all residuals than the recording as given.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hefting.core.progress import each as each_of
from hefting.core.spatial import immutable
from hefting.ingest.filtering import SHORTEST_LAG
from hefting.ingest.rivals import (
    EXPLANATIONS,
    LARGE_EXPLANATIONS,
    LINEAR_EXPLANATIONS,
    OF_FEW_POSES,
    bias,
    timing,
)
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    NEGLIGIBLE_UNEXPLAINED,
    Fitted,
    correlation,
    fit_rows,
    is_hopeless,
    mean_square,
    missing,
    missing_by_motion,
    unexplained_share,
)
from hefting.ingest.rivals.explanation import (
    Explanation,
    as_given,
    explained_by_motion,
    newton_euler,
)
from hefting.ingest.rivals.sensor_calibration import (
    errors_on_data_sheet,
)
from hefting.ingest.rivals.small_mistakes import score
from hefting.ingest.robust_rows import RobustRows

FEWEST_POSES, MANY_POSES = 6, 12
"""Numbers of static poses from which on the mistakes of `OF_FEW_POSES`, and all mistakes,
are tried."""
FEWEST_SAMPLES = 60
"""Number of averages of a moving sensor's wrench from which on mistakes are tried."""
LEAST_CORRELATION = 4.0
"""Autocorrelation time [samples] of the averages on which mistakes are first tried, where
that of all averages is longer."""
CLEAR_UNEXPLAINED = 0.5
"""Missing log-likelihood per sample (`missing`) from which on mistakes are tried."""
CLEAR_CORRELATION = 1.5
"""Autocorrelation time [samples] from which on residuals are not white."""
CLEAR_SCORE = 15.0
"""Score of small mistakes (`small_mistakes.score`) from which on mistakes are tried."""
LARGE_UNEXPLAINED = 0.1
"""`unexplained_share` from which on mistakes are tried, those that leave much included."""
CLEAR_SHARE_OF_POSES = 0.05
"""The same from which on a mistake of static poses may be named though it leaves much. In
choices of a real arm's poses it is below 0.025, with a sensor's errors of 1 % mostly below
0.035, with a gain of 1.3 or a tilt of 5° above 0.055."""
SMALL_PART_OF_RANGE = 2.0
"""Factor on the errors of a sensor that is used in a small part of its range."""
CLEAR_EVIDENCE = 12.0
"""`evidence` from which on a mistake is beyond doubt."""
POSSIBLE_EVIDENCE = 5.0
"""`evidence` from which on a mistake may be named."""
LEAST_WORTH = 0.3
"""Smallest share of the samples that counts, however large the errors of the motion are:
in a wrong unit of the motion they are overestimated."""
EXPLAINED_SHARE = 0.5
"""Share of what is unexplained that a mistake must explain to be named."""
EXPLAINED_IF_WHITE = 1.0 / 3.0
"""The same where coloured residuals become white, so that nothing is left to explain. In
recordings of three real sensors no such mistake explains more than a fifth."""
OVERWHELMING_EVIDENCE = 50.0
"""`evidence` from which on a mistake of many laws is named though it explains only a
part; with three real sensors it is below 27."""
EXPLAINED_BESIDE_OTHERS = 0.2
"""Share that such a mistake must explain, and so must one of static poses, or a drift."""
EXPLAINED_BY_NOISE = -0.3
"""Missing log-likelihood per sample below which no mistake is tried, as the noise is larger
than the residuals, as where an arm vibrates, and hides a sensor's imperfections."""
BOUND_MARGIN = 0.9
"""Factor on what free channels leave unexplained that makes it a lower bound for mistakes
that are linear in the motion, as their clock offset is found to half a millisecond. With
three real sensors free channels left at most 0.77 of the limit where one was named."""
LARGEST_WORSENING = 2.0
"""Ratio of the mean squares of all residuals, with a mistake and as given, up to which it
is named. Of true ones it is at most 1.03; weaker accelerations, by which the usual samples
are explained if hard braking is not, have 4."""
NEARLY = 0.9
"""Share of what the best mistake explains that a much simpler one must explain to be
named in its place."""
SIMPLER = 3
"""Difference in the number of unknowns that counts as much simpler."""


Candidates = tuple[Callable[[Case], Explanation | None], ...]


@immutable
class Judged:
    """The outcome of a search for mistakes."""

    unexplained: float
    """residual of the recording as given beyond white noise, as a share of the wrench's
    changes; the larger share of force and torque"""
    named: Explanation | None = None
    """the mistake that explains the recording far better"""
    given: Explanation | None = None
    """the recording as given, where mistakes were tried"""
    certain: bool = False
    """whether the mistake is beyond doubt"""
    whole: bool = False
    """whether it is beyond doubt and leaves next to nothing unexplained"""
    beside: Explanation | None = None
    """a second mistake, where two were made at once"""


def judge_one(case: Case) -> Judged:
    """Search for one mistake, if noise does not explain the recording as given.

    If there is none, the search is repeated with a motion that is filtered by the wrench's
    lag, for which the answer is corrected. A filter is compared with the likelier of both.
    """
    found = _judge_beside_drift(case, EXPLANATIONS)
    is_filtered = found.named is not None and found.named.code == timing.FILTERED
    if found.given is None or case.offset < SHORTEST_LAG:
        return found
    if found.named is not None and not is_filtered:
        return found
    slow = timing.as_filtered(case)
    if slow is None:
        return found
    if is_filtered:
        given = max((found.given, as_given(slow)), key=lambda each: each.likelihood)
        return replace(found, given=given)
    named = _judge_beside_drift(slow, ()).named
    if named is None or not _is_named(case, found.given, named):
        return found
    certain = evidence(case, found.given, named) > CLEAR_EVIDENCE
    return replace(found, named=named, certain=certain)


def _judge_beside_drift(case: Case, candidates: Candidates) -> Judged:
    """Search for a mistake; one that a more freely drifting bias explains as well, which
    a turn, a gain or a cable imitates, gives way to a drift or to none."""
    found = _judge(case, candidates)
    named, given = found.named, found.given
    if named is None or given is None or not case.path.moves:
        return found
    if named.code == bias.DRIFT:
        return found
    beside = _beside_freer_drift(case, candidates, found, named)
    if beside is not None:
        return beside
    drift = bias.explain_drift(case)
    if drift is None or not _is_named(case, given, drift):
        return Judged(found.unexplained, None, given)
    certain = evidence(case, given, drift) > CLEAR_EVIDENCE
    return Judged(found.unexplained, drift, given, certain)


def _beside_freer_drift(
    case: Case, candidates: Candidates, found: Judged, named: Explanation
) -> Judged | None:
    """What is `found` if the same mistake is `named` with one more bias knot, where that
    knot explains part of the recording, and with two, where they explain as much as the
    mistake; or another mistake that accounts for the rest beside them."""
    assert found.given is not None
    before = missing(case, found.given.fitted)
    part = EXPLAINED_BESIDE_OTHERS * max(before, NEGLIGIBLE_UNEXPLAINED)
    as_much = max(before - missing(case, named.fitted), part)
    for knots, needed in ((1, part), (2, as_much)):
        freer = case.with_drift(knots)
        left = missing(case, as_given(freer).fitted)
        if before - left < needed:
            continue
        again = _judge(freer, candidates)
        if again.named is None or again.named.code != named.code:
            return again if again.whole and left > CLEAR_UNEXPLAINED else None
    return found


def _judge(case: Case, candidates: Candidates) -> Judged:
    """Search for a mistake among the candidates and those `_more_candidates` adds."""
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
    candidates = _more_candidates(case, given, share, candidates)
    found = [explain(case) for explain in _promising(case, given, candidates)]
    tried = [each for each in found if each is not None and not each.is_too_heavy]
    best = _to_name(case, given, tried) if tried else None
    if best is None:
        return Judged(share, None, given)
    log_odds = evidence(case, given, best)
    sheet = errors_on_data_sheet(case)
    little = missing(case, given.fitted) < NEGLIGIBLE_UNEXPLAINED
    within_sheet = little or (sheet.effect or 0.0) < 1.0
    beyond = log_odds - evidence(case, given, sheet)
    if within_sheet and beyond < POSSIBLE_EVIDENCE:
        return Judged(share, None, given)
    certain = log_odds > CLEAR_EVIDENCE
    whole = certain and missing(case, best.fitted) < NEGLIGIBLE_UNEXPLAINED
    return Judged(share, best, given, certain, whole)


def _more_candidates(
    case: Case, given: Explanation, share: float, candidates: Candidates
) -> Candidates:
    """Candidates with the mistakes that may explain enough of this recording, of which a
    `share` is unexplained as given; for few poses only those of few unknowns."""
    few = case.poses < MANY_POSES
    if few or any(
        _is_explained(case, given, fitted, BOUND_MARGIN)
        for fitted, _ in explained_by_motion(case)
    ):
        candidates += LINEAR_EXPLANATIONS
    left = missing(case, given.fitted)  # beside noise, of whatever colour
    if share > LARGE_UNEXPLAINED and left > NEGLIGIBLE_UNEXPLAINED:
        candidates += LARGE_EXPLANATIONS
    return tuple(each for each in candidates if not few or each in OF_FEW_POSES)


def _to_name(
    case: Case, given: Explanation, tried: list[Explanation]
) -> Explanation | None:
    """The mistake to name: the likeliest, a much simpler one, or one of its alternatives,
    as a turn beside a lever arm may explain too little alone; None where none may be."""
    best = max(tried, key=lambda each: evidence(case, given, each))
    if _is_named(case, given, best):
        best = _simplest(case, given, best, tried)
    found: list[Explanation] = []
    other: Explanation | None = best
    while other is not None:
        if (
            not other.is_too_heavy
            and _is_named(case, given, other)
            and _is_preferable(case, given, other, best)
        ):
            found.append(other)
        other = None if other.alternative is None else other.alternative()
    return max(found, key=lambda each: evidence(case, given, each), default=None)


def _promising(case: Case, given: Explanation, candidates: Candidates) -> Candidates:
    """The candidates that may be named, judged on every n-th average of the wrench where
    neighbouring averages are correlated."""
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
        if _may_be_named(thin, given, explain(thin))
    )


def _may_be_named(case: Case, given: Explanation, other: Explanation | None) -> bool:
    """Whether a mistake may be named once more averages are used."""
    if other is None or evidence(case, given, other) < 0.5 * POSSIBLE_EVIDENCE:
        return False
    if other.of_many_laws or other.alternative is not None:
        return not is_hopeless(case, other.fitted, given.fitted)
    return _is_explained(case, given, other.fitted, BOUND_MARGIN)


def _is_worth_a_search(case: Case, fitted: Fitted, share: float) -> bool:
    """Whether the fit of the recording as given leaves a large `share` of the wrench's
    changes, coloured residuals, or residuals that a small mistake would explain."""
    if share > LARGE_UNEXPLAINED:
        return True
    # static poses are few: a search costs little, and their noise is not known
    coloured = not (case.path.moves and _is_white(fitted))
    if coloured and missing(case, fitted) > CLEAR_UNEXPLAINED:
        return True
    return score(case, fitted) > CLEAR_SCORE


def evidence(case: Case, given: Explanation, other: Explanation) -> float:
    """Log likelihood ratio of an explanation to the recording as given, less the cost of
    its unknowns."""
    samples = independent_samples(case, other)
    return samples * (other.likelihood - given.likelihood) - cost_of(other, samples)


def independent_samples(case: Case, other: Explanation) -> float:
    """Number of independent samples, by the autocorrelation of the residuals."""
    fitted = other.fitted
    worth = max(float(case.worth.sum()), LEAST_WORTH * len(case.time))
    return max(worth / correlation(fitted), 2.0)


def cost_of(other: Explanation, samples: float) -> float:
    """Penalty on the log-likelihood for the unknowns of an explanation, given the number
    of independent samples, and for its rarity."""
    cost = other.cost
    if cost is None:
        cost = 0.5 * other.unknowns * float(np.log(samples))
    return cost + other.rarity


def _is_named(case: Case, given: Explanation, other: Explanation) -> bool:
    log_odds = evidence(case, given, other)
    if not log_odds > POSSIBLE_EVIDENCE:
        return False
    if other.effect is not None and not other.effect > 3.0:
        return False
    after, as_recorded = (mean_square(case, each.fitted) for each in (other, given))
    if after > LARGEST_WORSENING * as_recorded:
        return False
    left, before = missing(case, other.fitted), missing(case, given.fitted)
    if before < CLEAR_UNEXPLAINED and before - left < missing_by_motion(case):
        return False
    explains_part = left < (1.0 - EXPLAINED_BESIDE_OTHERS) * before
    if other.of_many_laws and log_odds > OVERWHELMING_EVIDENCE:
        return explains_part
    if _is_explained(case, given, other.fitted):
        return True
    if case.path.moves or not explains_part:
        return False
    # the residuals of static poses do not separate noise from the sensor's errors
    share = unexplained_share(case, given.fitted, case.floor)
    if not share > CLEAR_SHARE_OF_POSES:
        return False
    errors = errors_on_data_sheet(case, SMALL_PART_OF_RANGE)
    return log_odds > CLEAR_EVIDENCE + max(evidence(case, given, errors), 0.0)


def _is_explained(
    case: Case, given: Explanation, fitted: RobustRows, share: float = 1.0
) -> bool:
    """Whether a fit leaves little unexplained, or would if it left a `share` of that."""
    left, before = share * missing(case, fitted), missing(case, given.fitted)
    needed = EXPLAINED_SHARE
    if case.path.moves and _is_white(fitted) and not _is_white(given.fitted):
        needed = EXPLAINED_IF_WHITE
    return left < NEGLIGIBLE_UNEXPLAINED or left < (1.0 - needed) * before


def _is_preferable(
    case: Case, given: Explanation, other: Explanation, best: Explanation
) -> bool:
    """Whether an explanation has fewer unknowns than the best one, or is as likely."""
    simpler = other.unknowns < best.unknowns
    return simpler or evidence(case, given, other) >= evidence(case, given, best)


def _is_white(fitted: RobustRows) -> bool:
    return correlation(fitted) < CLEAR_CORRELATION


def _simplest(
    case: Case, given: Explanation, best: Explanation, tried: list[Explanation]
) -> Explanation:
    """The likeliest mistake with far fewer unknowns that explains nearly as much as the
    best one, else the best: flexible explanations imitate simple ones."""
    before = missing(case, given.fitted)
    needed = NEARLY * (before - missing(case, best.fitted))
    simpler = [
        each
        for each in tried
        if each.unknowns < best.unknowns - SIMPLER
        and before - missing(case, each.fitted) > needed
        and _is_named(case, given, each)
    ]
    return max(simpler, key=lambda each: evidence(case, given, each), default=best)

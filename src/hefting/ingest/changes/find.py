"""Finding changes: from the robust fit of a recording to its stretches.

A recording is examined only if one change would explain much more than none, or a long
contact was rejected. It is divided into the intervals of least cost; intervals with the
same body are joined, and those that no body explains are contacts. The result is used
only if the bodies and contacts explain the wrench to the sensor's noise.
"""

from itertools import pairwise

import numpy as np

from hefting.core.progress import each
from hefting.core.spatial import Array
from hefting.ingest.changes.assignment import NO_BODY, Assignment, Part, assign
from hefting.ingest.changes.bodies import (
    PARAMETERS,
    JointFit,
    JointModel,
    autocorrelation,
    is_suspicious,
    variance_of_any_linear_function,
    with_noise_scale,
)
from hefting.ingest.changes.cells import Cells, cells_of, has_long_contact
from hefting.ingest.changes.stretches import (
    BARE_SHARE,
    Changes,
    EventKind,
    Stretch,
    Touch,
    center_of_mass,
    event_between,
    with_returns,
)
from hefting.ingest.channels import rounding_error
from hefting.ingest.conditioned import SIGNIFICANT
from hefting.ingest.robust_fit import RobustFit
from hefting.ingest.samples import Samples

FEWEST_CELLS = 20
"""Least number of cells in which changes are searched for."""
EXPLAINED_VARIANCE = 3.0
"""Variance of the residuals, over that of the sensor's noise, up to which bodies
explain the wrench. Without contacts it is 1 in simulated recordings and up to 5 in
those of a capacitive sensor."""
LARGEST_VARIANCE_BESIDE_CONTACT = 8.0
"""The same above which no contact is reported."""
BETTER_EXPLAINED = 0.8
"""Variance of the residuals of any linear function of the motion over that of several
bodies, up to which no change is reported."""
POORLY_EXPLAINED_VARIANCE = 30.0
"""Variance above which no change is reported, as there is another error."""
SHORTEST_TOUCH = 0.7
"""[s] Shorter contacts are left to the robust fit."""
LONGEST_PUSH = 3.0
"""[s] A body between two stretches of another one was held if it lasts longer: hands
that push the object are not as steady as a weight."""
BRIEF_END, BRIEF_SHARE = 10, 0.1
"""Cells, and share of the recording, up to which another body at an end is no change
unless it is far lighter: a hand's tremor there had been slips of 15 mm."""
SHORTEST_STRETCH = 1.5
"""[s] Shortest duration of the longest stretch for changes to be reported."""
OFFSETS = (0.05, -0.05, 0.1, -0.1, 0.15, 0.2, 0.25, 0.3)
"""[s] Clock offsets that are tried if bodies explain the wrench at that of the robust
fit and at none in less than half of the recording: a fit of one body is misled by two."""
NEGLIGIBLE_OFFSET = 0.02
"""[s] Clock offset above which it is tried whether none explains more."""
SAME_BODY = 18.3
"""Increase of the sum of squares, over their variance and autocorrelation time, up to
which stretches before and after a contact are used together: 95 % of a chi-squared of
ten degrees of freedom. A slip of 2 mm between them is 100, in the median of 25 simulated
recordings; without a slip 8, in nine of ten."""
MARGIN = 0.05
"""[s] Time at each change that is excluded from the stretches beside it."""


def find_changes(samples: Samples, found: RobustFit, start: float) -> Changes | None:
    """Stretches of a recording in which the object changes or is touched; None where it
    does not.

    Parameters
    ----------
    samples : the wrench as recorded.
    found : its robust fit, as if there were one body.
    start : [s] time of the recording's first sample.
    """
    if samples.static:
        return None
    try:
        cells = _cells(samples, found, found.fit.offset)
        if cells is None or not (
            has_long_contact(samples, found.outliers) or is_suspicious(cells)
        ):
            return None
        best = _best_offset(samples, found, cells)
        return None if best is None else _changes(best, start)
    except np.linalg.LinAlgError:  # numbers of a size that no wrench has
        return None


def _cells(samples: Samples, found: RobustFit, offset: float) -> Cells | None:
    """Cells with their noise scale; None where there are too few."""
    cells = cells_of(samples, found.problem, found.fit, found.outliers, offset)
    if cells is None or len(cells) < FEWEST_CELLS:
        return None
    return with_noise_scale(cells, rounding_error(samples.wrench))


def _best_offset(samples: Samples, found: RobustFit, cells: Cells) -> Assignment | None:
    """The assignment at the clock offset at which bodies explain the wrench best; None
    where they explain little."""
    best = assign(cells)
    if found.problem.path.moves:
        others = [0.0] if abs(found.fit.offset) > NEGLIGIBLE_OFFSET else []
        best = _better(best, samples, found, others)
        if best is None or not _is_explained(best):
            best = _better(best, samples, found, list(OFFSETS))
    if best is None or best.variance > POORLY_EXPLAINED_VARIANCE:
        return None
    return best


def _better(
    best: Assignment | None, samples: Samples, found: RobustFit, offsets: list[float]
) -> Assignment | None:
    tried = [best]
    for offset in each("looking for changes of the object", offsets):
        cells = _cells(samples, found, offset)
        tried.append(None if cells is None else assign(cells))
    return min((a for a in tried if a is not None), key=_unexplained, default=None)


def _is_explained(assignment: Assignment) -> bool:
    """Whether bodies explain the wrench in half of the recording or more."""
    poor, with_body = _unexplained(assignment)
    return not poor and -with_body >= 0.5 * float(np.ptp(assignment.cells.time))


def _unexplained(assignment: Assignment) -> tuple[bool, float]:
    """Sort key of assignments, the best first: those with small residuals by the time
    without a body [s], less the duration; then the others by their residuals."""
    cells = assignment.cells
    without = sum(
        cells.last[end - 1] - cells.first[begin]
        for (begin, end), label in zip(
            assignment.model.intervals, assignment.labels, strict=True
        )
        if label == NO_BODY
    )
    duration = float(np.ptp(cells.time))
    poor = assignment.variance > EXPLAINED_VARIANCE
    return poor, assignment.variance if poor else float(without) - duration


def _changes(found: Assignment, start: float) -> Changes | None:
    """The stretches with their bodies, and the contacts; None where neither a change nor
    a contact is distinguished from an error that lasts all the time."""
    parts = _without_excursions(found)
    touches = _touches(found, parts, start)
    if not (_is_contact(found) if touches else _is_change(found, parts)):
        return None
    stretches = _described(found, parts, touches, start)
    if max(stretch.duration for stretch in stretches) < SHORTEST_STRETCH:
        return None
    duration = float(found.cells.last[-1] - found.cells.first[0])
    return Changes(
        tuple(stretches), tuple(touches), duration, _may_differ(found, parts)
    )


def _without_excursions(found: Assignment) -> list[Part]:
    """The stretches without short ones between two of another body, in which something
    touched the object; brief ones at the ends belong to their neighbours. One stays if
    either body is a bare gripper: an object was picked up or put down."""
    parts, cells = found.stretches, found.cells
    names = sorted({label for label in found.labels if label != NO_BODY})
    mass = {
        name: abs(float(m))
        for name, m in zip(names, found.fit.bodies[:, 0], strict=True)
    }

    def is_brief(part: Part, beside: Part, longest: float) -> bool:
        lighter, heavier = sorted((mass[part.label], mass[beside.label]))
        lasts = cells.last[part.end - 1] - cells.first[part.begin] > longest
        return lighter > BARE_SHARE * heavier and not lasts

    kept = parts[:1]
    for i, now in enumerate(parts[1:], start=1):
        before = kept[-1].label
        returns = i + 1 < len(parts) and parts[i + 1].label == before != now.label
        if not (returns and is_brief(now, kept[-1], LONGEST_PUSH)):
            kept.append(now)
    lasts = cells.last[-1] - cells.first[0]
    brief = min(BRIEF_END * cells.interval, BRIEF_SHARE * lasts)
    if len(kept) > 1 and is_brief(kept[-1], kept[-2], brief):
        kept[-2:] = [kept[-2]._replace(end=kept[-1].end)]
    if len(kept) > 1 and is_brief(kept[0], kept[1], brief):
        kept[:2] = [kept[1]._replace(begin=kept[0].begin)]
    return kept


def _otherwise(found: Assignment) -> float:
    """Variance of the residuals of any linear function of the motion."""
    return float(variance_of_any_linear_function(found.cells).max())


def _is_change(found: Assignment, parts: list[Part]) -> bool:
    """Whether several bodies explain the wrench better than any linear function of the
    motion does, which an error that lasts all the time would be."""
    if len({part.label for part in parts}) < 2:
        return False
    return _otherwise(found) > BETTER_EXPLAINED * found.variance


def _is_contact(found: Assignment) -> bool:
    """Whether bodies and contacts explain the wrench far better than any linear function
    of the motion does."""
    if found.variance > LARGEST_VARIANCE_BESIDE_CONTACT:
        return False
    return _otherwise(found) > EXPLAINED_VARIANCE * max(found.variance, 1.0)


def _touches(found: Assignment, parts: list[Part], start: float) -> list[Touch]:
    cells = found.cells
    begins = [0, *(part.end for part in parts)]
    ends = [*(part.begin for part in parts), len(cells)]
    gaps = [
        Touch(float(cells.first[begin]) - start, float(cells.last[end - 1]) - start)
        for begin, end in zip(begins, ends, strict=True)
        if end > begin
    ]
    return [gap for gap in gaps if gap.end - gap.start >= SHORTEST_TOUCH]


def _described(
    found: Assignment, parts: list[Part], touches: list[Touch], start: float
) -> list[Stretch]:
    """The stretches with their bodies, by a joint fit, and the events that end them."""
    cells, labels = found.cells, [part.label for part in parts]
    intervals = [(part.begin, part.end) for part in parts]
    fit = JointModel(cells, intervals, drift=1).fit(labels)
    if _mass_is_open(fit):
        fit = JointModel(cells, intervals, drift=0).fit(labels)
    names = sorted(set(labels))
    sign = 1.0 if fit.bodies[np.argmax(np.abs(fit.bodies[:, 0])), 0] >= 0.0 else -1.0
    bodies = [sign * fit.bodies[names.index(label)] for label in labels]
    times = [_times(cells, begin, end, start) for begin, end in intervals]
    masses = [float(body[0]) for body in bodies]
    events = with_returns(
        _events(fit, labels, bodies, times, touches, found.tau), labels, masses
    )
    stretches = []
    for i, (first, last) in enumerate(times):
        bare = events[i] == "picked-up" or (i > 0 and events[i - 1] == "put-down")
        com = center_of_mass(bodies[i], max(masses))
        stretches.append(Stretch(first, last, masses[i], com, events[i], bare))
    return stretches


def _may_differ(found: Assignment, parts: list[Part]) -> bool:
    """Whether a body may not have been the same before and after a contact, as bodies of
    their own fit the stretches better by more than chance."""
    again = [i for i, (a, b) in enumerate(pairwise(parts)) if a.label == b.label]
    if not again:
        return False
    intervals = [(part.begin, part.end) for part in parts]
    model = JointModel(found.cells, intervals, drift=1)
    own = model.fit(list(range(len(parts))))
    white = max(float(own.variance.max()), 1.0) * autocorrelation(model.residuals(own))
    return any(own.increase(i, i + 1) > SAME_BODY * white for i in again)


def _mass_is_open(fit: JointFit) -> bool:
    heaviest = int(np.argmax(np.abs(fit.bodies[:, 0])))
    std = np.sqrt(fit.covariance[heaviest * PARAMETERS, heaviest * PARAMETERS])
    return bool(abs(fit.bodies[heaviest, 0]) < SIGNIFICANT * std)


def _times(cells: Cells, begin: int, end: int, start: float) -> tuple[float, float]:
    """Start and end [s] of a stretch of cells, without a margin at each change."""
    first = cells.first[begin] + (MARGIN if begin > 0 else 0.0)
    last = cells.last[end - 1] - (MARGIN if end < len(cells) else 0.0)
    return float(first) - start, float(last) - start


def _events(
    fit: JointFit,
    labels: list[int],
    bodies: list[Array],
    times: list[tuple[float, float]],
    touches: list[Touch],
    tau: float,
) -> list[EventKind | None]:
    """The event that ends each stretch; None for the end of the recording."""
    names, events = sorted(set(labels)), []
    for i in range(len(labels) - 1):
        if labels[i] == labels[i + 1]:
            events.append("touched")
            continue
        one, other = names.index(labels[i]), names.index(labels[i + 1])
        white = fit.difference(one, other)[1][0, 0] * max(float(fit.variance[0]), 1.0)
        std = float(np.sqrt(white * tau))
        events.append(event_between(bodies[i], bodies[i + 1], std))
    last = times[-1][1] - 2.0 * MARGIN
    touched = any(touch.start >= last for touch in touches)
    return [*events, "touched" if touched else None]

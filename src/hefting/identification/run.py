"""From recordings to a method's estimate: what is known of all, and how each of them is
handed to the method."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.estimators import Estimator
from hefting.identification.contradictions import with_contradictions
from hefting.identification.seen import state_of, taken
from hefting.identification.stopping import first_sufficient, with_stop_reason
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import JointIngested, together, with_samples
from hefting.ingest.several import Log, ingest_all


def understand(recording: Log | Sequence[Log], **reading: Any) -> Ingested:
    """One recording, or several of the same object, as estimators take them; with a
    message for each that contradicts the others. For arguments and errors see
    `identify`."""
    return with_contradictions(ingest_all(recording, **reading))


def run(estimator: Estimator, found: Ingested) -> tuple[Estimate, Ingested]:
    """The estimate, and the recording as far as it was used: no farther than an
    accuracy `asked` for takes."""
    if estimator.asked is None:
        states = [state_of(estimator, part) for part in found.recordings]
        return estimator.estimate(estimator.merge_all(states)), found
    if not found.has_samples:
        raise InputError(
            "an accuracy to stop at (`until`) needs the samples in order",
            found.log,
            "leave it out, or identify the recordings themselves",
        )
    return _first_sufficient(estimator, found)


def _first_sufficient(
    estimator: Estimator, found: Ingested
) -> tuple[Estimate, Ingested]:
    """The first sufficient estimate, one recording after the other, and the recordings
    as far as they were used."""
    assert estimator.asked is not None
    before, estimate, parts = estimator.start(), None, []
    samples = [taken(estimator, part) for part in found.recordings]
    for part, z in zip(found.recordings, samples, strict=True):
        is_last = part is found.recordings[-1]
        try:
            estimate, used = first_sufficient(estimator, z, part.static, before)
        except NotIdentifiableError:
            if is_last:
                raise
            used = len(z)
        own = replace(part, measurements=part.measurements[:used], kept=None)
        parts.append(replace(own, counts=part.counts[:used]))
        if estimate is not None and estimate.sufficient:
            break
        if not is_last:
            seen = estimator.update(estimator.start(), z)
            before = estimator.merge(before, seen)
    assert estimate is not None
    if found.static:
        used, whole, unit = (
            sum(len(p.counts) for p in parts),
            sum(map(len, samples)),
            "poses",
        )
    else:
        used = sum(float(np.ptp(part.measurements.time)) for part in parts)
        whole, unit = sum(float(np.ptp(z.time)) for z in samples), "s"
    estimate = with_stop_reason(estimate, estimator.asked, used, whole, unit)
    return estimate, _used(found, parts)


def _used(found: Ingested, parts: list[Ingested]) -> Ingested:
    """The recordings as far as they were used, with what was said of all."""
    if not isinstance(found, JointIngested):
        return parts[0]
    again = with_samples(together(parts, found.names[: len(parts)]))
    return replace(again, warnings=found.warnings)

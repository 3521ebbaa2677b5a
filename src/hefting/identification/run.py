"""From ingested recordings to a method's estimate, stopping at a wanted accuracy."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.messages import warning
from hefting.core.sensor_accuracy import TYPICAL, SensorAccuracy
from hefting.estimators.base import Estimator
from hefting.estimators.joint_state import State
from hefting.identification.contradictions import with_contradictions
from hefting.identification.estimator import out_of_order, state_of, taken
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import JointIngested, Log, ingest_all, together, with_samples

SAMPLES_BEFORE_FIRST_CHECK = 50
"""Number of samples before the first estimate; static poses are checked from the first
one on."""
SHORTEST_CHECK_INTERVAL = 0.1
"""[s] Shortest time between two estimates."""
CHECK_INTERVAL_SHARE = 0.02
"""Time between two estimates as a share of the recording so far, if longer."""


def understand(
    recording: Log | Sequence[Log],
    accuracy: SensorAccuracy | str | None = None,
    **reading: Any,
) -> Ingested:
    """One recording, or several of the same object, as estimators take them; with a
    message for each that contradicts the others. For arguments and errors see
    `hefting.identify`; `accuracy` is the sensor's."""
    found = ingest_all(recording, accuracy=accuracy, **reading)
    return with_contradictions(found, accuracy)


def run(
    estimator: Estimator, found: Ingested, stop: bool = True
) -> tuple[Estimate, Ingested]:
    """The estimate, and the used part of the recording: with `stop` only as much as the
    estimator's accuracy `asked` for requires."""
    asked = estimator.asked
    if asked is None or not stop:
        states = [state_of(estimator, part) for part in found.recordings]
        estimate = estimator.estimate(estimator.merge_all(states))
        if asked is not None:
            whole = [part.measurements for part in found.recordings]
            estimate = _with_stop_reason(
                estimate, estimator, whole, whole, found.static
            )
        return estimate, found
    if not found.has_samples:
        raise out_of_order(found)
    return _first_sufficient(estimator, found)


def _first_sufficient(
    estimator: Estimator, found: Ingested
) -> tuple[Estimate, Ingested]:
    """The first sufficient estimate over successive recordings, and their used part."""
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
    seen = [part.measurements for part in parts]
    estimate = _with_stop_reason(estimate, estimator, seen, samples, found.static)
    if not isinstance(found, JointIngested):
        return estimate, parts[0]
    again = with_samples(together(parts, found.names[: len(parts)]))
    return estimate, replace(again, warnings=found.warnings)


def first_sufficient(
    estimator: Estimator,
    measurements: Measurements,
    static: bool = False,
    before: State | None = None,
) -> tuple[Estimate, int]:
    """The first sufficient estimate and its number of samples, or if none suffices that
    of all samples.

    The samples are in order of time, or static poses; `before` is the state of other
    recordings, which were seen whole. Errors as for the `estimate` of all samples.
    """
    z = measurements
    state, estimate, seen = estimator.start(), None, 0
    for end in _sample_counts_at_checks(z, static):
        state, seen = estimator.update(state, z[seen:end]), end
        try:
            seen_in_all = state if before is None else estimator.merge(before, state)
            estimate, _ = estimator.continued(seen_in_all, estimate)
        except NotIdentifiableError:
            if seen == len(z):
                raise
            continue
        if estimate.sufficient:
            break
    assert estimate is not None
    return estimate, seen


def _with_stop_reason(
    estimate: Estimate,
    estimator: Estimator,
    seen: Sequence[Measurements],
    whole: Sequence[Measurements],
    static: bool,
) -> Estimate:
    """`estimate` with the part `seen` of the `whole` recordings in its provenance, and a
    warning if it does not suffice."""
    asked, got = estimator.asked, estimate.accuracy
    assert asked is not None
    assert got is not None
    if static:
        used, of, unit = sum(map(len, seen)), sum(map(len, whole)), "poses"
    else:
        used, of = (sum(float(np.ptp(z.time)) for z in a) for a in (seen, whole))
        unit = "s"
    provenance = estimate.provenance | {
        "until": str(asked),
        "used": used,
        "of": of,
        "used_unit": unit,
    }
    warnings = estimate.warnings
    if not estimate.sufficient:
        why = asked.shortfall(got) or "the wrench contradicts the shape or the scale"
        sensor = getattr(estimator, "sensor_accuracy", None) or TYPICAL
        if asked.mass is not None and asked.mass < sensor.share:
            why += (
                f"; the sensor's gain is taken as known to {100.0 * sensor.share:.3g}% "
                "(`sensor_accuracy`), and no motion improves it"
            )
        doubt = warning("accuracy-not-reached", f"not as sure as asked for: {why}")
        warnings = (doubt, *warnings)
    return replace(estimate, warnings=warnings, provenance=provenance)


def _sample_counts_at_checks(z: Measurements, static: bool) -> list[int]:
    """Increasing numbers of samples, up to all K, after which the estimate is computed
    and checked: static poses one by one, others after `SHORTEST_CHECK_INTERVAL`, or
    `CHECK_INTERVAL_SHARE` of the time elapsed where that is longer."""
    K = len(z)
    if static:
        return list(range(1, K + 1))
    elapsed = z.time - z.time[0]
    counts = []
    count = min(SAMPLES_BEFORE_FIRST_CHECK, K)
    while count < K:
        counts.append(count)
        now = elapsed[count - 1]
        next_check = now + max(SHORTEST_CHECK_INTERVAL, CHECK_INTERVAL_SHARE * now)
        until_check = int(np.searchsorted(elapsed, next_check, side="right"))
        count = max(until_check, count + 1)
    return [*counts, K]

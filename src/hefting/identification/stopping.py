"""Stopping rule: the first part of a recording whose estimate reaches the accuracy
that was asked for."""

from dataclasses import replace

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.messages import warning
from hefting.estimators.base import Estimator
from hefting.estimators.joint_state import State

SAMPLES_BEFORE_FIRST_CHECK = 50
"""Number of samples before the first estimate; static poses are checked from the first
one on."""
SHORTEST_CHECK_INTERVAL = 0.1
"""[s] Shortest time between two estimates."""
CHECK_INTERVAL_SHARE = 0.02
"""Time between two estimates as a share of the recording so far, where that is
longer."""


def first_sufficient(
    estimator: Estimator,
    measurements: Measurements,
    static: bool = False,
    before: State | None = None,
) -> tuple[Estimate, int]:
    """The first sufficient estimate and how many samples it took; or that of all, where
    none is.

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


def with_stop_reason(
    estimate: Estimate, asked: Accuracy, used: float, whole: float, unit: str
) -> Estimate:
    """`estimate` with `used` of the `whole` recording in its provenance, and a warning
    where it does not suffice."""
    assert estimate.accuracy is not None
    provenance = estimate.provenance | {
        "until": str(asked),
        "used": used,
        "of": whole,
        "used_unit": unit,
    }
    warnings = estimate.warnings
    if not estimate.sufficient:
        why = (
            asked.shortfall(estimate.accuracy)
            or "the wrench contradicts the shape or the scale"
        )
        doubt = warning("accuracy-not-reached", f"not as sure as asked for: {why}")
        warnings = (doubt, *warnings)
    return replace(estimate, warnings=warnings, provenance=provenance)


def _sample_counts_at_checks(z: Measurements, static: bool) -> list[int]:
    """Numbers of samples after which the estimate is computed and checked.

    Parameters
    ----------
    z : Measurements
        K samples in order of time, or K static poses.
    static : bool
        Whether the samples are static poses; these are checked one by one.

    Returns
    -------
    list of int
        Increasing counts; the last one is K. The interval between two checks is
        `SHORTEST_CHECK_INTERVAL`, or `CHECK_INTERVAL_SHARE` of the time elapsed
        where that is longer.
    """
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
        samples_until_check = int(np.searchsorted(elapsed, next_check, side="right"))
        count = max(samples_until_check, count + 1)
    return [*counts, K]

"""Convergence: what a method would have said after each part of a recording."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array
from hefting.estimators import Estimator
from hefting.estimators.joint_state import State
from hefting.identification.seen import taken
from hefting.ingest.ingested import Ingested

INSTANTS = 20
"""Instants at which a recording is looked at."""


@dataclass(frozen=True, eq=False)
class Convergence:
    """Estimates from the samples up to each of n instants, by one method.

    Clock, bias drift, sign and outliers are those found from the whole recording.
    """

    rows: np.ndarray
    """(n,) number of measurements seen, increasing; the last is all of them"""
    values: Array
    """(n, 10) mass [kg], COM [m] and inertia at the COM [kg m²], as xx, xy, xz, yy, yz,
    zz"""
    low: Array | None
    """(n, 10) lower ends of their 95 % intervals, minus infinity where open; None where
    the method has none"""
    high: Array | None
    """(n, 10) upper ends"""


def convergence(
    estimator: Estimator, found: Ingested, final: Estimate, count: int = INSTANTS
) -> Convergence:
    """How an estimate of a recording came about.

    Parameters
    ----------
    estimator : Estimator
        That made it.
    found : Ingested
        The recording as far as it was used; several are seen one after the other.
    final : Estimate
        Its estimate from all of that, which is the last one.
    count : int
        Instants, evenly over the measurements. Those at which nothing can be told yet
        are left out.
    """
    seen, estimates = [], []
    last: Estimate | None = None
    for rows, state in _states(estimator, found, count):
        try:
            last, _ = estimator.continued(state, last)
        except NotIdentifiableError:
            continue
        seen.append(rows)
        estimates.append(last)
    seen.append(len(found.measurements))
    estimates.append(final)
    ends = [each.intervals for each in estimates]
    known = [ten_ends(end) for end in ends if end is not None]
    known = known if len(known) == len(ends) else None
    return Convergence(
        np.array(seen),
        np.array([ten_of(each.parameters) for each in estimates]),
        None if known is None else np.array([low for low, _ in known]),
        None if known is None else np.array([high for _, high in known]),
    )


def ten_of(body: InertialParameters) -> Array:
    """(10,) mass [kg], COM [m] and inertia at the COM [kg m²] of a body."""
    tensor = body.inertia_at_com[TENSOR_ROWS, TENSOR_COLUMNS]
    return np.concatenate(([body.mass], body.center_of_mass, tensor))


def ten_ends(intervals: dict[str, Array]) -> tuple[Array, Array]:
    """(10,) lower and upper ends of `Estimate.intervals`, as `ten_of` has them."""
    low, high = (
        np.concatenate(
            (
                [intervals["mass"][end]],
                intervals["center_of_mass"][end],
                intervals["inertia_at_com"][end][TENSOR_ROWS, TENSOR_COLUMNS],
            )
        )
        for end in (0, 1)
    )
    return low, high


def _states(
    estimator: Estimator, found: Ingested, count: int
) -> Iterator[tuple[int, State]]:
    """Number of measurements seen, and the state then, at all instants but the last."""
    total = len(found.measurements)
    instants = np.unique(np.linspace(0, total, count + 1).astype(int))[1:-1]
    before, begin = estimator.start(), 0
    for part in found.recordings:
        z = taken(estimator, part)
        state, seen = estimator.start(), 0
        for rows in instants[(instants > begin) & (instants <= begin + len(z))]:
            state, seen = _seen(estimator, state, z, seen, int(rows) - begin)
            yield int(rows), estimator.merge(before, state)
        state, _ = _seen(estimator, state, z, seen, len(z))
        before, begin = estimator.merge(before, state), begin + len(z)


def _seen(
    estimator: Estimator, state: State, z: Measurements, seen: int, until: int
) -> tuple[State, int]:
    """The state of one recording with its samples from `seen` on."""
    return estimator.update(state, z[seen:until]), until  # type: ignore[arg-type]

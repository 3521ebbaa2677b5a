"""What a method sees of a recording: its samples, with the weights that it goes by, or
the state that was made of them before."""

from dataclasses import replace

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements
from hefting.estimators import Estimator
from hefting.estimators.joint_state import State
from hefting.ingest.ingested import Ingested


def state_of(estimator: Estimator, part: Ingested) -> State:
    """What a method sees of one recording.

    Raises `InputError` where the recording's samples are gone, and what was kept of
    them is not what the method takes.
    """
    how = estimator.sampling
    state = None if how is None else part.condensed.states.get(how)
    if state is None:
        if not part.has_samples:
            raise InputError(
                f"was condensed for another method than {estimator.name}",
                part.log,
                "condense it with the method and hyperparameters that identify it",
            )
        z = taken(estimator, part)
        return estimator.update(estimator.start(), z)
    if estimator.start().record is None:
        state = replace(state, record=None)
    count = part.samples / part.rows
    return state.scaled(count) if estimator.depends_on_count else state


def taken(estimator: Estimator, part: Ingested) -> Measurements:
    """A recording's measurements, with the weights that a method goes by."""
    return part.weighted_by_count if estimator.depends_on_count else part.measurements

"""Parts: one object in many recordings, each condensed where its data lie.

::

    parts = [condense(log, shape) for log in logs]              # anywhere, in any order
    again = what_others_tell(parts)                             # mostly {} of each
    parts = [condense(log, shape, **how) if how else part ...]
    found = identify_parts(parts, shape)                        # as identify(logs, shape)

A part is a recording as it was understood, without its samples: some ten triangular
factors of their sums. The estimate is that of all samples together, not a mean of
estimates, with a bias, a clock, a drift and a weight of each recording. Parts may be
pickled; between machines that trust one another, as any pickle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from hefting.core.errors import InputError
from hefting.estimators import Estimator, default_method
from hefting.estimators.sample_state import SampleState
from hefting.identification.contradictions import with_contradictions
from hefting.identification.estimator import (
    accuracy_of,
    estimator_of,
    out_of_order,
    shape_of,
)
from hefting.identification.identify import Identification, identify_understood
from hefting.ingest.ingest import ingest
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import Log, joint, names_of, what_others_tell
from hefting.shapes import Shape

__all__ = ["condense", "identify_parts", "what_others_tell"]


def condense(
    recording: Log,
    shape: Shape | None = None,
    *,
    method: str | Estimator | None = None,
    hyperparameters: Mapping[str, Any] | None = None,
    **reading: Any,
) -> Ingested:
    """What joint identification needs of one recording, without its samples.

    Parameters
    ----------
    recording : a recording or the path of a log.
    shape, method, hyperparameters : as `identify_parts` will be given them; a shape
        that is only to be known there may be left out where the method needs none.
    reading : the other arguments of `hefting.identify`: ``gravity``, ``wrench``,
        ``bias`` and so on.

    Returns
    -------
    Ingested
        Without samples; less than 200 kB however long the recording is.

    Raises
    ------
    InputError
        As `hefting.identify` does for the recording, the method and its
        hyperparameters.
    """
    accuracy = accuracy_of(method, hyperparameters or {})
    found = ingest(recording, accuracy=accuracy, **reading)
    return part_of(found, shape, method, hyperparameters)


def part_of(
    found: Ingested,
    shape: Shape | None = None,
    method: str | Estimator | None = None,
    hyperparameters: Mapping[str, Any] | None = None,
) -> Ingested:
    """As `condense`, for a recording that was ingested."""
    settings = dict(hyperparameters or {})
    shape = shape_of(method, shape, settings)
    chosen = default_method(shape is not None) if method is None else method
    kept = found.condensed
    states = dict(kept.states)
    for estimator in _possible_estimators(chosen, found, shape, settings):
        _require_parts(estimator, found)
        how = estimator.sampling
        if how is not None and how not in states:
            seen = estimator.update(SampleState.empty(), found.measurements)
            # the time record of the full model holds all samples
            states[how] = replace(seen, record=kept.state.record)
    return replace(found, kept=replace(kept, states=states)).without_samples()


def identify_parts(
    parts: Sequence[Ingested],
    shape: Shape | None = None,
    *,
    names: Sequence[str] | None = None,
    method: str | Estimator | None = None,
    hyperparameters: Mapping[str, Any] | None = None,
) -> Identification:
    """Identify one object from its recordings, each of which was condensed.

    Parameters
    ----------
    parts : of `condense`, with the same shape, method and hyperparameters.
    shape, method : as for `hefting.identify`.
    names : what to call each in messages; by default after the logs.
    hyperparameters : of the method, by name.

    Returns
    -------
    Identification
        As `hefting.identify` gives for the recordings, with measurements (0,).

    Raises
    ------
    InputError
        As `hefting.identify`; for no parts, and for parts that were condensed for
        another method.
    NotIdentifiableError
        Where all recordings together determine nothing.
    """
    if not parts:
        raise InputError("no recording is given", fix="give at least one")
    settings = dict(hyperparameters or {})
    shape = shape_of(method, shape, settings)
    called = names_of([part.log for part in parts]) if names is None else list(names)
    found = with_contradictions(joint(parts, called), accuracy_of(method, settings))
    return identify_understood(found, shape, method, settings)


def _possible_estimators(
    method: str | Estimator,
    found: Ingested,
    shape: Shape | None,
    hyperparameters: dict[str, Any],
) -> list[Estimator]:
    """The estimators that may be made once all parts are known. A model's c1 follows from
    the source of most of their motion, which is not known yet: each source is tried."""
    if isinstance(method, Estimator):
        return [method]
    sources = (found.source, "smooth", "columns")
    return [
        estimator_of(method, replace(found, source=source), shape, hyperparameters)
        for source in dict.fromkeys(sources)
    ]


def _require_parts(estimator: Estimator, found: Ingested) -> None:
    if estimator.asked is not None:
        raise out_of_order(found)
    if estimator.sampling is None:
        what = f"{estimator.name} has an `update` of its own, and no `sampling`"
        raise InputError(what, fix="declare what its `update` depends on")

"""The part of a recording in which one body was held, and a mistake in it."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.recording import Recording
from hefting.core.spatial import immutable, in_sensor_axes
from hefting.ingest.changes.stretches import Changes, Stretch
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.consequence import Doubt, doubt_of
from hefting.ingest.weights import may_be_acceleration, weights_at_rest

MOST_MORE_KNOTS = 6
"""Largest number of knots, beyond two, of the drift beside which mistakes are judged."""

Condition = Callable[[Recording], Conditioned]


@immutable
class ChosenPart:
    """The recording, or its stretches of one free body that are used."""

    recording: Recording
    found: Conditioned
    """conditioning of that part"""
    doubt: Doubt | None
    """a mistake in it, or that much of it is unexplained"""
    changes: Changes | None = None
    """of the object in the whole recording"""


def choose_part(
    recording: Recording,
    found: Conditioned,
    fit: Condition,
    *,
    may_be_biased: bool,
    tool: Estimate | None,
    as_given: bool,
    sensor_errors: float,
) -> ChosenPart:
    """The part of a recording to use: where the object changes its longest stretch, if
    possible with an object in the hand, else all of it.

    Stretches that only contacts divide from that one are used too, unless together they
    are in doubt. All of it is used if a mistake explains it, or the part was given. `fit`
    conditions a part without looking for changes; `sensor_errors` as in `Case`.
    """
    with_tool, changes = tool is not None, found.changes
    case_of = partial(_case, may_be_biased=may_be_biased, sensor_errors=sensor_errors)
    case = case_of(recording, found)
    may_change = changes is not None and not as_given
    whole = doubt_of(case, with_tool=with_tool, pairs=not may_change)
    if may_change and whole is not None and whole.needs_no_change:
        whole = doubt_of(case, with_tool=with_tool)
    if changes is None or (whole is not None and whole.needs_no_change):
        return ChosenPart(recording, found, whole)
    if tool is not None:
        changes = changes.beside(tool.parameters.vector)
    if as_given:
        return ChosenPart(recording, found, whole, changes)

    def judged(changes: Changes) -> tuple[Recording, Conditioned, Doubt | None]:
        part = _during(recording, changes.used)
        of_part = fit(part)
        alone, case = len(changes.used) == 1, case_of(part, of_part)
        return part, of_part, doubt_of(case, with_tool=with_tool, pairs=alone)

    part, of_part, doubt = judged(changes)
    if doubt is not None and len(changes.used) > 1:
        changes = replace(changes, alone=True)
        part, of_part, doubt = judged(changes)
    if doubt is not None and doubt.is_fatal:
        # two mistakes at once may imitate a change
        whole = doubt_of(case, with_tool=with_tool)
        if whole is not None and whole.needs_no_change:
            return ChosenPart(recording, found, whole)
    return ChosenPart(part, of_part, doubt, changes)


def _during(recording: Recording, stretches: tuple[Stretch, ...]) -> Recording:
    """The recording from the first stretch to the last, with the wrench in stretches
    alone."""
    first, start = stretches[0].start, recording.start
    part = recording.slice(first, stretches[-1].end - first)
    wrench = part["wrench"]
    time = wrench.time - start
    inside = np.any([(s.start <= time) & (time < s.end) for s in stretches], axis=0)
    return replace(part, streams={**part.streams, "wrench": wrench[inside]})


def _case(
    recording: Recording,
    found: Conditioned,
    *,
    may_be_biased: bool,
    sensor_errors: float,
) -> Case | None:
    """The case on which mistakes are judged, None if there is none. If what is
    unexplained may be accelerations of a sensor of unknown position, only samples at
    rest count."""
    if found.path is None:
        return None
    case = Case.of(
        recording,
        found.path,
        found.gravity,
        found.offset,
        biased=may_be_biased,
        parameters=found.parameters,
    )
    case = replace(case, sensor_errors=sensor_errors)
    # mistakes are judged beside the drift that is removed
    case = case.with_drift(min(max(len(found.bias.knots) - 2, 0), MOST_MORE_KNOTS))
    if found.curves is None or not may_be_acceleration(recording, found):
        return case
    time, poses = case.time - case.offset, found.curves.poses
    known = poses.covers(time)
    motion = poses.at(time[known])
    gravity = in_sensor_axes(motion.orientation, found.gravity)
    mass, noise = abs(float(found.parameters[0])), float(case.noise[0])
    rest = np.zeros(len(time))
    rest[known] = weights_at_rest(motion, gravity, mass, noise)
    return None if rest[known].all() else replace(case, worth=case.worth * rest)

"""Part: which part of a recording one body was held in, and what mistake is in it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.immutable import immutable
from hefting.core.recording import Recording
from hefting.core.spatial import in_sensor_axes
from hefting.ingest.changes.stretches import Changes
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.consequence import Doubt, doubt_of
from hefting.ingest.weights import may_be_acceleration, weights_at_rest

Condition = Callable[[Recording], Conditioned]


@immutable
class ChosenPart:
    """The recording, or the longest stretch of it with one free body."""

    recording: Recording
    found: Conditioned
    """of that part"""
    doubt: Doubt | None
    """a mistake in it, or that much of it is unexplained"""
    changes: Changes | None = None
    """those of the object in the whole recording"""


def choose_part(
    recording: Recording,
    found: Conditioned,
    fit: Condition,
    *,
    may_be_biased: bool,
    tool: Estimate | None,
    as_given: bool,
) -> ChosenPart:
    """The stretch that is used where the object changes, with an object in the hand if
    there is one; the whole where it does not, where a mistake explains all of it, or
    where the part was given.

    `fit` conditions a part of the recording, in which no changes are looked for.
    """
    with_tool, changes = tool is not None, found.changes
    case = _case(recording, found, may_be_biased=may_be_biased)
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
    stretch = changes.chosen
    part = recording.slice(stretch.start, stretch.duration)
    of_part = fit(part)
    doubt = doubt_of(
        _case(part, of_part, may_be_biased=may_be_biased), with_tool=with_tool
    )
    if doubt is not None and doubt.is_fatal:
        # beside two mistakes at once changes are found where there are none
        whole = doubt_of(case, with_tool=with_tool)
        if whole is not None and whole.needs_no_change:
            return ChosenPart(recording, found, whole)
    return ChosenPart(part, of_part, doubt, changes)


def _case(
    recording: Recording, found: Conditioned, *, may_be_biased: bool
) -> Case | None:
    """What mistakes in a recording are judged by: what rests alone where the rest may
    be accelerations of a sensor whose position nobody measured. None where none could
    be told."""
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

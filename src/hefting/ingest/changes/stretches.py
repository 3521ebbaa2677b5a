"""Stretches of a recording in which the same free body is held, the events between
them, and messages on these changes: when and what they were, and which part to use."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array, immutable

EventKind = Literal["picked-up", "put-down", "swapped", "slipped", "touched"]

BARE_SHARE = 0.2
"""Mass over that of the heavier body up to which a body is a bare gripper, or
nothing."""
SIGNIFICANT = 4.0
"""Number of standard deviations from which on two masses differ."""
SAME_MASS_SHARE = 0.05
"""Relative difference of two masses that a sensor's errors explain."""

TOOL_ALONE_SHARE = 0.02
"""Mass held beside a tool, over the tool's, up to which nothing is held."""

MOST_LISTED = 6
"""Number of events or parts in a message; JSON holds all."""

LONG_TOUCH_SHARE = 0.5
"""Share of a recording above which the duration of a contact is reported."""


@immutable
class Stretch:
    """A part of a recording in which one free body explains the wrench."""

    start: float
    """[s] since the first sample of the recording"""
    end: float
    """[s]"""
    mass: float
    """[kg] by least squares, with one bias for all stretches"""
    center_of_mass: Array | None
    """(3,) [m] in sensor axes; None where the mass is about zero"""
    event: EventKind | None
    """what ends it; None for the end of the recording"""
    bare: bool
    """whether the gripper is empty: an object is picked up after it, or was put down
    before"""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start

    def beside(self, tool: Array) -> "Stretch":
        """The stretch without a tool of parameters (10,)."""
        mass, com = self.mass - float(tool[0]), self.center_of_mass
        if abs(mass) <= TOOL_ALONE_SHARE * tool[0]:
            return replace(self, mass=0.0, center_of_mass=None, bare=True)
        if com is not None:
            com = (self.mass * com - tool[1:4]) / mass
        return replace(self, mass=mass, center_of_mass=com)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values."""
        com = self.center_of_mass
        return {
            "start": self.start,
            "end": self.end,
            "event": self.event,
            "mass": self.mass,
            "center_of_mass": None if com is None else com.tolist(),
        }


@immutable
class Touch:
    """A part of a recording in which no body explains the wrench."""

    start: float
    """[s] since the first sample of the recording"""
    end: float
    """[s]"""


@immutable
class Changes:
    """Stretches of a recording in which the object changes or is touched."""

    stretches: tuple[Stretch, ...]
    """in order, at least one"""
    touches: tuple[Touch, ...]
    """in order"""
    duration: float
    """[s] of the recording"""
    alone: bool = False
    """whether the chosen stretch is used without those beside it"""

    @property
    def chosen(self) -> Stretch:
        """The longest stretch, if possible with an object in the hand."""
        held = [s for s in self.stretches if not s.bare]
        return max(held or self.stretches, key=lambda stretch: stretch.duration)

    @property
    def used(self) -> tuple[Stretch, ...]:
        """The chosen stretch, and unless it is used alone those of the same body that
        only contacts divide from it."""
        begin = self.stretches.index(self.chosen)
        end = begin + 1
        if not self.alone:
            while begin > 0 and self.stretches[begin - 1].event == "touched":
                begin -= 1
            while (
                end < len(self.stretches) and self.stretches[end - 1].event == "touched"
            ):
                end += 1
        return self.stretches[begin:end]

    @property
    def gripper(self) -> Stretch | None:
        """The longest stretch of a bare gripper whose mass shows beside the object's that
        is in the chosen one."""
        used, bare = self.chosen, [s for s in self.stretches if s.bare]
        longest = max(bare, key=lambda stretch: stretch.duration, default=used)
        shows = longest.mass > SAME_MASS_SHARE * used.mass
        return longest if shows and not used.bare and longest.bare else None

    @property
    def touched(self) -> float:
        """[s] Total time in which no body explains the wrench."""
        return float(np.sum([t.end - t.start for t in self.touches]))

    def beside(self, tool: Array) -> "Changes":
        """The changes without a tool of parameters (10,): the tool alone is an empty
        gripper."""
        held = [stretch.beside(tool) for stretch in self.stretches]
        for i, (one, other) in enumerate(pairwise(held)):
            if one.event != "touched" and one.bare != other.bare:
                event = "picked-up" if one.bare else "put-down"
                held[i] = replace(one, event=event)
        return replace(self, stretches=tuple(held))

    def to_dicts(self) -> list[dict[str, Any]]:
        """The stretches, JSON-ready."""
        return [stretch.to_dict() for stretch in self.stretches]

    def later(self, seconds: float) -> "Changes":
        """The changes with times since `seconds` [s] before the recording's start."""

        return replace(
            self,
            stretches=tuple(
                replace(s, start=s.start + seconds, end=s.end + seconds)
                for s in self.stretches
            ),
            touches=tuple(
                Touch(t.start + seconds, t.end + seconds) for t in self.touches
            ),
        )


def event_between(before: Array, after: Array, std_of_difference: float) -> EventKind:
    """Kind of a change from one body to another.

    Parameters
    ----------
    before, after : (10,) parameters, with a positive mass for what is heavy.
    std_of_difference : of the masses [kg].
    """
    heavier = max(float(before[0]), float(after[0]))
    if before[0] <= BARE_SHARE * heavier:
        return "picked-up"
    if after[0] <= BARE_SHARE * heavier:
        return "put-down"
    apart = abs(float(after[0] - before[0]))
    if apart > max(SIGNIFICANT * std_of_difference, SAME_MASS_SHARE * heavier):
        return "swapped"
    return "slipped"


def with_returns(
    events: Sequence[EventKind | None], labels: Sequence[int], masses: Sequence[float]
) -> list[EventKind | None]:
    """Events that end stretches, corrected where a body is replaced and returns: the
    lighter of the two is then the gripper, and the heavier includes an object.

    Parameters
    ----------
    events : that end each stretch.
    labels : which body is in each.
    masses : [kg] of the bodies.
    """
    kinds = list(events)
    for i in range(1, len(labels) - 1):
        if labels[i - 1] == labels[i + 1] != labels[i]:
            for k in (i - 1, i):
                if kinds[k] == "swapped":
                    more = masses[k + 1] > masses[k]
                    kinds[k] = "picked-up" if more else "put-down"
    return kinds


def center_of_mass(body: Array, heaviest: float) -> Array | None:
    """(3,) [m]; None for a body (10,) whose mass is negligible beside the heaviest
    [kg]."""
    mass = float(body[0])
    if not mass > 0.02 * heaviest:
        return None
    return np.asarray(body[1:4] / mass)


def change_warnings(changes: Changes | None, *, chosen: bool) -> list[Message]:
    """Warnings of changes of the object; `chosen` is whether a stretch was chosen, not
    given."""
    if changes is None:
        return []
    said = []
    if events := _events(changes):
        what = f"the object changes: {_listed(events)}"
        said.append(warning("change-point", what))
    if changes.touches:
        said.append(_touch(changes))
    parts = _parts(changes.stretches)
    if not chosen:
        what = f"the part that was given is used, though no single free body explains it; parts of one body: {parts}"
        return [*said, error("change-left-in", what, "start")]
    used = " and ".join(f"{s.start:.2f} to {s.end:.2f} s" for s in changes.used)
    what = f"only {used} is used; parts to choose from: {parts}"
    if changes.gripper is not None:
        what += (
            f"; the gripper of {changes.gripper.mass:.3g} kg is included: to leave it out, "
            "calibrate it, by this recording too, and give that as `tool`"
        )
    return [*said, warning("change-part-used", what, "start")]


def _events(changes: Changes) -> list[str]:
    return [
        f"{one.event} at {0.5 * (one.end + other.start):.1f} s"
        for one, other in pairwise(changes.stretches)
        if one.event not in (None, "touched")
    ]


def _touch(changes: Changes) -> Message:
    when = _listed([f"{t.start:.1f} to {t.end:.1f} s" for t in changes.touches])
    long = changes.touched > LONG_TOUCH_SHARE * changes.duration
    much = ", more than half of the recording" if long else ""
    parts = (*changes.touches, *changes.stretches)
    first, last = min(p.start for p in parts), max(p.end for p in parts)
    # a sensor that is zeroed stays so to the end of the recording
    lasts = any(first == t.start or t.end == last for t in changes.touches)
    also = ", or was the sensor zeroed" if lasts else ""
    what = f"no free body explains the wrench from {when}{much}: touched{also}?"
    return warning("change-touched", what)


def _parts(stretches: tuple[Stretch, ...]) -> str:
    """The longest stretches in words, in order of time, and the number of the others."""
    every = range(len(stretches))
    longest = sorted(every, key=lambda i: -stretches[i].duration)[:MOST_LISTED]
    first = sorted(every, key=lambda i: (i not in longest, i))
    return _listed([_part(stretches[i]) for i in first])


def _listed(texts: list[str]) -> str:
    """The first texts, and the number of the others."""
    more = len(texts) - MOST_LISTED
    return ", ".join(texts[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def _part(stretch: Stretch) -> str:
    """A stretch in words: its start and duration as arguments, and its body."""
    com, held = stretch.center_of_mass, f"{stretch.mass:.3g} kg"
    if com is not None:
        held += f", COM ({', '.join(f'{1e3 * x:.0f}' for x in com)}) mm"
    elif stretch.bare:
        held = "the tool alone" if stretch.mass == 0.0 else "nothing"
    return f"`start` {stretch.start:.2f} `duration` {stretch.duration:.2f} ({held})"

"""Stretches of a recording in each of which the same free body is held, and the events
between them."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from hefting.core.spatial import Array

EventKind = Literal["picked-up", "put-down", "swapped", "slipped", "touched"]


@dataclass(frozen=True, eq=False)
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
    """what ends it; None at the end of the recording"""
    bare: bool
    """whether it is before an object was picked up, or after it was put down"""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.end - self.start

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


@dataclass(frozen=True, eq=False)
class Touch:
    """A part of a recording in which no body explains the wrench."""

    start: float
    """[s] since the first sample of the recording"""
    end: float
    """[s]"""


@dataclass(frozen=True, eq=False)
class Changes:
    """Stretches of a recording in which the object changes or is touched."""

    stretches: tuple[Stretch, ...]
    """in order, at least one"""
    touches: tuple[Touch, ...]
    """in order"""
    duration: float
    """[s] of the recording"""

    @property
    def chosen(self) -> Stretch:
        """The longest stretch; with an object in the hand, where there is one."""
        held = [s for s in self.stretches if not s.bare]
        return max(held or self.stretches, key=lambda stretch: stretch.duration)

    @property
    def touched(self) -> float:
        """[s] in which no body explains the wrench."""
        return float(np.sum([t.end - t.start for t in self.touches]))

    def to_dicts(self) -> list[dict[str, Any]]:
        """The stretches, JSON-ready."""
        return [stretch.to_dict() for stretch in self.stretches]

    def later(self, seconds: float) -> "Changes":
        """The same, with times since `seconds` [s] before the recording's start."""

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

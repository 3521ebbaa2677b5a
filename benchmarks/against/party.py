"""What every party is given, what it answers, and who it is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.core.spatial import Array
from hefting.shapes import Shape


class NoAnswerError(Exception):
    """A party's solver fails."""


@dataclass(frozen=True, eq=False)
class Task:
    """What a party is given: nothing else is known to it."""

    z: Measurements
    """gravity, accelerations, angular velocity and wrench, in sensor axes; no noise"""
    shape: Shape
    """points inside the object, in the sensor frame"""
    noise: Noise
    """levels of wrench and accelerations, as of a data sheet"""


@dataclass(frozen=True, eq=False)
class Answer:
    """What a party says."""

    body: InertialParameters
    low: Array | None = None
    """(10,) lower ends of the 95 % intervals of mass, COM and inertia about the sensor
    (xx, xy, xz, yy, yz, zz); NaN where there is none; None: no intervals"""
    high: Array | None = None
    """(10,) upper ends"""


@dataclass(frozen=True, eq=False)
class Party:
    """One way to identify an object."""

    name: str
    identify: Callable[[Task, Any], Answer]
    """timed; gets what `prepare` returned; raises `NoAnswerError`"""
    prepare: Callable[[Task], Any] = lambda task: None
    """not timed: what serves any recording of the object"""
    beside: str = ""
    """the Hefting party that does the same, which a peer is compared with"""
    peer: bool = False
    method: str = ""
    """what is drawn in one colour: the program"""
    calls: int = 1
    """repetitions on each recording, which are timed"""
    limit: float = 5.0
    """[s] beyond which its cost is not followed further"""

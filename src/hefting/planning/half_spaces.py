"""Half-spaces that are kept: a table below the arm, a wall beside it."""

import re
from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, frozen

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
"""Directions that have a name."""
LARGEST = 1e3
"""[m] No wall of a robot cell is farther away."""
EXAMPLE = "as in z>=0.05, x<=0.6 or 0.7,0.7,0>=-0.3, in metres"


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """Points p with ``normal . p >= offset`` in the axes of the robot's root frame.

    Examples
    --------
    >>> HalfSpace.parse("z >= 0.05").clearance([0.0, 0.0, 0.15])
    0.1
    """

    text: str
    """As it was written, for messages."""
    normal: Array
    """(3,) unit vector into it"""
    offset: float
    """[m]"""

    @classmethod
    def parse(cls, text: str) -> Self:
        """From an inequality: ``z>=0.05``, ``x<=0.6``, or with the factors of x, y and
        z, ``0.7,0.7,0>=-0.3``, which is 0.7 x + 0.7 y >= -0.3 m.

        Raises `InputError` for another text, factors that are all zero, and a plane
        more than `LARGEST` metres from the origin.
        """
        match = re.fullmatch(r"\s*([^<>=]+?)\s*(>=|<=)\s*([^<>=]+?)\s*", text)
        factors = _factors(match[1]) if match else None
        bound = _number(match[3]) if match else None
        if match is None or factors is None or bound is None:
            raise InputError(f"'{text[:60]}' is no half-space", fix=EXAMPLE)
        size = float(np.linalg.norm(factors))
        if not size > 0.0 or not abs(bound) <= LARGEST * size:
            what = f"'{text[:60]}' is no half-space within {LARGEST:g} m"
            raise InputError(what, fix=EXAMPLE)
        sign = 1.0 if match[2] == ">=" else -1.0
        plain = "".join(text.split())
        return cls(plain, frozen(sign * factors / size), sign * bound / size)

    def clearance(self, points: Array) -> Array:
        """Signed distance (...) [m] of points (..., 3) from its boundary, negative
        outside."""
        return np.asarray(points) @ self.normal - self.offset


def _factors(text: str) -> Array | None:
    """The factors of x, y and z (3,); None for another text."""
    if text in AXES:
        return np.array(AXES[text])
    numbers = [_number(part) for part in text.split(",")]
    known = [number for number in numbers if number is not None]
    if len(numbers) != 3 or len(known) != 3 or max(map(abs, known)) > LARGEST:
        return None
    return np.array(known)


def _number(text: str) -> float | None:
    """A finite number; None for another text."""
    try:
        value = float(text.replace("_", "?"))
    except ValueError:
        return None
    return value if np.isfinite(value) else None

"""Undetermined: the numbers of an estimate that neither the data nor a shape determine.

Such a number is printed as ``open`` and not exported to controllers or simulators. The
estimate still has a value for it, from its method.
"""

from collections.abc import Collection, Mapping
from dataclasses import field
from typing import Any, Self

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.messages import Message, error
from hefting.core.spatial import (
    PARAMETERS,
    TENSOR_COLUMNS,
    TENSOR_ROWS,
    Mask,
    own,
    vector_to_tensor,
)

LARGEST_RELATIVE_HALF_WIDTH = 0.5
"""Half-width of the mass's interval over the mass, above which it is undetermined."""
LONGEST_ORIGIN = 200
"""Largest number of characters of `Undetermined.filled_from`."""


@immutable
class Undetermined:
    """Open numbers among mass, COM and inertia at the COM."""

    mass: bool = False
    center_of_mass: Mask = field(default_factory=lambda: np.zeros(3, dtype=bool))
    """(3,) whether each coordinate is open"""
    inertia_at_com: Mask = field(default_factory=lambda: np.zeros((3, 3), dtype=bool))
    """(3, 3) whether each entry is open"""
    filled_from: str | None = None
    """What their values follow from, in words; None if nothing is open."""

    def __post_init__(self):
        for name in ("center_of_mass", "inertia_at_com"):
            mask = np.array(getattr(self, name), dtype=bool)
            object.__setattr__(self, name, own(mask))

    @property
    def ten(self) -> Mask:
        """(10,) whether each of mass, COM and inertia at the COM (xx, xy, xz, yy, yz, zz)
        is open."""
        inertia = self.inertia_at_com[TENSOR_ROWS, TENSOR_COLUMNS]
        return np.array((self.mass, *self.center_of_mass, *inertia), dtype=bool)

    @classmethod
    def of_parameters(cls, names: Collection[str], filled_from: str) -> Self:
        """From the names of open parameters about the sensor origin
        (`hefting.core.spatial.PARAMETERS`).

        An entry of the inertia at the COM is open if one of the numbers from which it
        follows is: inertia at the origin, mass and COM.
        """
        if not names:
            return cls()
        mass = "m" in names
        com = np.array([mass or name in names for name in PARAMETERS[1:4]])
        at_origin = vector_to_tensor([float(name in names) for name in PARAMETERS[4:]])
        moved = com[:, None] | com[None, :]
        # Jxx at the COM needs y and z of the COM, and so on
        np.fill_diagonal(moved, [com[1] or com[2], com[0] or com[2], com[0] or com[1]])
        inertia = (at_origin > 0.0) | moved | mass
        return cls(mass, com, inertia, filled_from)

    @classmethod
    def without_end(cls, ends: Mapping[str, np.ndarray]) -> Self:
        """From the lower and upper ends (2, ...) of intervals, perhaps infinite."""
        names = ("mass", "center_of_mass", "inertia_at_com")
        infinite = [np.isinf(ends[name]) for name in names]
        if not any(each.any() for each in infinite):
            return cls()
        mass, com, inertia = (np.logical_or.reduce(each, axis=0) for each in infinite)
        return cls(bool(mass), np.array(com), np.array(inertia), "the method")

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """From JSON values; `ValueError` or `KeyError` for anything else."""
        mass, origin = data["mass"], data.get("filled_from")
        # as objects, so that numbers are not taken for true and false
        com = np.array(data["center_of_mass"], dtype=object)
        inertia = np.array(data["inertia_at_com"], dtype=object)
        values = [mass, *com.ravel(), *inertia.ravel()]
        if com.shape != (3,) or inertia.shape != (3, 3):
            raise ValueError("undetermined has another shape")
        if not all(type(value) is bool for value in values):
            raise ValueError("undetermined is neither true nor false")
        if not (origin is None or isinstance(origin, str)):
            raise ValueError("filled_from is no text")
        origin = None if origin is None else origin[:LONGEST_ORIGIN]
        return cls(mass, com.astype(bool), inertia.astype(bool), origin)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values."""
        return {
            "mass": self.mass,
            "center_of_mass": self.center_of_mass.tolist(),
            "inertia_at_com": self.inertia_at_com.tolist(),
            "filled_from": self.filled_from,
        }

    @property
    def inertia(self) -> bool:
        """Whether any entry of the inertia is open."""
        return bool(self.inertia_at_com.any())

    @property
    def position(self) -> str:
        """Open ones among mass and coordinates of the COM, in words; empty for none."""
        axes = [a for a, o in zip("xyz", self.center_of_mass, strict=True) if o]
        com = ["the COM"] if len(axes) == 3 else [f"COM {a}" for a in axes]
        return " and ".join((["the mass"] if self.mass else []) + com)

    def __bool__(self) -> bool:
        """Whether anything is open."""
        return self.mass or bool(self.center_of_mass.any()) or self.inertia


NOTHING_OPEN = Undetermined()
"""For an estimate whose numbers are all determined."""


def undetermined_mass(
    mass: float, intervals: Mapping[str, np.ndarray] | None
) -> Message | None:
    """A message that the interval of a mass [kg] is about as wide as the mass; None if
    it is narrow or missing."""
    if intervals is None:
        return None
    low, high = (float(end) for end in intervals["mass"])
    if 0.5 * (high - low) <= LARGEST_RELATIVE_HALF_WIDTH * mass:
        return None
    what = f"the recording does not determine the mass ({low:.3g} to {high:.3g} kg): this answer is not to be used"
    return error("mass-undetermined", what)

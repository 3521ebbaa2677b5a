"""Undetermined: the numbers of an estimate that neither the data nor a shape determine;
and the covariance of the ten parameters, infinite where open.

Such a number is printed as ``open`` and not exported to controllers or simulators. The
estimate still has a value for it, from its method.
"""

from collections.abc import Collection, Mapping
from dataclasses import field, replace
from typing import Any, NamedTuple, Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, error
from hefting.core.regressor import full_rows, motion_features
from hefting.core.spatial import (
    CHUNK,
    PARAMETERS,
    TENSOR_COLUMNS,
    TENSOR_ROWS,
    Array,
    Mask,
    immutable,
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

    def turned(self, rotation: Array) -> Self:
        """The same in turned axes: a number is open if one from which it follows is."""
        from_ = np.abs(rotation) > 1e-9
        com, inertia = self.center_of_mass, self.inertia_at_com
        return replace(
            self, center_of_mass=from_ @ com, inertia_at_com=from_ @ inertia @ from_.T
        )

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


NEGATIVE = 1e-6
"""Largest negative eigenvalue that is rounding, relative to the largest one, for
standard deviations scaled to 1."""
TOUCHES = 1e-6
"""[m/s², rad/s²] Entry of A up to which a parameter does not matter: the error by
smoothing where the sensor does not turn, a micronewton metre for 1 kg m²."""
NOTHING = 1e-12
"""Eigenvalue, relative to the largest one, below which there is no variance."""


def mapped(covariance: Array, derivative: Array) -> Array:
    """Covariance (n, n) of numbers by their derivative (n, 10); the variance is infinite
    of those that follow from an open parameter."""
    open_ = np.isinf(covariance.diagonal())
    known = np.where(np.isinf(covariance), 0.0, covariance)
    of_all = derivative @ known @ derivative.T
    follows = (np.abs(derivative[:, open_]) > 1e-12).any(axis=1)
    of_all[follows, follows] = np.inf
    return of_all


class Covariance(NamedTuple):
    """A covariance (10, 10) as ``D V diag(values) V' D``, with the standard deviations
    on the diagonal of D, zero for open parameters."""

    size: Array
    """(10,) standard deviations, 1 for none"""
    values: Array
    """(10,) eigenvalues, not negative, smallest first"""
    vectors: Array
    """(10, 10) eigenvectors by columns"""
    open: Mask
    """(10,) parameters that are not determined at all"""

    @classmethod
    def of(cls, covariance: Array) -> Self:
        """From a covariance (10, 10) with infinite diagonal entries for open
        parameters. Raises `InputError` for what is no covariance."""
        open_ = np.isinf(covariance.diagonal())
        known = np.where(open_ | open_[:, None], 0.0, covariance)
        if not np.isfinite(known).all() or (covariance.diagonal() < 0.0).any():
            what = "the estimate's covariance has a negative or missing variance"
            raise InputError(what, fix="identify it again")
        size = np.where(known.diagonal() > 0.0, np.sqrt(known.diagonal()), 1.0)
        scaled = known / size / size[:, None]
        values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
        if (
            values[0] < -NEGATIVE * max(values[-1], 1.0)
            or np.abs(scaled - scaled.T).max() > NEGATIVE
        ):
            what = "the estimate's covariance is not one: not symmetric or not positive"
            raise InputError(what, fix="identify it again")
        vectors[known.diagonal() == 0.0] = 0.0  # they are zero up to rounding
        return cls(size, np.maximum(values, 0.0), vectors, open_)

    @property
    def root(self) -> Array:
        """(10, 10) with ``root @ root.T`` the covariance."""
        return self.size[:, None] * self.vectors * np.sqrt(self.values)

    @property
    def information(self) -> Array:
        """(10, 10) inverse of the covariance; zero in directions without variance."""
        some = self.values > NOTHING * self.values[-1]
        ways = self.vectors[:, some] / self.size[:, None]
        return (ways / self.values[some]) @ ways.T

    def std(self, rows: Array) -> Array:
        """Standard deviations (...) of ``rows @ phi``, rows (..., 10); infinite where
        an open parameter matters."""
        std = np.sqrt(np.square(rows @ self.root).sum(axis=-1))
        return np.where(
            (np.abs(rows) > TOUCHES)[..., self.open].any(axis=-1), np.inf, std
        )

    def of_wrench(self, measurements: Measurements) -> Array:
        """Standard deviations (K, 6) [N, N m] of the predicted wrench A phi, with A (6, 10)
        from the motion: by the covariance C it is A C A'."""
        std = np.empty((len(measurements), 6))
        for first in range(0, len(std), CHUNK):
            part = slice(first, first + CHUNK)
            std[part] = self.std(full_rows(motion_features(measurements[part])))
        return std

"""Body: mass, COM and inertia in one frame for all targets, principal moments and axes,
and the number of digits to write."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.quantity import decimals, rounded
from hefting.core.spatial import Array, freeze, skew
from hefting.robots.inertia_check import second_moments
from hefting.shapes import as_pose

ROUNDING = 1e-12
"""Inertia about the COM relative to that about the origin up to which it is rounding, and
the body a point mass."""
LEAST_DIGITS = 2
"""Least number of significant digits of the mass, and of the largest moment."""
THINNEST = 1e-6
"""Least second moment of mass along any axis, as a share of the sum over the three
principal axes: a thickness of a thousandth of the body's size. A flat or rod-like body is
at the limit of consistency, where rounding makes simulators refuse it (MuJoCo requires
A + B >= C and positive moments exactly)."""

ALIKE = 3.0
"""Difference of two moments, in rounding steps, up to which they count as equal: each may
be off by one and a half."""

SIGNED_PERMUTATIONS = np.array(
    [
        np.diag(signs)[:, order]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]
)
RENAMINGS = SIGNED_PERMUTATIONS[np.linalg.det(SIGNED_PERMUTATIONS) > 0]
"""The 24 right-handed ways (24, 3, 3) to rename and reverse three axes."""


@dataclass(frozen=True)
class HalfWidths:
    """Half-widths of the 95 % intervals of a body's numbers; infinite if none."""

    mass: float = np.inf
    center_of_mass: Array = field(default_factory=lambda: np.full(3, np.inf))
    inertia: Array = field(default_factory=lambda: np.full((3, 3), np.inf))

    def turned(self, rotation: Array) -> Self:
        """Half-widths along axes turned by a rotation (3, 3), for independent errors of
        the components."""
        share = np.square(rotation)
        share[share < ROUNDING] = 0.0
        com, inertia = self.center_of_mass, self.inertia
        lost = share @ np.isinf(com) > 0.0
        lost_entry = share @ np.isinf(inertia) @ share.T > 0.0
        com = np.sqrt(share @ np.square(np.where(np.isinf(com), 0.0, com)))
        square = np.square(np.where(np.isinf(inertia), 0.0, inertia))
        inertia = np.sqrt(share @ square @ share.T)
        return replace(
            self,
            center_of_mass=np.where(lost, np.inf, com),
            inertia=np.where(lost_entry, np.inf, inertia),
        )


@dataclass(frozen=True)
class Body:
    """Mass, COM and inertia about the COM of a possible body, in one frame's axes."""

    name: str
    """Name given by the user."""
    frame: str
    """Frame of the numbers, as ``sensor`` or ``flange``."""
    mass: float
    """Mass [kg], positive."""
    center_of_mass: Array
    """COM (3,) [m]."""
    inertia: Array
    """Inertia tensor (3, 3) [kg m²] about the COM: positive definite, or zero for a point
    mass and if unknown."""
    half_widths: HalfWidths = field(default_factory=HalfWidths)
    """Of the intervals of the numbers."""
    notes: tuple[str, ...] = ("estimate: good",)
    """Lines of a comment on the estimate: its verdict, and doubts."""
    without: str = ""
    """What the sensor also carries and the body does not include."""
    thickened: bool = False
    """Whether second moments were raised to `THINNEST`, which changes the inertia by about
    as much."""
    inertia_places: int = 300
    """Decimal places to which the inertia is rounded."""

    def __post_init__(self):
        freeze(self, "center_of_mass", "inertia")

    @classmethod
    def from_parameters(
        cls, parameters: InertialParameters, name: str, frame: str
    ) -> Self:
        """The body with these parameters; `InputError` says why if none can exist."""
        inertia = parameters.inertia_at_com
        is_point = (
            np.abs(inertia).max()
            <= ROUNDING * np.abs(parameters.inertia_at_origin).max()
        )
        consistency = parameters.consistency()
        if consistency.violated == "mass" or (consistency.violated and not is_point):
            fix = "identify with a method that assures consistency (LMI, PMD), or export json or csv"
            raise InputError(f"no body has these parameters: {consistency}", fix=fix)
        point = cls.without_inertia(parameters, name, frame)
        return point if is_point else point.with_inertia(inertia)

    @classmethod
    def without_inertia(
        cls, parameters: InertialParameters, name: str, frame: str
    ) -> Self:
        """A point mass at the COM; `InputError` if the mass is not positive."""
        if not parameters.mass > 0.0:
            what = "no body has these parameters: the mass is not positive"
            raise InputError(what, fix="check the wrench's sign and gravity")
        com = parameters.center_of_mass
        return cls(name, frame, parameters.mass, com, np.zeros((3, 3)))

    def with_inertia(self, inertia: Array) -> Self:
        """Body with an inertia (3, 3) [kg m²] about the COM, raised to `THINNEST`."""
        tensor, thickened = with_thickness(inertia)
        return replace(self, inertia=tensor, thickened=thickened)

    def moved(self, pose_old_in_new: ArrayLike, frame: str) -> Self:
        """The same body in another frame; `pose_old_in_new` (4, 4) is this frame's pose
        in the new one.

        Second moments stay about the COM, so that a distant origin costs no digits.
        """
        pose = as_pose(pose_old_in_new)
        rotation = pose[:3, :3]
        second = rotation @ second_moments(self.inertia) @ rotation.T
        inertia = np.trace(second) * np.eye(3) - 0.5 * (second + second.T)
        return replace(
            self,
            frame=frame,
            center_of_mass=rotation @ self.center_of_mass + pose[:3, 3],
            inertia=inertia,
            half_widths=self.half_widths.turned(rotation),
        )

    def rounded(self) -> Self:
        """The same body with as many digits as its intervals justify
        (`hefting.core.quantity`), and more of the inertia if it needs them to be
        consistent."""
        half, com = self.half_widths, self.center_of_mass
        mass = rounded(self.mass, decimals(half.mass, self.mass, LEAST_DIGITS))
        com = rounded(com, decimals(half.center_of_mass, float(np.abs(com).max())))
        own = replace(self, mass=float(mass), center_of_mass=com)
        if self.is_point:
            return own
        size = float(np.abs(self.inertia).max())
        places = decimals(half.inertia, size, LEAST_DIGITS)
        inertia, places_used = rounded_inertia(self.inertia, places)
        return replace(own, inertia=inertia, inertia_places=places_used)

    @property
    def is_point(self) -> bool:
        """Whether the inertia about the COM is zero, or unknown."""
        return not self.inertia.any()

    @property
    def tensor(self) -> dict[str, float]:
        """Entries ixx, iyy, izz, ixy, ixz, iyz [kg m²] of the inertia tensor; products
        are -∫ x y dm."""
        entries = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        return {f"i{'xyz'[i]}{'xyz'[j]}": float(self.inertia[i, j]) for i, j in entries}

    @property
    def identifier(self) -> str:
        """The name with everything but ASCII letters, digits and underscores replaced
        by underscores."""
        return "".join(c if c.isascii() and c.isalnum() else "_" for c in self.name)

    @property
    def inertia_step(self) -> float:
        """Unit of the last decimal place of the inertia [kg m²]."""
        return 10.0**-self.inertia_places

    @cached_property
    def _principal(self) -> tuple[Array, Array]:
        moments, axes = principal(self.inertia, self.inertia_step)
        if self.is_point:
            return moments, axes
        places = np.full((3, 3), self.inertia_places)
        return rounded_inertia(np.diag(moments), places)[0].diagonal(), axes

    def principal(self) -> tuple[Array, Array]:
        """Principal moments (3,) [kg m²] and right-handed principal axes as columns (3,
        3), in the order of the frame's axes nearest to them."""
        return self._principal

    @property
    def angle_places(self) -> int:
        """Decimal places of an angle [deg] of the principal axes."""
        return angle_decimals(self._principal[0], self.inertia_step)

    def quaternion(self) -> Array:
        """Quaternion (4,) **w, x, y, z**, w >= 0, from principal coordinates to the
        frame's, to nine places, at which its norm is still one."""
        from scipy.spatial.transform import Rotation

        x, y, z, w = Rotation.from_matrix(self._principal[1]).as_quat(canonical=True)
        return rounded((w, x, y, z), 9)


def number(value: float) -> str:
    """Shortest decimal that reads back as the same double."""
    return repr(float(value) + 0.0)  # + 0.0 makes -0.0 plain zero


def numbers(values: Iterable[float], separator: str = " ") -> str:
    """`number` of each value, joined."""
    return separator.join(map(number, values))


def quoted(text: str) -> str:
    """Text as the value of an XML attribute, with its quotes."""
    from xml.sax.saxutils import quoteattr  # which imports an HTTP client

    return quoteattr(text)


def principal(inertia: Array, step: float) -> tuple[Array, Array]:
    """Principal moments (3,) [kg m²] and right-handed principal axes as columns (3, 3).

    Of the 24 right-handed orders and signs of the axes the one is chosen that is turned
    least from the frame. Axes of moments that are equal to within `ALIKE` times `step`
    [kg m²] are arbitrary, and chosen near to the frame's.
    """
    moments, axes = np.linalg.eigh(inertia)
    alike = np.diff(moments) <= ALIKE * step
    if alike.all():
        return np.full(3, moments.mean()), np.eye(3)
    if alike.any():
        pair, single = ([0, 1], 2) if alike[0] else ([1, 2], 0)
        moments[pair] = moments[pair].mean()
        axes[:, pair] = _across(axes[:, single])
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    renaming = RENAMINGS[np.einsum("ij,kji->k", axes, RENAMINGS).argmax()]
    return np.abs(renaming.T) @ moments, axes @ renaming


def _across(axis: Array) -> Array:
    """Two orthonormal columns (3, 2) perpendicular to a unit vector (3,), the first as near
    as possible to an axis of the frame."""
    nearest = np.eye(3)[np.abs(axis).argmin()]
    first = nearest - axis * float(nearest @ axis)
    first = first / float(np.linalg.norm(first))
    return np.column_stack((first, skew(axis) @ first))


def angle_decimals(moments: Array, step: float) -> int:
    """Decimal places of an angle [deg] of the axes of these moments (3,), at which a turn
    changes the tensor by less than `step`: a turn by an angle [rad] changes it by up to
    the angle times the largest difference of moments."""
    spread = float(np.ptp(moments))
    if spread == 0.0:
        return 0
    degrees = np.degrees(step / spread)
    return int(np.clip(-np.floor(np.log10(degrees)), 0, 9))


def with_thickness(inertia: Array) -> tuple[Array, bool]:
    """Inertia tensor (3, 3) with all second moments raised to at least `THINNEST`, and
    whether that changed it."""
    second, axes = np.linalg.eigh(second_moments(inertia))
    raised = np.maximum(second, THINNEST * second.sum())
    if np.array_equal(raised, second):
        return inertia, False
    tensor = inertia + (axes * ((raised - second).sum() - (raised - second))) @ axes.T
    return 0.5 * (tensor + tensor.T), True


def rounded_inertia(inertia: Array, places: np.ndarray) -> tuple[Array, int]:
    """An inertia tensor (3, 3) with entries rounded to decimal `places` (3, 3), or to as
    many more as a consistent tensor needs, and the largest number of places used."""
    for more in range(16):
        tensor = rounded(inertia, places + more)
        second = np.linalg.eigvalsh(second_moments(tensor))
        if second[0] >= 0.5 * THINNEST * second.sum() > 0.0:
            return tensor, int(places.max()) + more
    return inertia, int(places.max()) + 16

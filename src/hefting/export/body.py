"""Body: what every simulator and controller is told, in one frame and ready to be
written."""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, check_pose, frozen

THINNEST = 1e-6
"""Least second moment of mass along any axis, as a share of the sum over the three
principal axes: a thickness of a thousandth of the body's size. A flat or rod-like body
is on the boundary of what can exist, and rounding alone makes simulators refuse it
(MuJoCo wants A + B >= C and positive moments, exactly)."""

ROUNDING = 1e-12
"""Inertia at the COM below this share of that about the origin is rounding: the body is
a point mass."""

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
class Body:
    """Mass, COM and inertia about the COM of a body that can exist, in one frame's
    axes."""

    name: str
    """Name the user gave."""
    frame: str
    """``sensor`` or ``flange``: whose origin and axes the numbers refer to."""
    mass: float
    """Mass [kg], positive."""
    center_of_mass: Array
    """COM (3,) [m]."""
    inertia: Array
    """Inertia tensor (3, 3) [kg m²] about the COM: positive definite, or zero for a
    point mass."""
    verdict: str = "good"
    """Level of the estimate's verdict, for a comment."""
    thickened: bool = False
    """Whether second moments were raised to `THINNEST`, which changes the inertia by
    about as much."""

    def __post_init__(self):
        object.__setattr__(self, "center_of_mass", frozen(self.center_of_mass))
        object.__setattr__(self, "inertia", frozen(self.inertia))

    @classmethod
    def from_parameters(
        cls, parameters: InertialParameters, name: str, frame: str
    ) -> Self:
        """The body with these parameters; `InputError` naming the violated condition
        when none can exist."""
        inertia = parameters.inertia_at_com
        is_point = (
            np.abs(inertia).max()
            <= ROUNDING * np.abs(parameters.inertia_at_origin).max()
        )
        consistency = parameters.consistency()
        if consistency.violated == "mass" or (consistency.violated and not is_point):
            raise InputError(
                f"no body has these parameters: {consistency}",
                fix="identify with a method that assures consistency (LMI, PMD), or export json or csv",
            )
        inertia, thickened = (
            (np.zeros((3, 3)), False) if is_point else with_thickness(inertia)
        )
        return cls(
            name,
            frame,
            parameters.mass,
            parameters.center_of_mass,
            inertia,
            thickened=thickened,
        )

    def moved(self, pose_old_in_new: ArrayLike, frame: str) -> Self:
        """The same body in another frame; `pose_old_in_new` (4, 4) is this frame's pose
        in the new one.

        Moves the second moments about the COM, so that no digits are lost by way of a
        distant origin.
        """
        pose = check_pose(pose_old_in_new)
        rotation = pose[:3, :3]
        second = (
            rotation
            @ (0.5 * np.trace(self.inertia) * np.eye(3) - self.inertia)
            @ rotation.T
        )
        inertia = np.trace(second) * np.eye(3) - 0.5 * (second + second.T)
        return replace(
            self,
            frame=frame,
            center_of_mass=rotation @ self.center_of_mass + pose[:3, 3],
            inertia=inertia,
        )

    @property
    def is_point(self) -> bool:
        """Whether the body has no inertia about its COM."""
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

    def principal(self) -> tuple[Array, Array]:
        """Principal moments (3,) [kg m²] and right-handed principal axes as columns (3,
        3).

        Each axis is called x, y or z after the frame's axis it is nearest to: of the 24
        right-handed ways to name them, the one least turned from the frame.
        """
        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        renaming = RENAMINGS[np.einsum("ij,kji->k", axes, RENAMINGS).argmax()]
        return np.abs(renaming.T) @ moments, axes @ renaming

    def quaternion(self) -> Array:
        """Quaternion (4,) **w, x, y, z**, w >= 0: from principal coordinates to the
        frame's."""
        from scipy.spatial.transform import Rotation

        x, y, z, w = Rotation.from_matrix(self.principal()[1]).as_quat(canonical=True)
        return np.array((w, x, y, z))


def with_thickness(inertia: Array) -> tuple[Array, bool]:
    """Inertia tensor (3, 3) whose every second moment is at least `THINNEST`, and
    whether that changed it."""
    second, axes = np.linalg.eigh(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    raised = np.maximum(second, THINNEST * second.sum())
    if np.array_equal(raised, second):
        return inertia, False
    tensor = inertia + (axes * ((raised - second).sum() - (raised - second))) @ axes.T
    return 0.5 * (tensor + tensor.T), True


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

"""Whether a body can have the inertial of each link of a URDF, and the nearest possible
tensor.

A tensor J about the COM has the second moments S = ∫ p p' dm = tr(J) / 2 I - J.
A body of mass m > 0 exists if and only if S is positive definite, which is the
pseudo-inertia condition with the mass and the COM held fixed (Wensing, Kim and Slotine
2018, https://arxiv.org/abs/1701.04395). The nearest is

    minimise |S' - S|_F  over  S' - t I positive semidefinite,

the projection on a cone, whose solution keeps the eigenvectors and raises every
eigenvalue to at least t (Higham 1988, https://doi.org/10.1016/0024-3795(88)90223-6).
"""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import printable
from hefting.core.files import read_xml
from hefting.core.messages import Message, error, warning
from hefting.core.spatial import Array, frozen
from hefting.robots.inertials import Inertial, Inertials, read_inertials

THINNEST_SHARE = 1e-6
"""Least second moment of a repaired tensor, over the sum of the positive ones: a
thickness of a thousandth of the body's size. On the boundary itself simulators refuse
bodies because of rounding (MuJoCo needs A + B >= C exactly)."""

THINNEST_LENGTH = 1e-4
"""Least radius of gyration of a repaired tensor along any axis [m], for tensors of zero:
no link is thinner."""

LEAST_MOMENT = 1e-14
"""Least second moment of a repaired tensor [kg m²]: MuJoCo refuses moments of inertia
below 1e-15."""

DIGITS = 13
"""Decimal digits of the largest entry that are kept: rounding is a millionth of the
least second moment, so that the tensor remains possible and zeros remain zeros."""


def second_moments(inertia: Array) -> Array:
    """Second moments (3, 3) [kg m²] of a tensor (3, 3), both about the COM."""
    return 0.5 * np.trace(inertia) * np.eye(3) - inertia


def least_second_moment(mass: float, inertia: Array) -> float:
    """The least second moment t [kg m²] of a repaired tensor, for a mass [kg] and a
    tensor (3, 3)."""
    possible = np.maximum(np.linalg.eigvalsh(second_moments(inertia)), 0.0)
    return max(
        THINNEST_SHARE * float(possible.sum()), THINNEST_LENGTH**2 * mass, LEAST_MOMENT
    )


def nearest_inertia(mass: float, inertia: Array) -> Array:
    """The possible tensor (3, 3) [kg m²] about the COM nearest to a symmetric one, for
    the same positive mass [kg] and COM. It does not depend on the axes."""
    moments, axes = np.linalg.eigh(second_moments(inertia))
    raised = np.maximum(moments, least_second_moment(mass, inertia))
    second = (axes * raised) @ axes.T
    return _rounded(np.trace(second) * np.eye(3) - 0.5 * (second + second.T), inertia)


def _rounded(tensor: Array, before: Array) -> Array:
    """`tensor` rounded to `DIGITS`; entries that then equal those of `before` stay."""
    places = DIGITS - int(np.ceil(np.log10(np.abs(tensor).max())))
    same = np.abs(tensor - before) <= 10.0**-places
    rounded = np.vectorize(lambda value: round(float(value), places))(tensor)
    return np.where(same, before, rounded)


def distance(inertia: Array, other: Array) -> float:
    """Frobenius distance [kg m²] of the second moments of two tensors (3, 3)."""
    return float(np.linalg.norm(second_moments(inertia) - second_moments(other)))


ROUNDING = 1e-12
"""Largest difference of moments by rounding, over the largest moment. Files have numbers
of up to 17 digits; repairs by other tools leave margins of 1e-10."""

FARTHEST = 5.0
"""Largest distance of a COM from its link's frame, and largest radius of gyration,
without a warning [m]. Those of the 2,149 links of `example-robot-data` are below 2 m; a
mistaken unit is a factor of a thousand."""


@dataclass(frozen=True)
class LinkCheck:
    """Result of the check of one link."""

    inertial: Inertial
    """Inertial of the file."""
    fault: Message | None = None
    """The first condition that fails; None if a body can have this inertial.

    Its code is ``inertial-unreadable``, ``inertial-mass`` (not positive),
    ``inertial-zero`` (a mass without extent), ``inertial-not-definite``,
    ``inertial-triangle`` (principal moments) or ``inertial-thin`` (no thickness along
    an axis)."""
    shortfall: float | None = None
    """Amount by which it fails: the negative mass [kg], or a share of the largest
    absolute principal moment of the tensor; None for other faults."""
    doubts: tuple[Message, ...] = ()
    """Warnings about possible inertials that are rarely intended."""

    @property
    def link(self) -> str:
        """Name of the link."""
        return self.inertial.link

    @property
    def is_possible(self) -> bool:
        """Whether a body can have this inertial; true for a link without mass."""
        return self.fault is None

    @cached_property
    def nearest(self) -> Array | None:
        """The nearest tensor (3, 3) [kg m²] that a body of this mass and COM can have,
        see `hefting.robots.inertia_check`; None without a fault, and for faults of
        mass or file."""
        if self.fault is None or not self.inertial.mass > 0.0:
            return None
        if self.inertial.unreadable is not None:
            return None
        return frozen(nearest_inertia(self.inertial.mass, self.inertial.inertia))

    @property
    def change(self) -> float | None:
        """Distance to the nearest tensor over the norm of this one; infinite for a tensor
        of zero, None without a nearest."""
        if self.nearest is None:
            return None
        inertia = self.inertial.inertia
        size = float(np.linalg.norm(second_moments(inertia)))
        return distance(inertia, self.nearest) / size if size else np.inf

    def to_dict(self) -> dict[str, Any]:
        """Values for JSON; null if they cannot be read."""
        known = self.inertial if self.inertial.unreadable is None else None
        return {
            "link": self.link,
            "possible": self.is_possible,
            "fault": self.fault.to_dict() if self.fault else None,
            "shortfall": self.shortfall,
            "mass": known.mass if known else None,
            "center_of_mass": known.center_of_mass.tolist() if known else None,
            "inertia": known.inertia.tolist() if known else None,
            "inertia_in_link_axes": known.inertia_in_link_axes.tolist()
            if known
            else None,
            "nearest": None if self.nearest is None else self.nearest.tolist(),
            "change": self.change if np.isfinite(self.change or 0.0) else None,
            "doubts": [doubt.to_dict() for doubt in self.doubts],
        }


def check_inertias(path: str | Path) -> list[LinkCheck]:
    """Check whether a body can have the inertial of each link of a URDF, in the file's
    order.

    A body of positive mass exists if and only if its second moments about the COM are
    positive definite, which implies that its inertia tensor is, and the triangle
    inequality of principal moments. Links without mass and inertia are frames, and
    pass.

    Raises `InputError` as `hefting.robots.inertials.read_inertials`.

    Examples
    --------
    >>> for checked in check_inertias("robot.urdf"):  # doctest: +SKIP
    ...     if checked.fault:
    ...         print(checked.link, checked.fault, checked.nearest)
    """
    return check_links(read_inertials(read_xml(path), path))


def check_links(robot: Inertials) -> list[LinkCheck]:
    """As `check_inertias`, for inertials that have been read."""
    idle = _moved_without_mass(robot)
    checks = []
    for inertial in robot.links:
        fault, shortfall = _fault(inertial)
        doubts = _doubts(inertial, idle.get(inertial.link)) if fault is None else ()
        checks.append(LinkCheck(inertial, fault, shortfall, doubts))
    return checks


def _fault(inertial: Inertial) -> tuple[Message | None, float | None]:
    """Fault and shortfall of a link, as in `LinkCheck`."""
    if inertial.unreadable is not None:
        what = f"its inertial cannot be read: {printable(inertial.unreadable)}"
        return error("inertial-unreadable", what), None
    if inertial.is_massless:
        return None, None
    if not inertial.mass > 0.0:
        what = f"the mass is {inertial.mass:.4g} kg, not positive"
        return error("inertial-mass", what), -inertial.mass
    fault, shortfall = _fault_of_tensor(inertial.inertia)
    if fault is None or not inertial.is_point:
        return fault, shortfall
    what = "the tensor is zero, or nearly: a mass without extent"
    return error("inertial-zero", what), None


def _fault_of_tensor(inertia: Array) -> tuple[Message | None, float | None]:
    """Fault and shortfall of a tensor (3, 3) about the COM."""
    moments = np.linalg.eigvalsh(inertia)
    largest = float(np.abs(moments).max())
    low, middle, high = moments / (largest or 1.0)
    slack = low + middle - high
    if low < -ROUNDING:
        what = f"the smallest principal moment is {moments[0]:.4g} kg m², not positive"
        return error("inertial-not-definite", what), -float(low)
    if slack < -ROUNDING:
        what = (
            f"the two smaller principal moments add up to {moments[0] + moments[1]:.4g} "
            f"kg m², less than the largest, {moments[2]:.4g}"
        )
        return error("inertial-triangle", what), -float(slack)
    if slack <= ROUNDING:
        what = (
            "there is no thickness along an axis: the two smaller principal moments "
            f"add up to the largest, {moments[2]:.4g} kg m²"
        )
        return error("inertial-thin", what), 0.0
    return None, None


def _doubts(inertial: Inertial, idle: str | None) -> tuple[Message, ...]:
    """Doubts about a possible link; `idle` is a joint that moves it, and no mass."""
    doubts = []
    if idle is not None:
        what = f"joint '{idle}' moves it, and nothing beyond that joint has mass"
        doubts.append(warning("moved-without-mass", what))
    far = float(np.linalg.norm(inertial.center_of_mass))
    if far > FARTHEST and not inertial.is_massless:
        what = f"the COM is {far:.3g} m from the link's frame: is it in metres?"
        doubts.append(warning("com-far-from-link", what))
    gyration = inertial.radius_of_gyration
    if gyration > FARTHEST or inertial.is_point:
        what = f"the radius of gyration is {gyration:.3g} m: is it in kg m²?"
        doubts.append(warning("gyration-odd", what))
    return tuple(doubts)


def _moved_without_mass(robot: Inertials) -> dict[str, str]:
    """Links that a joint moves although neither they nor the links they carry have mass,
    with that joint."""
    above = {joint.child: joint for joint in robot.joints}
    carrying: set[str] = set()
    for inertial in robot.links:
        link = "" if inertial.is_massless else inertial.link
        while link and link not in carrying:
            carrying.add(link)
            link = above[link].parent if link in above else ""
    return {
        link: joint.name
        for link, joint in above.items()
        if joint.moves and link not in carrying
    }

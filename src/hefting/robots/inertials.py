"""Inertials of a URDF: mass, COM and inertia tensor of every link of the file, possible
or not.

Source: the URDF XML specification (https://wiki.ros.org/urdf/XML/link). As in
`hefting.robots.urdf`, the file is not trusted. The error of an unreadable inertial is
kept with its link, so that a check can name all of them.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import parse_xml
from hefting.core.magnitudes import LARGEST_PARAMETER
from hefting.core.spatial import (
    Array,
    frozen,
    immutable,
    rotation_matrices,
    vector_to_tensor,
)
from hefting.robots.urdf import (
    MOST,
    check_expanded,
    check_repeated,
    check_tag,
    read_name,
    read_numbers,
    read_origin,
)

PARTS = ("origin", "mass", "inertia")
"""Elements of an inertial that are read: the first of each, as ROS does."""

ENTRIES = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Attributes of the tensor [kg m²], in the order of `spatial.PARAMETERS`."""

NO_EXTENT = 1e-5
"""Radius of gyration [m] below which a link is a point: of 60 such links in public URDFs
51 have a tensor of zero, the others rounding errors of 1e-18 kg m²."""


@immutable
class Inertial:
    """Inertial of one link; a mass of zero if the file has none."""

    link: str
    """Name of the link."""
    mass: float = 0.0
    """Mass [kg]."""
    center_of_mass: Array = field(default_factory=lambda: frozen(np.zeros(3)))
    """COM (3,) [m] in the link's frame."""
    inertia: Array = field(default_factory=lambda: frozen(np.zeros((3, 3))))
    """Tensor (3, 3) [kg m²] about the COM, in the axes of the inertial's origin."""
    axes: Array = field(default_factory=lambda: frozen(np.eye(3)))
    """Rotation (3, 3) from the axes of the inertial's origin to those of the link."""
    unreadable: str | None = None
    """Error, if it cannot be read; the numbers are then meaningless."""
    offset: int = 0
    """Start of the tensor's tag in the file [bytes]."""

    @property
    def inertia_in_link_axes(self) -> Array:
        """Tensor (3, 3) [kg m²] about the COM, in the axes of the link."""
        turned = self.axes @ self.inertia @ self.axes.T
        return 0.5 * (turned + turned.T)

    @property
    def is_massless(self) -> bool:
        """Whether it is a frame without mass and inertia, which any link may be."""
        return self.unreadable is None and not (self.mass or self.inertia.any())

    @property
    def radius_of_gyration(self) -> float:
        """Root mean square distance from the COM [m]; zero without positive mass."""
        if not self.mass > 0.0:
            return 0.0
        return math.sqrt(max(0.5 * float(np.trace(self.inertia)) / self.mass, 0.0))

    @property
    def is_point(self) -> bool:
        """Whether it is a mass without extent."""
        largest = float(np.abs(self.inertia).max())
        return self.mass > 0.0 and largest < self.mass * NO_EXTENT**2


@immutable
class Connection:
    """A joint between two links."""

    name: str
    parent: str
    child: str
    moves: bool


@immutable
class Inertials:
    """Inertials and joints of one robot, in the file's order."""

    links: tuple[Inertial, ...]
    joints: tuple[Connection, ...]


def read_inertials(data: bytes, path: str | Path) -> Inertials:
    """The inertials of the URDF text `data`.

    Raises `InputError` if it is not well-formed XML, is not URDF or contains xacro, has a
    document type, more than `hefting.robots.urdf.MOST` links, a link without a name or
    with another's, or a link with two inertials. Links need not be one tree.
    """
    links: list[_Link] = []
    joints: list[dict[str, str]] = []

    def start(tag: str, attributes: dict[str, str], offset: int, inside: list[str]):
        check_tag(tag, path, is_root=not inside)
        if len(inside) == 1 and tag == "link":
            links.append(_Link(read_name(attributes, "name", "a <link>", path)))
        elif len(inside) == 1 and tag == "joint":
            joints.append({key: attributes.get(key, "") for key in ("name", "type")})
        elif inside[1:] == ["link"] and tag == "inertial":
            if links[-1].parts is not None:
                what = f"link '{links[-1].name}' has two inertials"
                raise InputError(what, where=path)
            links[-1].parts = {}
        elif inside[1:] == ["link", "inertial"] and tag in PARTS:
            parts = links[-1].parts
            assert parts is not None  # as the inertial came first
            parts.setdefault(tag, (attributes, offset))
        elif inside[1:] == ["joint"] and tag in ("parent", "child"):
            joints[-1].setdefault(tag, attributes.get("link", ""))
        if max(len(links), len(joints)) > MOST:
            raise InputError(f"has more than {MOST:,} links or joints", where=path)

    parse_xml(data, path, start)
    check_repeated([link.name for link in links], "links", path)
    return Inertials(
        tuple(_inertial(link, path) for link in links),
        tuple(
            Connection(
                each["name"],
                each.get("parent", ""),
                each.get("child", ""),
                each["type"] != "fixed",
            )
            for each in joints
        ),
    )


@dataclass
class _Link:
    """A link during reading: attributes and offset of its inertial's parts."""

    name: str
    parts: dict[str, tuple[dict[str, str], int]] | None = None


def _inertial(link: _Link, path: str | Path) -> Inertial:
    if link.parts is None:
        return Inertial(link.name)
    parts = {tag: attributes for tag, (attributes, _) in link.parts.items()}
    for attributes in parts.values():
        for text in attributes.values():
            check_expanded(text, path)
    try:
        mass, center, axes, inertia = _values(parts)
    except InputError as error:
        return Inertial(link.name, unreadable=error.what)
    offset = link.parts["inertia"][1]
    given = frozen(center), frozen(inertia), frozen(axes)
    return Inertial(link.name, mass, *given, offset=offset)


def _values(parts: dict[str, dict[str, str]]) -> tuple[float, Array, Array, Array]:
    """Mass, COM (3,), axes and tensor (3, 3) of an `Inertial`; `InputError` for missing
    or invalid numbers."""
    mass = _number(parts, "mass", "value")
    center, quaternion = read_origin(parts.get("origin", {}), "")
    entries = np.array([_number(parts, "inertia", name) for name in ENTRIES])
    for name, value in zip(
        ("mass", "COM", "tensor"), (mass, center, entries), strict=True
    ):
        if np.abs(value).max() > LARGEST_PARAMETER:
            raise InputError(f"the {name} has a number above {LARGEST_PARAMETER:.0e}")
    return mass, center, rotation_matrices(quaternion), vector_to_tensor(entries)


def _number(parts: dict[str, dict[str, str]], tag: str, name: str) -> float:
    if tag not in parts:
        raise InputError(f"there is no <{tag}>")
    if name not in parts[tag]:
        raise InputError(f"<{tag}> has no {name}")
    return read_numbers(parts[tag][name], 1, f"the {tag}'s {name}", "")[0]

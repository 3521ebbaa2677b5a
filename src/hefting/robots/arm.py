"""An arm to draw: poses of its links at given joint positions, and their geometry:
meshes, boxes, cylinders and spheres.

URDFs are not trusted: they are read by `hefting.core.files.parse_xml`, meshes only from
the folders of `mesh_file`, and numbers and sizes are bounded. Meshes that are missing or
of an unknown kind are left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Self
from urllib.parse import unquote

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import parse_xml, read_xml
from hefting.core.recording import Recording
from hefting.core.spatial import Array, frozen, immutable
from hefting.robots.joint_motion import named_columns
from hefting.robots.robot import Robot
from hefting.robots.urdf import Tree, read_numbers, read_origin, read_urdf

Part = Literal["visual", "collision"]

MOST_PARTS = 2_000
"""Most visual and collision elements of a robot."""
SIZES = {"box": ("size", 3), "cylinder": ("radius length", 2), "sphere": ("radius", 1)}
"""Attributes of each simple geometry, and the number of their values."""
LARGEST_SIZE = 1e3
"""[m] Largest coordinate or size of a geometry."""


@immutable
class Geometry:
    """A visual or collision element of a link, in the link's frame."""

    link: str
    part: Part
    position: Array
    """(3,) [m] of the geometry in the link's frame"""
    orientation: Array
    """(4,) unit quaternion x, y, z, w"""
    kind: str
    """``"mesh"`` or a key of `SIZES`"""
    size: tuple[float, ...]
    """scale of a mesh along its axes, or the values of `SIZES` [m]"""
    file: Path | None = None
    """of a mesh, by `mesh_file`"""


def read_geometries(path: str | Path) -> tuple[Geometry, ...]:
    """The geometries of the links of a URDF, without meshes that `mesh_file` does not
    find.

    Raises `InputError` for a number that is not finite or too large, for more than
    `MOST_PARTS` elements, and for a file that `parse_xml` refuses.
    """
    parts: list[_Element] = []
    link = ""

    def start(tag: str, attributes: dict[str, str], _: int, inside: list[str]):
        nonlocal link
        if len(inside) == 1 and tag == "link":
            link = attributes.get("name", "")
        elif inside[1:] == ["link"] and tag in ("visual", "collision"):
            parts.append(_Element(link, tag))  # type: ignore[arg-type]
        elif parts and inside[1:3] == ["link", parts[-1].part]:
            parts[-1].inner.setdefault(tag, attributes)
        if len(parts) > MOST_PARTS:
            raise InputError(f"has more than {MOST_PARTS:,} visual parts", where=path)

    parse_xml(read_xml(path), path, start)
    return tuple(_geometries(parts, path))


def mesh_file(name: str, folder: Path) -> Path | None:
    """The file of a mesh that a URDF names, in the URDF's `folder` or below it, or in
    the ROS package that contains the URDF.

    ``package://PACKAGE/meshes/x.stl`` is looked for as ``meshes/x.stl`` and as
    ``PACKAGE/meshes/x.stl``, then in the nearest folder above that is called PACKAGE
    and has a ``package.xml``. None for an absolute path, another URL, a path or symbolic
    link out of these folders, and a missing file.
    """
    text = unquote(name)
    if "\0" in text:
        return None
    root = folder.resolve()
    places = [(root, text)]
    if text.startswith("package://"):
        whole = text.removeprefix("package://")
        package, _, inside = whole.partition("/")
        places = [(root, inside), (root, whole)]
        places += [(above, inside) for above in _packages(root, package)]
    elif "://" in text or text.startswith("/"):
        return None
    for place, path in places:
        try:
            file = (place / path).resolve()
            if path and file.is_relative_to(place) and file.is_file():
                return file
        except (OSError, RuntimeError, ValueError):  # too long, or links in a circle
            continue
    return None


def _packages(folder: Path, name: str) -> list[Path]:
    """The nearest folder above that is the ROS package of this name, if any."""
    above = (each for each in (folder, *folder.parents) if each.name == name)
    return [each for each in above if (each / "package.xml").is_file()][:1]


@dataclass
class _Element:
    """A visual or collision element, with the attributes of the elements inside."""

    link: str
    part: Part
    inner: dict[str, dict[str, str]] = field(default_factory=dict)


def _geometries(parts: list[_Element], path: str | Path) -> Iterator[Geometry]:
    folder = Path(path).parent
    for element in parts:
        where = f"{path}, link '{element.link[:40]}'"
        position, orientation = read_origin(element.inner.get("origin", {}), where)
        kind = next((k for k in ("mesh", *SIZES) if k in element.inner), None)
        if kind is None:
            continue
        attributes = element.inner[kind]
        file = None
        if kind == "mesh":
            file = mesh_file(attributes.get("filename", ""), folder)
            if file is None:
                continue
            size = read_numbers(attributes.get("scale", "1 1 1"), 3, "a scale", where)
        else:
            names, count = SIZES[kind]
            text = " ".join(attributes.get(name, "") for name in names.split())
            size = read_numbers(text, count, f"the size of a {kind}", where)
        if np.abs((*position, *size)).max() > LARGEST_SIZE:
            what = f"a visual part is larger than {LARGEST_SIZE:g} m"
            raise InputError(what, where, "give lengths in metres")
        yield Geometry(
            element.link,
            element.part,
            frozen(position),
            frozen(orientation),
            kind,
            tuple(size),
            file,
        )


MOST_LINKS = 200
"""Most links that are drawn or checked; humanoids with hands have about a hundred."""


@immutable
class Link:
    """A link to draw."""

    name: str
    parent: int | None
    """index of the parent link; None for the root"""
    geometries: tuple[Geometry, ...]
    robot: Robot
    """joints from the root to the link"""
    columns: tuple[int, ...]
    """of these joints in the recording's joint positions"""


@immutable
class Arm:
    """The links of a robot whose joints were recorded, parents before children."""

    links: tuple[Link, ...]

    @classmethod
    def from_urdf(
        cls, path: str | Path, sensor_frame: str, recording: Recording
    ) -> Self:
        """The links of a URDF whose poses follow from a recording's joint positions.

        Links after a joint that was not recorded, such as the fingers of a gripper, and
        those beyond `MOST_LINKS` are left out. Raises `InputError` as
        `Robot.from_urdf`, `with_poses` and `read_geometries`.
        """
        tree, looks = read_urdf(path), read_geometries(path)
        columns = named_columns(recording, Robot.from_tree(tree, sensor_frame))
        links: list[Link] = []
        places: dict[str, int] = {}
        for name, parent in links_in_order(tree)[:MOST_LINKS]:
            robot = robot_of(tree, name)
            if robot is None or set(robot.joints) - set(columns):
                continue
            places[name] = len(links)
            own = tuple(look for look in looks if look.link == name)
            above = None if parent is None else places[parent]
            moved = tuple(columns[joint] for joint in robot.joints)
            links.append(Link(name, above, own, robot, moved))
        return cls(tuple(links))

    def poses(self, q: Array) -> tuple[Array, Array]:
        """Positions (N, L, 3) [m] and orientations (N, L, 4) of the links in the root
        frame, at joint positions (N, n) as recorded."""
        position = np.empty((len(q), len(self.links), 3))
        orientation = np.empty((len(q), len(self.links), 4))
        for i, link in enumerate(self.links):
            own = q[:, list(link.columns)]
            position[:, i], orientation[:, i] = link.robot.poses(own)
        return position, orientation


def robot_of(tree: Tree, link: str) -> Robot | None:
    """The joints that move a link; None if one is floating or planar."""
    try:
        return Robot.from_tree(tree, link)
    except InputError:
        return None


def links_in_order(tree: Tree) -> list[tuple[str, str | None]]:
    """Each link with its parent, parents first."""
    children: dict[str, list[str]] = {link: [] for link in tree.links}
    for joint in tree.joints.values():
        children[joint.parent].append(joint.child)
    order: list[tuple[str, str | None]] = [(tree.root, None)]
    for link, _ in order:  # grows during the loop
        order += [(child, link) for child in children[link]]
    return order

"""An arm as it is drawn: its links, where they are at given joint positions, and what
they look like: meshes, boxes, cylinders and spheres.

A URDF is hostile until shown otherwise: it is read by `hefting.core.files.parse_xml`,
meshes are taken only from the folder of the URDF and those below it, and what is drawn
is bounded. A mesh that is not there, or of a kind that is not read, is left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Self
from urllib.parse import unquote

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import parse_xml, read_xml
from hefting.core.immutable import immutable
from hefting.core.recording import Recording
from hefting.core.spatial import Array, frozen
from hefting.robots.joint_log import named_columns
from hefting.robots.robot import Robot
from hefting.robots.urdf import Tree, read_numbers, read_origin, read_urdf

Part = Literal["visual", "collision"]

MOST_PARTS = 2_000
"""Most visual and collision elements of a robot."""
SIZES = {"box": ("size", 3), "cylinder": ("radius length", 2), "sphere": ("radius", 1)}
"""Attributes of each simple geometry, and how many numbers they are."""
LARGEST_SIZE = 1e3
"""[m] No part of an arm is larger."""


@immutable
class Geometry:
    """One element that a link looks like, in the frame of the link."""

    link: str
    part: Part
    position: Array
    """(3,) [m] of the geometry in the link's frame"""
    orientation: Array
    """(4,) unit quaternion x, y, z, w"""
    kind: str
    """``"mesh"`` or a key of `SIZES`"""
    size: tuple[float, ...]
    """scale of a mesh along its axes; else the numbers of `SIZES` [m]"""
    file: Path | None = None
    """of a mesh, inside the folder of the URDF"""


def read_geometries(path: str | Path) -> tuple[Geometry, ...]:
    """What the links of a URDF look like.

    Meshes that are not in the URDF's folder or below it, by whatever link, are left
    out. Raises `InputError`, naming the link, for a number that is not finite or too
    large, for more than `MOST_PARTS` elements, and for a file that `parse_xml` refuses.
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
    the ROS package that holds the URDF.

    ``package://PACKAGE/meshes/x.stl`` is looked for as ``meshes/x.stl`` and as
    ``PACKAGE/meshes/x.stl``, then in the nearest folder above that is called PACKAGE
    and has a ``package.xml``. None for an absolute path, another address, a path or a
    link that leads out of these folders, and where there is no such file.
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
    """The nearest folder above that is a ROS package of this name, if any is."""
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
        _check_size(np.concatenate((position, size)), where)
        yield Geometry(
            element.link,
            element.part,
            frozen(position),
            frozen(orientation),
            kind,
            tuple(size),
            file,
        )


def _check_size(values: Array, where: str) -> None:
    if np.abs(values).max() > LARGEST_SIZE:
        raise InputError(
            f"a visual part is larger than {LARGEST_SIZE:g} m",
            where,
            "give lengths in metres",
        )


MOST_LINKS = 200
"""Links that are drawn or checked at most; humanoids with hands have about a hundred."""


@immutable
class Link:
    """A link that is drawn."""

    name: str
    parent: int | None
    """Index of the link that bears it; None of the root"""
    geometries: tuple[Geometry, ...]
    """What it looks like, as far as that is there"""
    robot: Robot
    """The joints that move it"""
    columns: tuple[int, ...]
    """Column of the recording's joint positions of each of these"""


@immutable
class Arm:
    """The links of a robot whose joints were recorded, parents before children."""

    links: tuple[Link, ...]

    @classmethod
    def from_urdf(
        cls, path: str | Path, sensor_frame: str, recording: Recording
    ) -> Self:
        """The links of a URDF that the joint positions of a recording move.

        Links behind a joint that was not recorded, such as the fingers of a gripper, are
        left out, and those beyond `MOST_LINKS`. Raises `InputError` as
        `Robot.from_urdf`, `with_poses` and `read_geometries` do.
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
            bearer = None if parent is None else places[parent]
            moved = tuple(columns[joint] for joint in robot.joints)
            links.append(Link(name, bearer, own, robot, moved))
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
    """The joints that move a link; None where one of them has no single position."""
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
    for link, _ in order:  # grows on the way
        order += [(child, link) for child in children[link]]
    return order

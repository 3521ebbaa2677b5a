"""Reading the kinematic tree of a URDF: its links and joints.

Source: the URDF XML specification (https://wiki.ros.org/urdf/XML). Meshes, inertias and
extensions are skipped. The file is not trusted: it is read by
`hefting.core.files.parse_xml`, its numbers must be finite, and its links one tree.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.files import check_no_xacro, is_xacro, parse_xml, read_xml
from hefting.core.spatial import Array, frozen, immutable

SCALAR = ("revolute", "continuous", "prismatic")
"""Kinds of joint with one position: [rad], [rad], [m]."""

KINDS = (*SCALAR, "fixed", "floating", "planar")
"""All kinds of joint."""

PARTS = ("parent", "child", "origin", "axis", "mimic", "limit")
"""Elements of a joint that are read."""

LONGEST_NAME = 200
"""Most characters of a name."""

MOST = 2_000
"""Most links, and most joints, of one robot; humanoids with hands have some hundred."""


@immutable
class Joint:
    """A joint: the child link's frame is the parent's moved by `position` and
    `orientation`, then by the joint's motion."""

    name: str
    kind: str
    """One of `KINDS`."""
    parent: str
    child: str
    position: Array
    """(3,) of the joint in the parent link's frame [m]"""
    orientation: Array
    """(4,) unit quaternion x, y, z, w, joint axes in parent link axes"""
    axis: Array
    """(3,) unit vector in joint axes; meaningless for fixed and floating joints"""
    mimic: tuple[str, float, float] | None = None
    """Mimicked joint, multiplier, offset: position = multiplier * other + offset."""
    limits: tuple[float, float] | None = None
    """Lowest and highest position of a revolute joint [rad], if given."""
    speed: float | None = None
    """Highest speed [rad/s], or [m/s] of a prismatic joint, if given."""


@immutable
class Tree:
    """Links and joints of one robot, which are one tree."""

    source: str
    """Path of the file, for messages."""
    root: str
    links: tuple[str, ...]
    """In the file's order."""
    joints: dict[str, Joint]
    """By name, in the file's order."""

    def chain(self, link: str) -> list[Joint]:
        """Joints from the root to `link`, in that order."""
        above = {joint.child: joint for joint in self.joints.values()}
        joints = []
        while link in above:
            joints.append(above[link])
            link = above[link].parent
        return joints[::-1]


def read_urdf(path: str | Path) -> Tree:
    """The kinematic tree of a URDF.

    Raises `InputError`, naming file and joint, if the file cannot be read, is not
    well-formed XML, is not URDF or contains xacro, has a document type or more than
    `MOST` links, or if a name is missing or repeated, a kind of joint unknown, a number
    not finite, an axis zero, a link unknown, or the links are not one tree.
    """
    links: list[str] = []
    raw: list[tuple[dict[str, str], dict[str, dict[str, str]]]] = []

    def start(tag: str, attributes: dict[str, str], _: int, inside: list[str]):
        check_tag(tag, path, is_root=not inside)
        if len(inside) == 1 and tag == "link":
            links.append(read_name(attributes, "name", "a <link>", path))
        elif len(inside) == 1 and tag == "joint":
            raw.append((attributes, {}))
        elif inside[1:] == ["joint"] and tag in PARTS:
            raw[-1][1].setdefault(tag, attributes)
        if max(len(links), len(raw)) > MOST:
            raise InputError(f"has more than {MOST:,} links or joints", where=path)

    parse_xml(read_xml(path), path, start)
    joints = [_joint(attributes, parts, path) for attributes, parts in raw]
    check_repeated(links, "links", path)
    check_repeated([joint.name for joint in joints], "joints", path)
    return Tree(
        str(path),
        _root(links, joints, path),
        tuple(links),
        {joint.name: joint for joint in joints},
    )


def listed(names: Iterable[str], most: int = 40) -> str:
    """Names separated by commas, the first `most` of them."""
    names = list(names)
    return ", ".join(names[:most]) + (
        f", ... ({len(names)} in all)" if len(names) > most else ""
    )


def check_tag(tag: str, path: str | Path, *, is_root: bool) -> None:
    """`InputError` for an element of xacro, and for a root other than a URDF's."""
    check_no_xacro(tag, path)
    if is_root and tag != "robot":
        what = f"is not URDF: its root is <{tag[:40]}>, not <robot>"
        raise InputError(what, where=path)


def check_expanded(text: str, where: str | Path) -> None:
    """`InputError` for text with xacro's expressions."""
    if "${" in text or "$(" in text:
        raise is_xacro(where)


def read_name(attributes: dict[str, str], key: str, what: str, where: object) -> str:
    """An attribute that is a name; `InputError` if it is missing or too long."""
    name = attributes.get(key, "")
    check_expanded(name, str(where))
    if not name.strip() or len(name) > LONGEST_NAME:
        raise InputError(
            f"{what} has {'too long a' if name.strip() else 'no'} {key}", where=where
        )
    return name


def read_numbers(text: str, count: int, what: str, where: str) -> list[float]:
    """`count` finite numbers separated by blanks; else `InputError` about `what`."""
    check_expanded(text, where)
    parts = text.split(maxsplit=count)
    try:
        numbers = [float(part.replace("_", "x")) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(f"{what} is '{text[:40]}', not {wanted}", where=where)
    return numbers


def _joint(
    attributes: dict[str, str], parts: dict[str, dict[str, str]], path: str | Path
) -> Joint:
    name = read_name(attributes, "name", "a <joint>", path)
    where = f"{path}, joint '{name}'"
    kind = attributes.get("type", "")
    if kind not in KINDS:
        what = f"its type is '{kind[:40]}'{nearest(kind[:40], KINDS)}"
        raise InputError(what, where, f"use {', '.join(KINDS)}")
    position, orientation = read_origin(parts.get("origin", {}), where)
    axis = np.array((1.0, 0.0, 0.0))
    if "axis" in parts and kind not in ("fixed", "floating"):
        axis = np.array(
            read_numbers(parts["axis"].get("xyz", "1 0 0"), 3, "the axis", where)
        )
        largest = np.abs(axis).max()
        if largest == 0.0:
            raise InputError("the axis is zero", where=where)
        axis = axis / largest
    mimic, limits, speed = None, None, None

    def number(tag: str, key: str, what: str, default: str = "0") -> float:
        return read_numbers(parts[tag].get(key, default), 1, what, where)[0]

    if "mimic" in parts and kind in SCALAR:
        other = read_name(parts["mimic"], "joint", "the mimic", where)
        multiplier = number("mimic", "multiplier", "the mimic's multiplier", "1")
        mimic = other, multiplier, number("mimic", "offset", "the mimic's offset")
    if "limit" in parts and kind == "revolute":
        low, high = (number("limit", key, key) for key in ("lower", "upper"))
        limits = (low, high) if low < high else None
    if "limit" in parts and kind in SCALAR:
        velocity = number("limit", "velocity", "velocity")
        speed = velocity if velocity > 0.0 else None
    return Joint(
        name,
        kind,
        read_name(parts.get("parent", {}), "link", "its <parent>", where),
        read_name(parts.get("child", {}), "link", "its <child>", where),
        frozen(position),
        frozen(orientation),
        frozen(axis / np.linalg.norm(axis)),
        mimic,
        limits,
        speed,
    )


def read_origin(attributes: dict[str, str], where: str) -> tuple[Array, Array]:
    """Position (3,) and unit quaternion (4,); roll, pitch, yaw turn about the fixed
    axes x, y, z in that order."""
    position = np.array(
        read_numbers(attributes.get("xyz", "0 0 0"), 3, "the origin's xyz", where)
    )
    if "quat_xyzw" in attributes:  # URDF 1.2
        quaternion = np.array(
            read_numbers(attributes["quat_xyzw"], 4, "the origin's quat_xyzw", where)
        )
        norm = np.linalg.norm(np.clip(quaternion, -2.0, 2.0))
        if abs(norm - 1.0) > 1e-3:
            raise InputError("the origin's quat_xyzw is not of unit norm", where=where)
        return position, quaternion / norm
    half = 0.5 * np.array(
        read_numbers(attributes.get("rpy", "0 0 0"), 3, "the origin's rpy", where)
    )
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    quaternion = (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
    return position, np.array(quaternion)


def check_repeated(names: list[str], what: str, path: str | Path) -> None:
    """`InputError` for a name that occurs twice."""
    seen = set()
    for name in names:
        if name in seen:
            raise InputError(f"two {what} are named '{name}'", where=path)
        seen.add(name)


def _root(links: list[str], joints: list[Joint], path: str | Path) -> str:
    if not links:
        raise InputError("has no links", where=path)
    known = set(links)
    children: dict[str, list[str]] = {link: [] for link in links}
    above: dict[str, Joint] = {}
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in known:
                what = f"there is no link '{link}'{nearest(link, links)}"
                raise InputError(what, where=f"{path}, joint '{joint.name}'")
        if joint.child in above:
            what = f"link '{joint.child}' is the child of two joints ('{above[joint.child].name}', '{joint.name}')"
            raise InputError(what, where=path, fix="a URDF is a tree: cut the loop")
        above[joint.child] = joint
        children[joint.parent].append(joint.child)
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        fix = "connect them by joints (type fixed, if need be)"
        what = f"the links are not one tree; roots are {listed(roots, 10)}"
        raise InputError(what, where=path, fix=fix)
    reached, queue = set(roots), roots[:]
    while queue:
        below = children[queue.pop()]
        reached.update(below)
        queue += below
    if len(reached) < len(links):
        lost = [link for link in links if link not in reached]
        what = f"joints form a loop through {listed(lost, 10)}"
        raise InputError(what, path, "a URDF is a tree: cut the loop")
    return roots[0]

"""An arm as it is drawn: its links, where they are at given joint positions, and what
they look like."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from hefting.robots.joint_log import named_columns
from hefting.robots.robot import Robot
from hefting.robots.urdf import Tree, read_urdf
from hefting.robots.visuals import Geometry, read_geometries

MOST_LINKS = 200
"""Links that are drawn or checked at most; humanoids with hands have about a hundred."""


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
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
            unknown = robot is None or set(robot.joints) - set(columns)
            if robot is None or unknown:
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

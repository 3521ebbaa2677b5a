"""The space of a motion: half-spaces that it stays in, and no contacts between links and
object."""

import re
from collections.abc import Sequence
from dataclasses import field
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.messages import Message, note, warning
from hefting.core.spatial import Array, Indices, frozen, immutable
from hefting.planning.solids import (
    OBJECT,
    Contacts,
    MovingLink,
    Solid,
    read_disabled_pairs,
    read_links,
    solid_of,
    solids_of_links,
)
from hefting.robots.robot import Robot
from hefting.robots.urdf import Tree, listed, read_urdf

AXES = {"x": "1,0,0", "y": "0,1,0", "z": "0,0,1"}
LARGEST = 1e3
"""[m] Largest distance of a wall."""
EXAMPLE = "as in z>=0.05, x<=0.6 or 0.7,0.7,0>=-0.3, in metres"


@immutable
class HalfSpace:
    """Points p with ``normal . p >= offset`` in the axes of the robot's root frame.

    Examples
    --------
    >>> HalfSpace.parse("z >= 0.05").clearance([0.0, 0.0, 0.15])
    0.1
    """

    text: str
    """as it was written, for messages"""
    normal: Array
    """(3,) unit vector into it"""
    offset: float
    """[m]"""

    @classmethod
    def parse(cls, text: str) -> Self:
        """The half-space of an inequality: ``z>=0.05``, ``x<=0.6``, or with the factors
        of x, y and z, ``0.7,0.7,0>=-0.3``, which is 0.7 x + 0.7 y >= -0.3 m.

        Raises `InputError` for another text, factors that are all zero, and a plane
        more than `LARGEST` from the origin.
        """
        match = re.fullmatch(r"\s*([^<>=]+?)\s*(>=|<=)\s*([^<>=]+?)\s*", text)
        words = [*AXES.get(match[1], match[1]).split(","), match[3]] if match else []
        try:
            numbers = np.array([float(word.replace("_", "?")) for word in words])
        except ValueError:
            numbers = np.empty(0)
        factors = numbers[:3]
        is_one = len(numbers) == 4 and np.isfinite(numbers).all()
        if match is None or not is_one or np.abs(factors).max() > LARGEST:
            raise InputError(f"'{text[:60]}' is no half-space", fix=EXAMPLE)
        bound = float(numbers[3])
        size = float(np.linalg.norm(factors))
        if not size > 0.0 or not abs(bound) <= LARGEST * size:
            what = f"'{text[:60]}' is no half-space within {LARGEST:g} m"
            raise InputError(what, fix=EXAMPLE)
        sign = 1.0 if match[2] == ">=" else -1.0
        plain = "".join(text.split())
        return cls(plain, frozen(sign * factors / size), sign * bound / size)

    def clearance(self, points: Array) -> Array:
        """Distance (...) [m] of points (..., 3) from its boundary, negative outside."""
        return np.asarray(points) @ self.normal - self.offset


SAMPLES = 200
"""Number of random configurations by which pairs that always touch are found."""
MOSTLY = 0.95
"""Share of random configurations: solids that touch in more are assumed to be too large,
and are not checked, as by MoveIt's setup assistant."""
SAME = 1e-9
"""[m] Largest difference of equal distances."""
FAR = 0.1
"""[m] Largest clearance that is computed, to save time."""


@immutable
class Space:
    """Half-spaces, and solids of a robot and the object that it holds.

    Examples
    --------
    >>> space = Space.of("robot.urdf", "tool0", keep=["z>=0.02"])  # doctest: +SKIP
    >>> space.clearance(q).min()  # doctest: +SKIP
    0.083
    """

    half_spaces: tuple[HalfSpace, ...]
    links: tuple[MovingLink, ...]
    solids: tuple[Solid, ...]
    """of the links, then of the object's box if it is given"""
    outside: tuple[tuple[int, int], ...]
    """indices of solid and half-space of each pair that is checked"""
    contacts: Contacts | None
    """pairs of solids that are checked; None without coal or pairs"""
    messages: tuple[Message, ...] = field(default=())
    """about what is not checked"""

    @classmethod
    def of(
        cls,
        urdf: str | Path,
        tip: str,
        keep: Sequence[str | HalfSpace] = (),
        corners: ArrayLike | None = None,
        srdf: str | Path | None = None,
    ) -> Self:
        """The space of a robot.

        Parameters
        ----------
        urdf, tip : the robot, and the link whose frame holds the object.
        keep : half-spaces in the axes of its root link, see `HalfSpace.parse`. Links
            that no joint moves are not held to them.
        corners : (8, 3) [m] of the object's box in the tip's frame.
        srdf : file of the pairs of links that are not checked for collisions.

        Solids are the convex hulls of the collision geometry. Links that one joint
        connects are not checked against each other, nor is the object against the link
        that holds it. Raises `InputError` for a file, a tip or a half-space that cannot be
        read.
        """
        tree = read_urdf(urdf)
        robot = Robot.from_tree(tree, tip)
        half_spaces = tuple(
            each if isinstance(each, HalfSpace) else HalfSpace.parse(each)
            for each in keep
        )
        disabled = read_disabled_pairs(srdf, tree.links) if srdf else frozenset()
        links = read_links(tree, robot)
        box = None if corners is None else frozen(np.asarray(corners, dtype=float))
        solids, messages = _solids(tree, tip, links, box)
        bounds = _finite(robot.limits)
        random = np.random.default_rng(0).uniform(
            *bounds.T, size=(SAMPLES, len(bounds))
        )
        poses = _poses(links, solids, random)
        outside, more = _outside(half_spaces, links, solids, poses)
        contacts, others = _contacts(links, solids, disabled, poses)
        return cls(
            half_spaces,
            tuple(links),
            tuple(solids),
            outside,
            contacts,
            (*messages, *more, *others),
        )

    def clearance(self, q: Array) -> Array:
        """Smallest signed distance (K,) [m] at positions (K, n) of the tip's joints:
        negative in a collision, at most `FAR`."""
        return self._nearest(q)[0]

    def nearest(self, q: Array) -> tuple[float, str]:
        """Smallest signed distance [m] at joint positions (n,) or (K, n), and the names
        of the two things, as in ``"link 'elbow' and z>=0.02"``."""
        distance, outside, pair = self._nearest(np.atleast_2d(q))
        k = int(np.argmin(distance))
        if pair[k] >= 0 and self.contacts is not None:
            first, second = self.contacts.pairs[pair[k]]
            names = f"{self.solids[first].name} and {self.solids[second].name}"
        elif outside[k] >= 0:
            solid, half = self.outside[outside[k]]
            names = f"{self.solids[solid].name} and {self.half_spaces[half].text}"
        else:
            names = "nothing"
        return float(distance[k]), names

    def _nearest(self, q: Array) -> tuple[Array, Indices, Indices]:
        """Smallest distance (K,), and the index (K,) of its pair in `outside` and in the
        pairs of `contacts`, or -1."""
        position, rotation = _poses(self.links, self.solids, np.asarray(q, float))
        distance, which = np.full(len(position), FAR), np.full(len(position), -1)
        for i, (s, half) in enumerate(self.outside):
            pose = position[:, s], rotation[:, s]
            own = _inside(self.solids[s], self.half_spaces[half], pose)
            nearer = own < distance
            distance[nearer], which[nearer] = own[nearer], i
        if self.contacts is None:
            return distance, which, np.full(len(position), -1)
        distance, pair = self.contacts.nearest(position, rotation, distance)
        return distance, which, pair


def _finite(limits: Any) -> Array:
    """Ranges (n, 2) of joints; half a turn to each side without limits."""
    ends = [(0.0, 0.0) if own is None else own for own in limits]
    return np.nan_to_num(np.array(ends, dtype=float), posinf=np.pi, neginf=-np.pi)


def _poses(
    links: Sequence[MovingLink], solids: Sequence[Solid], q: Array
) -> tuple[Array, Array]:
    """Positions (K, S, 3) and rotations (K, S, 3, 3) of the solids' links."""
    known = {i: links[i].pose(q) for i in {solid.link for solid in solids}}
    if not solids:
        return np.empty((len(q), 0, 3)), np.empty((len(q), 0, 3, 3))
    position = np.stack([known[solid.link][0] for solid in solids], axis=1)
    rotation = np.stack([known[solid.link][1] for solid in solids], axis=1)
    return position, rotation


def _inside(solid: Solid, half: HalfSpace, pose: tuple[Array, Array]) -> Array:
    """Signed distance (K,) [m] of a solid from the boundary of a half-space."""
    position, rotation = pose
    along = np.einsum("kij,i->kj", rotation, half.normal) @ solid.vertices.T
    return half.clearance(position) + along.min(axis=1)


def _solids(
    tree: Tree, tip: str, links: list[MovingLink], corners: Array | None
) -> tuple[list[Solid], list[Message]]:
    """Solids of the links and the object. Each group of moving links without a solid gets
    the origin of its first link's frame as one, with a warning."""
    solids = solids_of_links(tree.source, links)
    drawn = {links[solid.link].group for solid in solids}
    bare = {
        link.group: i
        for i, link in reversed(list(enumerate(links)))
        if link.columns and link.group not in drawn
    }
    messages = []
    if bare:
        names = [links[i].name for i in sorted(bare.values())]
        solids += [
            solid_of(f"link '{name}'", i, np.zeros((1, 3)))
            for name, i in zip(names, sorted(bare.values()), strict=True)
        ]
        what = (
            f"no geometry could be read of {listed(names, 6)}: collisions with them are "
            "not checked, and with half-spaces only those of the origins of their frames"
        )
        messages.append(warning("plan-links-without-geometry", what))
    if corners is not None:
        own = next(i for i, link in enumerate(links) if link.name == tip)
        solids.append(solid_of(OBJECT, own, corners))
    return solids, messages


def _outside(
    half_spaces: Sequence[HalfSpace],
    links: Sequence[MovingLink],
    solids: Sequence[Solid],
    poses: tuple[Array, Array],
) -> tuple[tuple[tuple[int, int], ...], list[Message]]:
    """Pairs of solid and half-space to check: without solids that are outside, or inside
    at a constant distance, in all configurations."""
    kept, never = [], []
    for s, solid in enumerate(solids):
        if not links[solid.link].columns:
            continue
        for h, half in enumerate(half_spaces):
            own = _inside(solid, half, (poses[0][:, s], poses[1][:, s]))
            if own.min() >= 0.0 and np.ptp(own) < SAME:
                continue  # it turns about the half-space's normal, as a shoulder does
            if own.max() >= 0.0:
                kept.append((s, h))
            elif solid.name == OBJECT:
                what = f"{OBJECT} is outside {half.text} in every pose of the arm"
                raise InputError(what, fix="the axes are those of the URDF's root link")
            else:
                never.append(f"{solid.name} of {half.text}")
    if not never:
        return tuple(kept), []
    what = f"not checked, as outside in every pose of the arm: {listed(sorted(set(never)), 6)}"
    return tuple(kept), [warning("plan-half-space-unchecked", what)]


def _contacts(
    links: Sequence[MovingLink],
    solids: Sequence[Solid],
    disabled: frozenset[frozenset[str]],
    poses: tuple[Array, Array],
) -> tuple[Contacts | None, list[Message]]:
    """Pairs of solids to check, without those that touch nearly always."""
    pairs = [
        (i, j)
        for j in range(len(solids))
        for i in range(j)
        if _may_meet(links, solids[i], solids[j], disabled)
    ]
    if not pairs:
        return None, []
    try:
        every = Contacts(solids, np.array(pairs))
    except MissingDependencyError as missing:
        what = f"collisions of links and object were not checked: {missing}"
        return None, [warning("plan-collisions-unchecked", what)]
    always = every.touching(*poses).mean(axis=0) > MOSTLY
    checked = Contacts(solids, every.pairs[~always]) if not always.all() else None
    if not always.any():
        return checked, []
    names = sorted(
        {f"{solids[i].name} and {solids[j].name}" for i, j in every.pairs[always]}
    )
    what = f"not checked, as they touch in nearly all poses: {listed(names, 6)}"
    return checked, [note("plan-pairs-unchecked", what)]


def _may_meet(
    links: Sequence[MovingLink],
    one: Solid,
    other: Solid,
    disabled: frozenset[frozenset[str]],
) -> bool:
    """Whether two solids are checked: no points, and on links that move relative to each
    other and are not neighbours or disabled."""
    if not (len(one.faces) and len(other.faces)):
        return False
    first, second = links[one.link], links[other.link]
    if first.group == second.group:
        return False
    if OBJECT in (one.name, other.name):
        return True
    if frozenset((first.name, second.name)) in disabled:
        return False
    return first.neighbour != second.group and second.neighbour != first.group

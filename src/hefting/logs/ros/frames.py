"""Frames: the tree of tf messages, and the pose of one frame in another along it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, warning
from hefting.core.spatial import Array, interpolated
from hefting.logs.ros.series import Series

LONG_GAP = 10
"""Largest gap, in median steps, across which a link is interpolated."""


@dataclass(frozen=True)
class Link:
    """The pose of `child` in `parent`."""

    parent: str
    child: str
    series: Series
    """x, y, z [m], quaternion x, y, z, w"""
    static: bool
    """whether the pose is constant; there is one sample then"""

    def covers(self, time: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Mask of the times [ns] at which a moving link is interpolated: at its samples,
        or between two without a long gap."""
        own = self.series.time
        after = np.searchsorted(own, time)
        inside = (time >= own[0]) & (time <= own[-1])
        steps = np.diff(own)
        after = np.clip(after, 1, len(own) - 1)
        return inside & (
            (steps[after - 1] <= LONG_GAP * np.median(steps)) | np.isin(time, own)
        )

    def at(self, time: NDArray[np.int64]) -> tuple[Array, Rotation]:
        """Position (k, 3) and rotation at times [ns] within the link's own:
        interpolated between samples."""
        if self.static:
            values = np.repeat(self.series.values, len(time), axis=0)
            return values[:, :3], Rotation.from_quat(values[:, 3:])
        origin = self.series.time[0]
        own = (self.series.time - origin).astype(float)
        wanted = (time - origin).astype(float)
        position = interpolated(wanted, own, self.series.values[:, :3])
        turns = Slerp(own, Rotation.from_quat(self.series.values[:, 3:]))
        return position, turns(wanted)


def checked(raw: Link, series: Series, where: str, live: bool = False) -> Link:
    """`raw` with its tidied samples, as a static link where all are equal; not in a
    `live` stream, where it may move later.

    Raises `InputError` without samples, and for a quaternion that is not of unit norm.
    """
    if not len(series):
        raise InputError("has no finite pose", where, "repair what publishes it")
    norm = np.linalg.norm(series.values[:, 3:], axis=1)
    if np.abs(norm - 1).max() > 1e-2:
        k = int(np.argmax(np.abs(norm - 1) > 1e-2))
        what = f"the quaternion has norm {norm[k]:.4g}, not 1"
        fix = "repair its publisher"
        raise InputError(what, f"{where}, message {series.rows[k]}", fix)
    alike = len(series) == 1 or not live
    static = raw.static or (alike and bool((series.values == series.values[0]).all()))
    return Link(raw.parent, raw.child, series[-1:] if static else series, static)


@dataclass
class Tree:
    """Links by their child frame."""

    where: str
    links: dict[str, list[Link]] = field(default_factory=dict)

    def add(self, new: Link) -> None:
        """Add a link, or replace that between the same frames."""
        others = [
            old for old in self.links.get(new.child, []) if old.parent != new.parent
        ]
        self.links[new.child] = [*others, new]

    def replace(self, new: Link) -> None:
        """Replace all links to a link's child by it."""
        self.links[new.child] = [new]

    @property
    def frames(self) -> set[str]:
        """Names of all frames."""
        return set(self.links) | {
            link.parent for links in self.links.values() for link in links
        }

    def fixed_to(self, frame: str) -> set[str]:
        """The frame, and all that static links connect to it."""
        neighbours: dict[str, list[str]] = {}
        for link in (link for links in self.links.values() for link in links):
            if link.static:
                neighbours.setdefault(link.parent, []).append(link.child)
                neighbours.setdefault(link.child, []).append(link.parent)
        found, left = {frame}, [frame]
        while left:
            new = set(neighbours.get(left.pop(), ())) - found
            found |= new
            left += new
        return found

    def upward(self, frame: str) -> list[Link]:
        """Links from `frame` up to the root of its tree."""
        chain: list[Link] = []
        while frame in self.links:
            links = self.links[frame]
            if len(links) > 1:
                parents = " and ".join(sorted(link.parent for link in links))
                what = f"frame {frame} has two parents, {parents}"
                raise InputError(what, self.where, "keep one publisher of it")
            if len(chain) == len(self.links):
                what = f"the parents of frame {frame} go in a circle"
                raise InputError(what, self.where, "repair the tf tree")
            chain.append(links[0])
            frame = links[0].parent
        return chain

    def chain(self, world: str | None, sensor: str) -> list[tuple[Link, bool]]:
        """Links from `world` (by default the root above `sensor`) to `sensor`, each
        with whether it goes down.

        Empty when they are not connected. `InputError` for an unknown frame.
        """
        for frame, option in ((world, "`world_frame`"), (sensor, "`sensor_frame`")):
            if frame is not None and frame not in self.frames:
                what = f"tf has no frame '{frame}'{nearest(frame, self.frames)}"
                fix = f"give {option} one of {list_names(self.frames)}"
                raise InputError(what, where=self.where, fix=fix)
        down = self.upward(sensor)
        if world is None:
            return [(link, True) for link in reversed(down)]
        up = self.upward(world)
        while down and up and down[-1] is up[-1]:
            down.pop()
            up.pop()
        ends = (down[-1].parent if down else sensor, up[-1].parent if up else world)
        return (
            [(link, False) for link in up] + [(link, True) for link in reversed(down)]
            if ends[0] == ends[1]
            else []
        )


def compose(
    chain: Sequence[tuple[Link, bool]], where: str, warn: Callable[[Message], None]
) -> Series:
    """Pose (k, 7) along a chain of links, at the stamps of the moving link with the most
    samples.

    The other moving links are interpolated at these stamps; those that are not covered
    (`Link.covers`) are left out. One sample when no link moves. `InputError` when the
    links never overlap in time.
    """
    if len(chain) == 1 and chain[0][1]:
        return chain[0][0].series
    moving = [link for link, _ in chain if not link.static]
    lead = max(moving or [link for link, _ in chain], key=lambda link: len(link.series))
    base = lead.series
    inside = np.ones(len(base), dtype=bool)
    for other in moving:
        if other is not lead:
            inside &= other.covers(base.time)
    if not inside.any():
        what = "the moving links between the frames never overlap in time"
        raise InputError(what, f"{where}, tf {route(chain)}", "record them together")
    if not inside.all():
        what = f"{(~inside).sum()} of {len(base)} stamps of {lead.child} lie where another link of the chain has none"
        warn(warning("tf-stamps-uncovered", what))
    base = base[inside]
    position, rotation = np.zeros((len(base), 3)), Rotation.identity(len(base))
    for each, downward in chain:
        if each is lead:
            step, turn = base.values[:, :3], Rotation.from_quat(base.values[:, 3:])
        else:
            step, turn = each.at(base.time)
        if not downward:
            turn = turn.inv()
            step = -turn.apply(step)
        position = position + rotation.apply(step)
        rotation = rotation * turn
    poses = np.concatenate([position, rotation.as_quat()], axis=1)
    return Series(base.time, base.logged, base.rows, poses)


def route(chain: Sequence[tuple[Link, bool]]) -> str:
    """The frames along a chain, for messages."""
    if not chain:
        return ""
    first, downward = chain[0]
    names = [first.parent if downward else first.child]
    return " -> ".join(
        names + [link.child if down else link.parent for link, down in chain]
    )


def list_names(names: set[str] | Sequence[str]) -> str:
    """The first 20 names in order, separated by commas, and the number of the others."""
    ordered = sorted(names)
    more = f" and {len(ordered) - 20} more" if len(ordered) > 20 else ""
    return ", ".join(ordered[:20]) + more

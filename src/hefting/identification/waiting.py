"""Waiting samples: poses, motions and wrenches of a live stream that are used once
others have come."""

from dataclasses import field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements
from hefting.core.spatial import Array, immutable
from hefting.logs.arrays import numbers, position_and_orientation, unit_quaternions
from hefting.motion import Motion
from hefting.motion.spline import check_poses

LONGEST_WAIT = 60.0
"""[s] Time after which waiting samples are dropped, to bound the memory if a stream
stops."""
LONGEST_WRENCH_GAP = 0.1
"""[s] Instants between two wrench samples farther apart are left out: motion that is
slow enough for people near by changes the wrench little in a tenth of a second."""
MOVED = (0.005, 0.01)
"""[m], [rad] Changes of the pose that are motion: the noise of robots' poses is below a
tenth of them."""


@immutable
class Poses:
    """Successive poses of the sensor in the world."""

    time: Array
    """(K,) [s]"""
    position: Array | None
    """(K, 3) [m]; None where it is not measured."""
    orientation: Array
    """(K, 4) unit quaternions x, y, z, w."""

    @classmethod
    def of(cls, time: ArrayLike, position: Any, orientation: Any, pose: Any) -> "Poses":
        """Of one sample or many, in any form that `hefting.as_recording` takes.

        Raises `InputError` for arrays that do not fit, are not finite, or whose times
        do not increase.
        """
        times, single = _times(time, "time")
        if pose is not None:
            if position is not None or orientation is not None:
                raise InputError("a pose and its parts are both given", "Live.update")
            times, (rows,) = _measured(times, single, pose=pose)
            position, orientation = position_and_orientation(rows)
        elif orientation is None:
            fix = "give `orientation`, or `pose`"
            raise InputError("there is no orientation", "Live.update", fix)
        else:
            given = {"orientation": orientation, "position": position}
            times, (rows, position) = _measured(times, single, **given)
            orientation = unit_quaternions(rows)
        for name, values in (("position", position), ("orientation", orientation)):
            _check_finite(name, times, values)
        return cls(*check_poses(times, position, orientation))

    def __getitem__(self, index: slice) -> "Poses":
        """The samples of a slice."""
        position = None if self.position is None else self.position[index]
        return Poses(self.time[index], position, self.orientation[index])

    def __add__(self, later: "Poses") -> "Poses":
        """With later poses; `InputError` if they are not later or lack the position."""
        if not len(self.time) or not len(later.time):
            return later if len(later.time) else self
        _check_later(self.time[-1], later.time[0], "time")
        if (self.position is None) != (later.position is None):
            what = "position was given at some times and not at others"
            raise InputError(what, "Live.update")
        position = None
        if self.position is not None and later.position is not None:
            position = np.concatenate((self.position, later.position))
        return Poses(
            np.concatenate((self.time, later.time)),
            position,
            np.concatenate((self.orientation, later.orientation)),
        )

    @property
    def first_moved(self) -> int | None:
        """Index of the first pose that differs by more than noise; None for none."""
        cosine = np.abs(self.orientation @ self.orientation[0]).clip(max=1.0)
        moved = 2.0 * np.arccos(cosine) > MOVED[1]
        if self.position is not None:
            way = np.linalg.norm(self.position - self.position[0], axis=1)
            moved |= way > MOVED[0]
        return int(np.argmax(moved)) if moved.any() else None


NO_POSES = Poses(np.empty(0), None, np.empty((0, 4)))


@immutable
class Pairing:
    """Motions and wrenches that wait for each other."""

    motions: tuple[Motion, ...] = ()
    """In order of time."""
    time: Array = field(default_factory=lambda: np.empty(0))
    """(N,) [s] of the wrenches"""
    wrench: Array = field(default_factory=lambda: np.empty((0, 6)))
    """(N, 6) on the object [N, N m]"""

    def with_motion(self, motion: Motion) -> Self:
        """With motion that is later than all before."""
        if not len(motion.time):
            return self
        latest = motion.time[-1]
        kept = [m for m in self.motions if m.time[-1] > latest - LONGEST_WAIT]
        return replace(self, motions=(*kept, motion))

    def with_wrench(self, time: ArrayLike, wrench: Any, sign: float) -> Self:
        """With wrenches that come later than all before, `sign` times those on the
        object; `InputError` for what does not fit."""
        times, single = _times(time, "wrench_time")
        times, (values,) = _measured(times, single, wrench=wrench)
        if values.shape != (len(times), 6):
            what = f"wrench has shape {values.shape}, not {(len(times), 6)}"
            raise InputError(what, "Live.update", "give force, then torque")
        _check_finite("wrench", times, values)
        if not len(times):
            return self
        if (np.diff(times) <= 0.0).any():
            raise InputError("wrench_time does not increase", "Live.update")
        if len(self.time):
            _check_later(self.time[-1], times[0], "wrench_time")
        kept = self.time > times[-1] - LONGEST_WAIT
        return replace(
            self,
            time=np.concatenate((self.time[kept], times)),
            wrench=np.concatenate((self.wrench[kept], sign * values)),
        )

    def paired(self, gravity: Array) -> tuple[Self, list[Measurements]]:
        """What still waits, and the samples whose motion and wrench have both come."""
        if not len(self.time) or not self.motions:
            return self, []
        latest, done, waiting = self.time[-1], [], []
        for motion in self.motions:
            count = int(np.searchsorted(motion.time, latest, side="right"))
            if count:
                done.append(motion[:count])
            if count < len(motion.time):
                waiting.append(motion[count:])
        if not done:
            return self, []
        samples = [self._measurements(motion, gravity) for motion in done]
        # of the wrenches those from the last one before the next motion on
        last = done[-1].time[-1]
        first = max(int(np.searchsorted(self.time, last, side="right")) - 1, 0)
        rest = replace(
            self,
            motions=tuple(waiting),
            time=self.time[first:],
            wrench=self.wrench[first:],
        )
        return rest, [z for z in samples if len(z)]

    def _measurements(self, motion: Motion, gravity: Array) -> Measurements:
        """Samples of a motion, except at instants in a gap of the wrench."""
        after = np.searchsorted(self.time, motion.time).clip(max=len(self.time) - 1)
        before = np.maximum(after - 1, 0)
        near = self.time[after] - self.time[before] <= LONGEST_WRENCH_GAP
        near |= self.time[after] == motion.time
        return motion[near].measurements(self.time, self.wrench, gravity)


def _times(time: ArrayLike, name: str) -> tuple[Array, bool]:
    """Times (K,), and whether a single sample was given."""
    times = numbers(time, name)
    if times.ndim > 1 or not np.isfinite(times).all():
        raise InputError(f"{name} is not (K,) finite numbers", "Live.update")
    return np.atleast_1d(times), times.ndim == 0


def _measured(time: Array, single: bool, **given: Any) -> tuple[Array, list[Any]]:
    """Times and numbers, of a single sample an array of one, without the samples that
    are NaN throughout: nothing was measured there, as where cells of a table are blank."""
    values: list[Any] = []
    measured = np.ones(len(time), dtype=bool)
    for name, each in given.items():
        if each is None:
            values.append(None)
            continue
        is_rotation = hasattr(each, "as_quat")
        rows = np.atleast_2d(each.as_quat()) if is_rotation else numbers(each, name)
        rows = rows[None] if single and not is_rotation else rows
        if rows.ndim and len(rows) == len(time):
            measured &= ~np.isnan(rows).all(axis=tuple(range(1, rows.ndim)))
        values.append(rows)
    if measured.all():
        return time, values
    return time[measured], [v if v is None else v[measured] for v in values]


def _check_finite(name: str, time: Array, values: Array | None) -> None:
    """`InputError` for a sample that is not finite, with its time; values (K, d) of
    another shape are refused elsewhere."""
    if values is None or values.ndim != 2 or len(values) != len(time):
        return
    bad = ~np.isfinite(values).all(axis=1)
    if bad.any():
        what = f"{name} at {time[np.argmax(bad)]:.9g} s is not finite"
        raise InputError(what, "Live.update", "leave that sample out, or make all NaN")


def _check_later(last: float, new: float, name: str) -> None:
    """`InputError` unless a sample is later than those before."""
    if not new > last:
        what = f"{name} {new:.9g} s is not later than {last:.9g} s before it"
        raise InputError(what, "Live.update", "give each sample once, in order")

"""Recording: a log as streams with their own clocks, without interpolation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError, check_number, nearest
from hefting.core.magnitudes import (
    LARGEST,
    LARGEST_TIME,
    SMALLEST_INTERVAL,
    explain_times,
    too_large,
)
from hefting.core.spatial import (
    CHUNK,
    WRENCH,
    Array,
    Indices,
    frozen,
    is_immutable,
    median,
    own,
)

COLUMNS: dict[str, tuple[str, ...]] = {
    "position": ("px", "py", "pz"),
    "orientation": ("qx", "qy", "qz", "qw"),
    "linear_velocity": ("vx", "vy", "vz"),
    "angular_velocity": ("wx", "wy", "wz"),
    "linear_acceleration": ("ax", "ay", "az"),
    "angular_acceleration": ("alx", "aly", "alz"),
    "joint_positions": ("q",),
    "joint_velocities": ("dq",),
    "joint_torques": ("tau",),
    "joint_currents": ("current",),
    "wrench": WRENCH,
    "gyroscope": ("gyro_x", "gyro_y", "gyro_z"),
    "accelerometer": ("accel_x", "accel_y", "accel_z"),
    "linear_accelerometer": ("linear_accel_x", "linear_accel_y", "linear_accel_z"),
}
"""Columns of each stream in the canonical log, in order; for joint streams the prefix
of q1..qn, dq1..dqn, tau1..taun, current1..currentn."""

JOINT_STREAMS = (
    "joint_positions",
    "joint_velocities",
    "joint_torques",
    "joint_currents",
)


def all_finite(values: NDArray[Any]) -> bool:
    """Whether no value is infinite or NaN."""
    with np.errstate(all="ignore"):
        # a sum needs no memory, and is finite only if all of them are
        total = np.add.reduce(values, axis=None)
    return bool(np.isfinite(total) or np.isfinite(values).all())


def parts(count: int) -> Iterator[slice]:
    """Successive slices of at most `CHUNK` of `count` samples."""
    return (slice(first, first + CHUNK) for first in range(0, count, CHUNK))


BLOCK_DURATION = 0.01
"""[s] Duration of a block of samples, short beside an arm's motion."""
FEWEST_SAMPLES_PER_BLOCK = 3
"""Smallest average number of samples in a block; slower sensors' samples are blocks."""


def block_starts(time: Array) -> Indices | None:
    """First sample of each block of samples at `time` (K,) [s]; None if the sensor is
    too slow for blocks."""
    if (
        len(time) < FEWEST_SAMPLES_PER_BLOCK
        or time[-1] <= time[0]
        or len(time) < FEWEST_SAMPLES_PER_BLOCK * (time[-1] - time[0]) / BLOCK_DURATION
    ):
        return None
    return np.flatnonzero(
        np.diff(np.floor((time - time[0]) / BLOCK_DURATION), prepend=-1.0)
    )


def column_names(stream: str, width: int) -> tuple[str, ...]:
    """Names of the `width` columns of a stream."""
    names = COLUMNS[stream]
    if stream in JOINT_STREAMS:
        return tuple(f"{names[0]}{i}" for i in range(1, width + 1))
    return names


@dataclass(frozen=True, eq=False)
class Stream:
    """N samples of one quantity. `InputError` unless the shapes agree and N > 0.

    Examples
    --------
    >>> import numpy as np
    >>> wrench = hefting.Stream(time=np.arange(3.0), values=np.zeros((3, 6)))
    >>> len(wrench), len(wrench[1:])
    (3, 2)
    """

    time: Array
    """(N,) [s]"""
    values: Array
    """(N, d), units and axes as in `Recording`"""
    rows: NDArray[np.integer[Any]] = field(default=None)  # type: ignore[assignment]
    """(N,) row of the source of each sample, counted from 1; by default 1..N"""

    def __post_init__(self):
        time, values = frozen(self.time), frozen(self.values)
        counted = np.arange(1, len(values) + 1, dtype=np.int32)
        rows: NDArray[np.integer[Any]] = counted if self.rows is None else self.rows
        if not (
            isinstance(rows, np.ndarray)
            and rows.dtype.kind == "i"
            and is_immutable(rows)
        ):
            rows = own(np.array(rows, dtype=np.int64))
        if (
            values.ndim != 2
            or values.size == 0
            or time.shape != rows.shape
            or time.shape != values.shape[:1]
        ):
            shapes = f"time {time.shape}, values {values.shape}, rows {rows.shape}"
            raise InputError(
                f"a stream needs time (N,), values (N, d) and rows (N,) with N > 0, not {shapes}"
            )
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "rows", rows)

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, index: slice | NDArray[Any]) -> Self:
        """The samples chosen by a slice, a mask (N,) or an index array."""
        time, values, rows = self.time[index], self.values[index], self.rows[index]
        if not isinstance(index, slice):  # these are copies
            time, values, rows = own(time), own(values), own(rows)
        return replace(self, time=time, values=values, rows=rows)


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Streams of one log, each with its own strictly increasing time.

    ======================== ===== ============================================================
    stream                   width meaning, unit
    ======================== ===== ============================================================
    ``position``             3     sensor origin in world [m]
    ``orientation``          4     sensor in world: unit quaternion x, y, z, w; q and -q are equal
    ``linear_velocity``      3     of the sensor origin, world axes [m/s]
    ``angular_velocity``     3     world axes [rad/s]
    ``linear_acceleration``  3     classical, of the sensor origin, world axes [m/s²]
    ``angular_acceleration`` 3     world axes [rad/s²]
    ``joint_positions``      n     [rad]
    ``joint_velocities``     n     [rad/s]
    ``joint_torques``        n     by the motors on the links [N m]; [N] of joints that slide
    ``joint_currents``       n     of the motors [A]
    ``wrench``               6     force [N], torque [N m] as recorded: sensor axes, sign undecided
    ``gyroscope``            3     sensor axes [rad/s]
    ``accelerometer``        3     specific force a - g, sensor axes [m/s²]
    ``linear_accelerometer`` 3     gravity removed, sensor axes [m/s²]
    ======================== ===== ============================================================

    Quaternions whose norm is within 0.01 of one are normalised. Raises `InputError`,
    naming source, row and column, for an unknown stream, a wrong width, a value that is
    not finite or beyond `hefting.core.magnitudes`, a time that does not increase within
    its stream, a quaternion that is not of unit norm, and joint names of another number than the joints.

    Examples
    --------
    >>> recording = hefting.read_log("demo/log.csv")
    >>> sorted(recording.streams)
    ['orientation', 'position', 'wrench']
    >>> recording["wrench"].values.shape
    (1000, 6)
    >>> recording.slice(start=2.0, duration=3.0).duration
    2.99
    """

    streams: Mapping[str, Stream]
    static: bool = False
    """Whether each row is a static pose; `time` then is the row's index."""
    source: str = "recording"
    """Name for messages, usually the file's."""
    warnings: tuple[str, ...] = ()
    """Warnings of the reader on what it could not decide."""
    notes: tuple[str, ...] = ()
    """Notes of the reader on what it chose, such as topics."""
    joint_names: tuple[str, ...] = ()
    """Names of the joint columns in order, if the log has them."""
    sensor_pose: Array | None = None
    """(4, 4) pose of the sensor in the logged frame [m], if it was given and applied to
    the poses."""
    angles: Stream | None = None
    """(N, 3) orientation as logged, if by three angles [rad]."""

    def __post_init__(self):
        given = self.streams.values() if isinstance(self.streams, Mapping) else [None]
        if not all(isinstance(stream, Stream) for stream in given):
            what = "streams must be a dictionary of hefting.Stream by name"
            fix = "hefting.as_recording takes arrays"
            raise InputError(what, where=self.source, fix=fix)
        for name in self.streams:
            if name not in COLUMNS:
                what = f"unknown stream '{name}'{nearest(name, COLUMNS)}"
                raise InputError(what, where=self.source)
        if not self.streams:
            raise InputError("there are no samples", where=self.source)
        streams = {name: self.streams[name] for name in COLUMNS if name in self.streams}
        for name, stream in streams.items():
            self._check(name, stream)
        if "orientation" in streams:
            streams["orientation"] = self._normalised(streams["orientation"])
        widths = {
            streams[name].values.shape[1] for name in JOINT_STREAMS if name in streams
        }
        if len(widths) > 1:
            raise InputError(
                "joint positions q, velocities dq, torques tau and currents differ in "
                "number",
                where=self.source,
            )
        if self.joint_names and widths and {len(self.joint_names)} != widths:
            what = (
                f"{len(self.joint_names)} joint names for {widths.pop()} joint columns"
            )
            raise InputError(what, where=self.source)
        object.__setattr__(self, "streams", streams)

    def _check(self, name: str, stream: Stream) -> None:
        columns = column_names(name, stream.values.shape[1])
        if stream.values.shape[1] != len(columns):
            what = f"has {stream.values.shape[1]} columns, not {len(columns)}"
            raise InputError(what, f"{self.source}, {name}")
        self._check_values(stream, ("time",), stream.time[:, None], LARGEST_TIME)
        self._check_values(stream, columns, stream.values, LARGEST.get(name, np.inf))
        forward = stream.time[1:] - stream.time[:-1] >= SMALLEST_INTERVAL
        if not forward.all():
            k = int(np.argmin(forward))
            what, fix = explain_times(stream.time, k, int(stream.rows[k]))
            raise InputError(
                f"time {stream.time[k + 1]:.9g} s {what} in the {name} stream ({columns[0]}..{columns[-1]})",
                where=f"{self.source}, row {stream.rows[k + 1]}, column time",
                fix=fix,
            )

    def _check_values(
        self, stream: Stream, columns: tuple[str, ...], values: Array, largest: float
    ) -> None:
        """`InputError`, naming row and column, for a value that is not finite or beyond
        the largest one; see `hefting.core.magnitudes`."""
        fix = "leave the cell blank where nothing was measured"
        if not all_finite(values):
            k, j = np.argwhere(~np.isfinite(values))[0]
            what = f"the value is {values[k, j]}"
        elif too_large(values, largest):
            k, j = np.argwhere((values > largest) | (values < -largest))[0]
            what = f"the value {values[k, j]:.6g} is beyond {largest:.0e}, which nothing is"
            fix += "; check the unit"
        else:
            return
        where = f"{self.source}, row {stream.rows[k]}, column {columns[j]}"
        raise InputError(what, where, fix)

    def _normalised(self, orientation: Stream) -> Stream:
        q = orientation.values
        norm = np.empty(len(q))
        with np.errstate(over="ignore"):
            for part in parts(len(q)):
                norm[part] = np.sqrt(np.einsum("ki,ki->k", q[part], q[part]))
        off = np.abs(norm - 1)
        if off.max() > 1e-2:
            k = np.argmax(off > 1e-2)
            what = f"the quaternion qx qy qz qw has norm {norm[k]:.4g}, not 1"
            where = f"{self.source}, row {orientation.rows[k]}, columns qx..qw"
            raise InputError(what, where=where, fix="give unit quaternions, w last")
        norm[off < 1e-15] = 1.0  # already normalised: leave its bits alone
        if (norm == 1.0).all():
            return orientation
        return replace(orientation, values=own(q / norm[:, None]))

    def __getitem__(self, name: str) -> Stream:
        """The stream `name`; `InputError` when the recording does not have it."""
        if name not in self.streams:
            columns = (
                f"columns {' '.join(COLUMNS[name])}"
                if name in COLUMNS
                else f"it has {', '.join(self.streams)}"
            )
            fix = None
            if name == "orientation" and "joint_positions" in self.streams:
                fix = "its joint angles tell it by a robot: give `urdf` and `sensor_frame`"
            raise InputError(f"has no {name} ({columns})", self.source, fix)
        return self.streams[name]

    def has(self, *names: str) -> bool:
        """Whether all of these streams exist."""
        return all(name in self.streams for name in names)

    def __repr__(self) -> str:
        rates = self.rates()
        streams = ", ".join(
            f"{name} {len(stream)}"
            + (f" at {rates[name]:.4g} Hz" if rates[name] else "")
            for name, stream in self.streams.items()
        )
        return f"<Recording {self.source!r}: {streams}>"

    @property
    def start(self) -> float:
        """Time of the first sample of any stream [s]."""
        return float(min(stream.time[0] for stream in self.streams.values()))

    @property
    def duration(self) -> float:
        """Time from the first to the last sample of any stream [s]; rows less one when
        static."""
        return (
            float(max(stream.time[-1] for stream in self.streams.values())) - self.start
        )

    def rates(self) -> dict[str, float]:
        """Samples per second [Hz] of each stream, by the median step; 0 for a single
        sample or static poses."""
        rates: dict[int, float] = {}  # streams of a table share their time
        for stream in self.streams.values():
            if id(stream.time) not in rates:
                known = not self.static and len(stream) > 1
                rates[id(stream.time)] = (
                    1 / median(np.diff(stream.time)) if known else 0.0
                )
        return {n: rates[id(stream.time)] for n, stream in self.streams.items()}

    def slice(self, start: float = 0.0, duration: float | None = None) -> Self:
        """The samples from `start` on, counted from the first sample, for less than
        `duration` [s].

        Times keep their values. Streams without a sample there are dropped;
        `InputError` when none is left. A static recording is sliced by row.
        """
        for name, value in (("start", start), ("duration", duration)):
            if value is not None:
                check_number(name, value, "seconds", self.source)
        if not start >= 0.0:
            what, fix = f"cannot start at {start:g} s", "give a `start` of 0 s or more"
            raise InputError(what, self.source, fix)
        if not (duration is None or duration > 0.0):
            what, fix = f"cannot take {duration:g} s", "give a `duration` above 0 s"
            raise InputError(what, self.source, fix)
        begin = self.start + start
        end = np.inf if duration is None else begin + duration
        kept = {}
        for name, stream in self.streams.items():
            first, last = np.searchsorted(stream.time, (begin, end))
            if last > first:
                kept[name] = stream[first:last]
        if not kept:
            what = f"no sample from {start:g} s on; it lasts {self.duration:g} s"
            raise InputError(what, where=self.source)
        return replace(self, streams=kept)

"""Samples of a live stream, the interface of their sources, and operations on samples:
checking, joining, and poses from joint positions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from hefting.core.errors import HeftingError, InputError, nearest
from hefting.core.magnitudes import LARGEST, LARGEST_TIME
from hefting.core.messages import Message
from hefting.core.recording import COLUMNS, JOINT_STREAMS, Recording, Stream
from hefting.core.spatial import Array, Mask
from hefting.robots import Robot, with_poses

APART = 1.0
"""[s] Distance of stamps from which on they may be of two clocks."""

UNIT_NORM = 0.01
"""Largest difference of a quaternion's norm from one, as in `hefting.Recording`."""

LARGEST_WRENCH = 1e7
"""[N], [N m] Larger values are of bad messages, not of another unit: sensors of 10 kN
in millinewtons have this range."""


class Samples(NamedTuple):
    """Some samples of one stream, in order of arrival.

    Examples
    --------
    >>> import numpy as np
    >>> some = Samples("wrench", np.array([0.0, 0.01]), np.zeros((2, 6)))
    >>> some.stream, some.values.shape
    ('wrench', (2, 6))
    """

    stream: str
    """Name of a stream of `hefting.Recording`, which says the units: ``"wrench"``,
    ``"position"``, ``"orientation"``, ``"joint_positions"``, ``"gyroscope"`` ..."""
    time: Array
    """(n,) [s] Stamps of the source's clock."""
    values: Array
    """(n, d)"""


def checked(samples: Samples) -> Samples:
    """`samples`; `InputError` for an unknown stream, naming the known ones, and for
    values of another shape."""
    name, time, values = samples
    if name not in COLUMNS:
        streams = ", ".join(COLUMNS)
        what = f"there is no stream '{name[:40]}'{nearest(name, COLUMNS)}"
        raise InputError(what, "live", f"use {streams}")
    width = len(COLUMNS[name])
    if name in JOINT_STREAMS:
        width = max(values.shape[-1], 1) if values.ndim == 2 else 1
    if values.shape != (len(time), width):
        shape = f"({len(time)}, {'n' if name in JOINT_STREAMS else width})"
        what = f"{name} has shape {values.shape}, not {shape} for {len(time)} times"
        raise InputError(what, "live")
    return samples


class SourceLostError(HeftingError):
    """The connection to a source is gone; it may be opened again.

    Examples
    --------
    >>> print(hefting.SourceLostError("tcp://robot:9000: the other end closed"))
    tcp://robot:9000: the other end closed
    """


class EndOfSource(HeftingError):
    """A source that ends, as a file does, has given all it has.

    Examples
    --------
    >>> print(hefting.EndOfSource("log.csv has ended"))
    log.csv has ended
    """


@runtime_checkable
class Source(Protocol):
    """Where the samples of a live stream come from: one file of `hefting.sources` a
    transport.

    A source is used by one thread: ``open``, ``read`` again and again, ``close``; after
    `SourceLostError` ``close`` and ``open`` again.
    """

    name: str
    """As the user named it."""
    chosen: tuple[Message, ...]
    """Notes for the user on choices, such as that of topics."""
    skipped: Counter[str]
    """Numbers of bad messages by reason."""

    def open(self) -> None:
        """Connect and choose topics.

        Raises `InputError` if the host refuses, there is no such topic (with the existing
        ones), or the schema is unknown.
        """
        ...

    def read(self, timeout: float) -> list[Samples]:
        """New samples, after waiting at most `timeout` [s] for them; [] without any.

        Raises `SourceLostError` when the connection is gone, and `EndOfSource` when a
        source that ends has given all.
        """
        ...

    def close(self) -> None:
        """Disconnect; does nothing if already disconnected."""
        ...


def arrays_of(samples: Samples) -> tuple[Array, Array] | None:
    """Times (n,) and values (n, d); None for arrays of other shapes."""
    columns = COLUMNS.get(samples.stream)
    time, values = np.asarray(samples.time), np.asarray(samples.values)
    if (
        columns is None
        or time.dtype.kind not in "fiu"
        or values.dtype.kind not in "fiu"
    ):
        return None
    if time.ndim != 1 or values.ndim != 2 or len(time) != len(values):
        return None
    joints = samples.stream in JOINT_STREAMS and values.shape[1] > 0
    if not joints and values.shape[1] != len(columns):
        return None
    return time.astype(float, copy=False), values.astype(float, copy=False)


def possible(name: str, time: Array, values: Array, skipped: Counter[str]) -> Mask:
    """Mask (n,) of samples that are finite and of possible size; counts others."""
    largest = LARGEST_WRENCH if name == "wrench" else LARGEST.get(name, np.inf)
    with np.errstate(all="ignore"):
        finite = np.isfinite(time) & np.isfinite(values).all(axis=1)
        size = np.abs(values).max(axis=1, initial=0.0)
        good = (np.abs(time) < LARGEST_TIME) & (size <= largest)
        if name == "orientation":
            norm = np.linalg.norm(values, axis=1)
            good &= np.abs(norm - 1.0) <= UNIT_NORM
    for reason, which in (("not finite", ~finite), ("impossible", finite & ~good)):
        if which.any():
            skipped[reason] += int(which.sum())
    return finite & good


def is_apart(before: Samples, after: Samples) -> bool:
    """Whether `after` begins more than `APART` from the end of `before`."""
    ends, begins = np.ravel(before.time)[-1:], np.ravel(after.time)[:1]
    if (
        before is after
        or ends.dtype.kind not in "fiu"
        or begins.dtype.kind not in "fiu"
    ):
        return False
    return bool((np.abs(begins - ends) > APART).any())


def joined(parts: Sequence[Samples]) -> list[Samples]:
    """Samples of one stream in order of arrival, in as few parts as their widths allow;
    other arrays than (n,) and (n, d) are unchanged."""
    found: list[Samples] = []
    held: list[Samples] = []
    for part in parts:
        if held and _width(part) != _width(held[0]):
            found.append(_one(held))
            held = []
        held.append(part)
    return [*found, _one(held)] if held else found


def poses_of(samples: Samples, robot: Robot) -> list[Samples]:
    """Position and orientation of the sensor from joint positions. Raises `InputError`
    if these are not the robot's."""
    # row numbers, as stamps may still repeat
    order = np.arange(len(samples.time), dtype=float)
    log = Recording({"joint_positions": Stream(order, samples.values)}, source="live")
    posed = with_poses(log, robot)
    return [
        Samples(name, samples.time, posed[name].values)
        for name in ("position", "orientation")
    ]


def _width(samples: Samples) -> int | None:
    values, time = samples.values, samples.time
    fits = values.ndim == 2 and time.ndim == 1 and len(time) == len(values)
    return values.shape[1] if fits else None


def _one(parts: Sequence[Samples]) -> Samples:
    if len(parts) == 1 or _width(parts[0]) is None:
        return parts[0]
    time = np.concatenate([part.time for part in parts])
    return Samples(parts[0].stream, time, np.concatenate([p.values for p in parts]))

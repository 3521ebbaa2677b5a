"""Sources of the samples of a live stream: one file for each transport, one list
(`SCHEMES`).

This file has the names of sources, the options for them, and the check of their samples.
A new transport is one module that ends in its ``SOURCE``, called with a name and a
`Request`, and its line in `SCHEMES`.
"""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import NamedTuple
from urllib.parse import urlsplit

import numpy as np

from hefting.core.errors import InputError
from hefting.core.magnitudes import LARGEST, LARGEST_TIME
from hefting.core.messages import Message
from hefting.core.recording import COLUMNS, JOINT_STREAMS, Recording
from hefting.core.spatial import Array
from hefting.online.samples import UNIT_NORM, Samples, Source


class NamedSource:
    """Attributes that all sources have; see `hefting.online.samples.Source`."""

    def __init__(self, name: str):
        self.name = name
        self.chosen: tuple[Message, ...] = ()
        self.skipped: Counter[str] = Counter()


class Address(NamedTuple):
    """Where a source listens."""

    host: str
    port: int
    path: str
    """The rest, without slashes around it."""

    @property
    def place(self) -> str:
        """``HOST:PORT``, an IPv6 host in brackets."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}"


def address_of(name: str, port: int | None, example: str) -> Address:
    """Host, port and path of ``scheme://HOST[:PORT][/PATH]``; `port` is the default, None
    for a transport without one.

    Raises `InputError`, which shows an `example`, for a name without host or port, or
    with an impossible port.
    """
    try:
        parts = urlsplit(name)
    except ValueError:
        parts = urlsplit("")
    try:
        found = parts.port or port
    except ValueError:
        raise InputError("the port is not one", name, f"as in {example}") from None
    if not parts.hostname or found is None:
        missing = "port" if parts.hostname else "host"
        raise InputError(f"which {missing}?", name, f"as in {example}")
    return Address(parts.hostname, found, parts.path.strip("/"))


@dataclass(frozen=True)
class Request:
    """Options of sources, of which each transport uses its own."""

    topics: Mapping[str, str] = field(default_factory=dict)
    """topic, or "none", by role (wrench, pose, joint, imu), as in
    `hefting.logs.ros.read_bag`"""
    world_frame: str | None = None
    """Frame of the poses; by default the root of tf."""
    sensor_frame: str | None = None
    """Frame of the sensor; by default that of the wrench."""
    speed: float = 1.0
    """Factor on the speed at which a log is played; infinity is without pauses."""
    read: Callable[[str], Recording] | None = None
    """reads a log to be played; by default `hefting.read_log`"""


SCHEMES = {
    "tcp": "hefting.sources.tcp",
    "ws": "hefting.sources.foxglove_websocket",
    "wss": "hefting.sources.foxglove_websocket",
    "zenoh": "hefting.sources.zenoh_router",
    "dds": "hefting.sources.dds",
    "rtde": "hefting.sources.rtde",
}
"""Module of each transport, by scheme. Its functions import what is slow to import."""


def source_of(name: str, request: Request | None = None) -> Source:
    """The source named ``-``, ``scheme://...`` or by the path of a log to be played, not
    yet opened.

    Raises `InputError` for an unknown scheme, and for a name that its transport does not
    understand.
    """
    scheme, mark, _ = name.partition("://")
    kind = "SOURCE"
    if name == "-":
        module, kind = SCHEMES["tcp"], "StandardInput"
    elif not mark:
        module = "hefting.sources.played_log"
    elif scheme.lower() in SCHEMES:
        module = SCHEMES[scheme.lower()]
    else:
        known = ", ".join(f"{each}://" for each in SCHEMES)
        what = f"'{scheme[:40]}://' is no source"
        fix = f"use {known}, - for standard input, or a log"
        raise InputError(what, name, fix)
    return getattr(import_module(module), kind)(name, request or Request())


MAX_MESSAGE = 1_000_000
"""Largest message that is read [bytes]. A wrench has a hundred bytes, a transform tree
of a humanoid ten thousand."""

MAX_JOINTS = 1000

MAX_UNREAD = 50_000_000
"""Largest size of unread messages [bytes]: of 50,000 small ones, those of a robot in ten
seconds."""

TOO_LARGE = "larger than 1 MB"
UNREADABLE = "does not fit its definition"
QUEUE_FULL = "not read in time"
"""Reasons for which messages are skipped."""


def check(samples: Samples, skipped: Counter[str]) -> Samples | None:
    """The valid samples: finite, with the stream's width, of possible size, and with
    unit quaternions; None where none is left.

    The others are counted in `skipped`, by reason.
    """
    time = np.asarray(samples.time, dtype=float)
    values = np.asarray(samples.values, dtype=float)
    if not _has_shape(samples.stream, time, values):
        skipped["not the shape of a stream"] += max(time.size, 1)
        return None
    for reason, good in _checks(samples.stream, time, values):
        if not good.all():
            skipped[reason] += int((~good).sum())
            time, values = time[good], values[good]
            return check(Samples(samples.stream, time, values), skipped)
    return Samples(samples.stream, time, values) if len(time) else None


def _has_shape(stream: str, time: Array, values: Array) -> bool:
    if stream not in COLUMNS or values.ndim != 2 or time.shape != values.shape[:1]:
        return False
    if stream in JOINT_STREAMS:
        return 0 < values.shape[1] <= MAX_JOINTS
    return values.shape[1] == len(COLUMNS[stream])


def _checks(stream: str, time: Array, values: Array):
    everything = np.concatenate([time[:, None], values], axis=1)
    yield "values that are not finite", np.isfinite(everything).all(axis=1)
    yield "times that cannot be seconds", np.abs(time) <= LARGEST_TIME
    largest = LARGEST.get(stream, np.inf)
    yield "values that cannot be", (np.abs(values) <= largest).all(axis=1)
    if stream == "orientation":
        with np.errstate(over="ignore"):
            norm = np.sqrt((values * values).sum(axis=1))
        yield "quaternions that are not of unit norm", np.abs(norm - 1) <= UNIT_NORM


GATHERING = 0.01
"""[s] Time between reads. A live estimate is found right after one
(`hefting.online.identifier.LONGEST_WAIT`), mostly in less time than to the next."""


class Pace:
    """Limits the rate of reads: to decode messages together costs half as much as one by
    one (samples of RTDE at 500 Hz)."""

    def __init__(self):
        self._next = 0.0

    def wait(self) -> None:
        """Wait until `GATHERING` after the last call."""
        time.sleep(max(self._next - time.monotonic(), 0.0))
        self._next = time.monotonic() + GATHERING

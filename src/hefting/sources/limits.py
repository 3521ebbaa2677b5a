"""What is believed of a live stream (how large messages are, which samples can be), and
how often it is looked at."""

import time
from collections import Counter

import numpy as np

from hefting.core.magnitudes import LARGEST, LARGEST_TIME
from hefting.core.recording import COLUMNS, JOINT_STREAMS
from hefting.core.spatial import Array
from hefting.online.samples import Samples

MAX_MESSAGE = 1_000_000
"""[bytes] A wrench has a hundred, a transform tree of a humanoid ten thousand."""

MAX_JOINTS = 1000

MAX_QUEUED = 50_000
"""Messages that wait for being read: ten seconds of all that a robot sends."""

UNIT_NORM = 1e-2
"""From one, as `hefting.Recording` refuses quaternions."""

TOO_LARGE = "larger than 1 MB"
"""Why a message was skipped."""

UNREADABLE = "does not fit its definition"

QUEUE_FULL = "not read in time"


def check(samples: Samples, skipped: Counter[str]) -> Samples | None:
    """The samples that can be: finite, of a width and size that the stream has, with
    unit quaternions; None where none is left. Others are counted in `skipped`, by the
    reason."""
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
    """Reasons to leave samples out, and which are good (n,)."""
    everything = np.concatenate([time[:, None], values], axis=1)
    yield "values that are not finite", np.isfinite(everything).all(axis=1)
    yield "times that cannot be", np.abs(time) <= LARGEST_TIME
    largest = LARGEST.get(stream, np.inf)
    yield "values that cannot be", (np.abs(values) <= largest).all(axis=1)
    if stream == "orientation":
        with np.errstate(over="ignore"):
            norm = np.sqrt((values * values).sum(axis=1))
        yield "quaternions that are not of unit norm", np.abs(norm - 1) <= UNIT_NORM


GATHERING = 0.01
"""[s] between looks. A live estimate is found right after one
(`hefting.online.identifier.LONGEST_WAIT`), mostly in less time than to the next."""


class Pace:
    """Keeps looks at what came apart, as decoding together costs half as much as one by
    one (samples of RTDE at 500 Hz)."""

    def __init__(self):
        self._next = 0.0

    def wait(self) -> None:
        """Wait until `GATHERING` after the last time."""
        time.sleep(max(self._next - time.monotonic(), 0.0))
        self._next = time.monotonic() + GATHERING

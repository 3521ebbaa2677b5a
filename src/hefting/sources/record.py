"""Recorder of live samples to an MCAP file, with the messages of `hefting.write_log` and
the stamps of the source. The messages are not in chunks, so that an incomplete file can
be read up to its end."""

import os
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError, needing
from hefting.core.files import check_replaceable, lock
from hefting.core.recording import Stream
from hefting.core.spatial import Array
from hefting.logs.ros.writing import (
    EPOCH,
    McapOutput,
    Messages,
    channel_of,
    messages_at,
    serialise,
    streams_of,
)
from hefting.online.samples import Samples

BLOCK = 0.1
"""[s] Span of samples at which they are written; an incomplete file lacks as much."""

FAR_BACK = 1.0
"""[s] Step back of a stamp that means that the clock was set back. A new file is begun
then, as readers refuse such logs."""

POSES = ("position", "orientation")
"""Streams of a pose, which one message holds."""

PATIENCE = 1.0
"""[s] Longest wait of a half of a pose for the other half."""


class Recorder:
    """Writes samples to a file. Only one thread at a time may use it.

    Parameters
    ----------
    path : ends in .mcap; an existing file is replaced.

    `paths` are the files written so far, more than one where the source's clock was set
    back. `left_out` counts by stream the samples that no message holds, `count` all
    samples.

    Raises
    ------
    InputError
        Where the file cannot be written.
    MissingDependencyError
        Without foxglove-sdk or rosbags.
    """

    def __init__(self, path: str | Path):
        if Path(path).suffix != ".mcap":
            raise InputError("a record is an .mcap file", path, "as in log.mcap")
        self._path = Path(path)
        self.paths: list[Path] = []
        self.left_out: Counter[str] = Counter()
        self.count = 0
        self._waiting: dict[str, list[Samples]] = {}
        self._halves: dict[str, Samples] = {}
        """samples of half a pose whose other half may come"""
        self._poses: str | None = None
        """kind of messages of poses in the file: "pose" or "orientation", if any"""
        self._latest: dict[str, float] = {}
        self._shift: int | None = None
        self._file = _File(self._next_path())

    def add(self, samples: Samples) -> None:
        """Record samples, in the order in which they came; `InputError` once the file
        cannot be written."""
        latest = self._latest.get(samples.stream, -np.inf)
        if samples.time[0] < latest - FAR_BACK:
            self.close()
            self._latest, self._shift, self._poses = {}, None, None
            self._file = _File(self._next_path())
        elif samples.stream in self._waiting and self._is_due():
            # the stream comes again, so samples of the same times as its last are here
            self._write()
        self.count += len(samples.time)
        self._latest[samples.stream] = float(samples.time[-1])
        self._waiting.setdefault(samples.stream, []).append(samples)

    def close(self) -> None:
        """Write the waiting samples and end the file; `InputError` where that fails.
        Further calls do nothing."""
        self._write(ended=True)
        self._file.close()

    def _next_path(self) -> Path:
        number = len(self.paths) + 1
        name = self._path.stem if number == 1 else f"{self._path.stem}-{number}"
        self.paths.append(self._path.with_name(f"{name}.mcap"))
        return self.paths[-1]

    def _is_due(self) -> bool:
        spans = (
            parts[-1].time[-1] - parts[0].time[0] for parts in self._waiting.values()
        )
        return max(spans, default=0.0) >= BLOCK

    def _write(self, ended: bool = False) -> None:
        """Write the waiting samples, but no halves of poses unless it is `ended`."""
        waiting, self._waiting = self._waiting, {}
        halves, self._halves = self._halves, {}
        for name, half in halves.items():
            waiting[name] = [half, *waiting.get(name, [])]
        streams = {name: _joined(parts) for name, parts in waiting.items()}
        if not ended and self._poses != "orientation":
            self._hold_halves(streams)
        if not streams:
            return
        if self._shift is None:
            start = min(stream.time.min() for stream in streams.values())
            # a stamp of zero means that there is none
            self._shift = EPOCH if start < 1.0 else 0
        time: dict[str, NDArray[np.int64]] = {}
        for name, stream in list(streams.items()):
            stamps = _nanoseconds(stream.time) + self._shift
            good = stamps > 0
            self.left_out[name] += int((~good).sum())
            if good.any():
                streams[name], time[name] = stream[good], stamps[good]
            else:
                del streams[name]
        self._pair(streams, time)
        groups = list(messages_at(streams, time))
        written = {name for group in groups for name in streams_of(group)}
        for name in set(streams) - written:
            self.left_out[name] += len(streams[name])
        self._file.write(groups)

    def _hold_halves(self, streams: dict[str, Stream]) -> None:
        """Move halves of poses whose other half may come from `streams` to the waiting
        ones."""
        both = min(self._latest.get(name, -np.inf) for name in POSES)
        for name in set(POSES) & set(streams):
            own = streams.pop(name)
            waits = own.time > max(both, self._latest[name] - PATIENCE)
            if waits.any():
                self._halves[name] = Samples(name, own.time[waits], own.values[waits])
            if not waits.all():
                streams[name] = own[~waits]

    def _pair(
        self, streams: dict[str, Stream], time: dict[str, NDArray[np.int64]]
    ) -> None:
        """Keep the poses in `streams` and `time` that the file's kind of message holds,
        either whole poses or orientations alone, as readers use one topic; count the
        others."""
        none = np.empty(0, dtype=np.int64)
        places, turns = (time.get(name, none) for name in POSES)
        kept = [np.arange(len(places)), np.arange(len(turns))]
        if not np.array_equal(places, turns):
            _, *kept = np.intersect1d(places, turns, return_indices=True)
        if self._poses is None and len(turns):
            self._poses = "pose" if len(kept[1]) else "orientation"
        if self._poses == "orientation":
            kept = [none, np.arange(len(turns))]
        for name, index in zip(POSES, kept, strict=True):
            if name not in streams:
                continue
            own, when = streams.pop(name), time.pop(name)
            self.left_out[name] += len(own) - len(index)
            if len(index):
                streams[name], time[name] = own[index], when[index]


class _File:
    def __init__(self, path: Path):
        with needing("foxglove-sdk", "live"):
            from foxglove import Context, open_mcap
            from foxglove.mcap import MCAPWriteOptions
        with needing("rosbags", "live"):
            from rosbags.typesys import Stores, get_typestore
        check_replaceable(path)
        self.path, self._store = path, get_typestore(Stores.ROS2_HUMBLE)
        try:
            # other programs read it as it grows, so that it has its final name
            self._lock = path.open("ab")
            if os.name == "posix" and not lock(self._lock.fileno()):
                self._lock.close()
                what = "is written by another run"
                raise InputError(what, path, "choose another name")
            self._stream = path.open("wb", buffering=0)
        except OSError as error:
            raise self._error(error) from error
        self._context, self._output = Context(), McapOutput(self._stream)
        options = MCAPWriteOptions(use_chunks=False, compression=None, profile="ros2")
        self._writer: Any = open_mcap(
            self._output, context=self._context, writer_options=options
        )
        self._channels: dict[str, Callable[..., None]] = {}

    def write(self, groups: list[Messages]) -> None:
        """Write messages in the order of their stamps; `InputError` where this or an
        earlier call failed."""
        lines: list[tuple[int, Callable[..., None], bytes]] = []
        for group in groups:
            if group.topic not in self._channels:
                channel = channel_of(group, self._store, self._context)
                self._channels[group.topic] = channel.log
            send = self._channels[group.topic]
            rows = serialise(group, self._store, "cdr")
            stamps = group.time.tolist()
            lines += [
                (stamp, send, row.tobytes())
                for stamp, row in zip(stamps, rows, strict=True)
            ]
        for stamp, send, data in sorted(lines, key=lambda line: line[0]):
            send(data, log_time=stamp)
        self._check()

    def close(self) -> None:
        """End the file; `InputError` where it could not be written."""
        writer, self._writer = self._writer, None
        if writer is None:
            return
        writer.close()
        self._stream.close()
        self._lock.close()
        self._check()

    def _check(self) -> None:
        if self._output.error is not None:
            raise self._error(self._output.error)

    def _error(self, error: OSError) -> InputError:
        return InputError(f"cannot be written ({error.strerror or error})", self.path)


def _joined(parts: list[Samples]) -> Stream:
    """Samples in order of arrival, without those of another width than the first."""
    width = parts[0].values.shape[1]
    same = [part for part in parts if part.values.shape[1] == width]
    time = np.concatenate([part.time for part in same])
    return Stream(time, np.concatenate([part.values for part in same]))


def _nanoseconds(time: Array) -> NDArray[np.int64]:
    """Times [s] as stamps [ns], exact to the last digit."""
    whole = np.floor(time)
    part = np.rint((time - whole) * 1e9).astype(np.int64)
    return whole.astype(np.int64) * 1_000_000_000 + part

"""Lines of JSON, one for each instant: ``tcp://HOST:PORT`` from a program that listens
there, and ``-`` from standard input.

A line is an object with ``time`` [s] and any streams of `hefting.Recording`, such as
``{"time": 0.002, "wrench": [0, 0, -9.8, 0, 0, 0], "orientation": [0, 0, 0, 1]}``. Other
keys are ignored.
"""

import json
import os
import queue
import socket
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from hefting.core.errors import InputError, printable
from hefting.core.messages import note
from hefting.core.recording import COLUMNS
from hefting.online.samples import EndOfSource, Samples, SourceLostError
from hefting.sources import (
    MAX_JOINTS,
    MAX_MESSAGE,
    TOO_LARGE,
    NamedSource,
    Request,
    address_of,
)

NO_JSON = "not a JSON object"
NO_TIME = "no time in seconds"
NO_STREAM = "no stream of numbers"
"""Reasons for which lines are skipped."""


class JsonLines:
    """Turns pieces of text, of any size, into samples; counts bad lines in `skipped`."""

    def __init__(self, skipped: Counter[str]):
        self.skipped = skipped
        self._seen: set[str] = set()
        self._unknown = ""
        self._rest = b""
        self._is_overlong = False

    def feed(self, data: bytes) -> list[Samples]:
        """The samples in the lines that are complete with `data`, by stream."""
        *lines, rest = (self._rest + data).split(b"\n")
        if lines and self._is_overlong:
            lines, self._is_overlong = lines[1:], False
        if len(rest) > MAX_MESSAGE:
            # all of the line is dropped, up to its end
            if not self._is_overlong:
                self.skipped[TOO_LARGE] += 1
            self._is_overlong = True
        self._rest = b"" if self._is_overlong else rest
        return joined(entry for line in lines for entry in self._read(line))

    def end(self) -> list[Samples]:
        """The samples of a last line without a line end."""
        return self.feed(b"\n") if self._rest.strip() else []

    def _read(self, line: bytes) -> Iterator[tuple[str, float, list[float]]]:
        if not line.strip():
            return
        if len(line) > MAX_MESSAGE:
            self.skipped[TOO_LARGE] += 1
            return
        try:
            found: Any = json.loads(line)
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, dict):
            self.skipped[NO_JSON] += 1
            return
        time: Any = found.get("time")
        if not _is_number(time):
            self.skipped[NO_TIME] += 1
            return
        streams = {name: found[name] for name in COLUMNS if name in found}
        good = [name for name, values in streams.items() if _are_numbers(values)]
        bad = (len(streams) or 1) - len(good)
        self._seen |= set(good)
        odd = next((key for key in found if key not in COLUMNS and key != "time"), None)
        if odd is not None and "wrench" not in self._seen:
            # only the first is named, as there may be any number
            self._unknown = self._unknown or printable(odd[:40])
            self.skipped[f"'{self._unknown}' is no stream"] += 1
            bad -= not streams
        if bad:
            self.skipped[NO_STREAM] += bad
        yield from ((name, float(time), streams[name]) for name in good)


def joined(entries: Iterator[tuple[str, float, list[float]]]) -> list[Samples]:
    """Single samples (stream, time [s], values), gathered by stream and width."""
    gathered: dict[tuple[str, int], tuple[list[float], list[list[float]]]] = {}
    for name, time, values in entries:
        times, rows = gathered.setdefault((name, len(values)), ([], []))
        times.append(time)
        rows.append(values)
    return [
        Samples(name, np.array(times), np.array(rows, dtype=float))
        for (name, _), (times, rows) in gathered.items()
    ]


def _is_number(value: Any) -> bool:
    """Whether a value is a number whose square does not overflow."""
    return type(value) in (int, float) and abs(value) < 1e150


def _are_numbers(values: Any) -> bool:
    return (
        isinstance(values, list)
        and 0 < len(values) <= MAX_JOINTS
        and all(map(_is_number, values))
    )


PATIENCE = 3.0
"""[s] Longest wait for a connection."""

PIECE = 1 << 16
"""Largest number of bytes that are read at once."""


class SocketSource(NamedSource):
    """Address, socket and `close` of sources over a socket."""

    def __init__(self, name: str, port: int | None, example: str):
        super().__init__(name)
        self._address = address_of(name, port, example)
        self._socket: socket.socket | None = None

    def close(self) -> None:
        """Disconnect."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class TcpSource(SocketSource):
    """Lines of JSON from a socket."""

    def __init__(self, name: str, request: Request):
        super().__init__(name, None, "tcp://localhost:9000")
        self._lines = JsonLines(self.skipped)

    def open(self) -> None:
        """Connect; `InputError` where the host refuses."""
        self._lines = JsonLines(self.skipped)
        self._socket = connected(self.name, self._address[:2])
        self.chosen = (note("live-source", f"lines of JSON from {self.name}"),)

    def read(self, timeout: float) -> list[Samples]:
        """See `hefting.online.samples.Source`."""
        data = received(self._socket, self.name, timeout)
        return self._lines.feed(data) if data else []


def connected(name: str, address: tuple[str, int]) -> socket.socket:
    """A connected socket; `InputError` where the host refuses."""
    try:
        return socket.create_connection(address, PATIENCE)
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(
            f"cannot be reached ({why})",
            name,
            "check the host and the port, and that the program there runs",
        ) from error


def received(connection: socket.socket | None, name: str, timeout: float) -> bytes:
    """The bytes that came within `timeout` [s]; empty for none.

    Raises `SourceLostError` when the other end has closed.
    """
    if connection is None:
        raise SourceLostError(f"{name}: is closed")
    connection.settimeout(max(timeout, 1e-3))
    try:
        data = connection.recv(PIECE)
    except TimeoutError:
        return b""
    except OSError as error:
        raise SourceLostError(f"{name}: {error.strerror or error}") from error
    if not data:
        raise SourceLostError(f"{name}: the other end closed the connection")
    return data


PIECES = 64
"""Largest number of waiting pieces; the writer of the pipe waits then, and no data is
lost."""


class StandardInput(NamedSource):
    """Lines of JSON from a pipe; it ends where the pipe does.

    A thread reads, as some systems cannot wait for a pipe with a time limit.
    """

    def __init__(self, name: str, request: Request):
        super().__init__("standard input")
        self._lines = JsonLines(self.skipped)
        self._pieces: queue.Queue[bytes] = queue.Queue(PIECES)

    def open(self) -> None:
        """Begin to read."""
        self.chosen = (note("live-source", "lines of JSON from standard input"),)
        threading.Thread(target=self._read, daemon=True).start()

    def read(self, timeout: float) -> list[Samples]:
        """See `hefting.online.samples.Source`."""
        try:
            data = self._pieces.get(timeout=max(timeout, 1e-3))
        except queue.Empty:
            return []
        if data:
            return self._lines.feed(data)
        if last := self._lines.end():
            self._pieces.put(b"")
            return last
        raise EndOfSource("standard input has ended")

    def close(self) -> None:
        """Do nothing: the pipe stays open."""

    def _read(self) -> None:
        handle = sys.stdin.fileno()
        while True:
            try:
                data = os.read(handle, PIECE)
            except OSError:
                data = b""
            self._pieces.put(data)
            if not data:
                return


SOURCE = TcpSource

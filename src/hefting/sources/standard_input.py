"""``-``: lines of JSON on standard input."""

import os
import queue
import sys
import threading

from hefting.core.messages import note
from hefting.online.samples import EndOfSource, Samples
from hefting.sources import NamedSource, Request
from hefting.sources.tcp import JsonLines

PIECE = 1 << 16
"""Largest number of bytes that are read at once."""

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


SOURCE = StandardInput

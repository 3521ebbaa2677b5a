"""A source that plays a log at its own speed, or another."""

import time

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import Message, note
from hefting.core.recording import Recording
from hefting.online.samples import EndOfSource, Samples
from hefting.sources import NamedSource, Request

STEP = 0.01
"""[s] Longest part of the log that is given at once at its own speed."""


class PlayedLog(NamedSource):
    """The samples of a recording, each when it is due."""

    def __init__(self, name: str, request: Request, recording: Recording | None = None):
        if not request.speed > 0:
            what = f"a log cannot be played {request.speed:g} times as fast"
            raise InputError(what, name, "give a speed above 0")
        super().__init__(name)
        self._request, self._recording = request, recording
        self._done, self._begin = -np.inf, 0.0

    def open(self) -> None:
        """`InputError` as `hefting.read_log`, and for static poses."""
        from hefting.logs import read_log

        read = self._request.read or read_log
        recording = self._recording or read(self.name)
        if recording.static:
            what = "static poses have no times, which playing needs"
            raise InputError(what, self.name, "use hefting identify")
        self._recording = recording
        if self._done == -np.inf:
            # all before the first sample counts as given
            self._done = np.nextafter(recording.start, -np.inf)
        given = max(self._done - recording.start, 0.0)
        self._begin = time.monotonic() - given / self._request.speed
        messages = (*recording.notes, *recording.warnings)
        own = tuple(each for each in messages if isinstance(each, Message))
        played = f"{self.name} is played{self._pace_text()}"
        self.chosen = (note("live-source", played), *own)

    def _pace_text(self) -> str:
        """How fast the log is played, with a space before; empty at its own speed."""
        speed = self._request.speed
        if speed == 1:
            return ""
        if np.isfinite(speed):
            return f" at {speed:g} times its speed"
        return " without pauses"

    def read(self, timeout: float) -> list[Samples]:
        """See `hefting.online.samples.Source`."""
        recording = self._recording
        if recording is None:
            raise EndOfSource(f"{self.name} is closed")
        if self._done >= recording.start + recording.duration:
            raise EndOfSource(f"{self.name} has ended")
        until = self._due()
        if until <= self._done:
            time.sleep(min(timeout, STEP / self._request.speed))
            until = self._due()
        found = _between(recording, self._done, until)
        self._done = max(self._done, until)
        return found

    def close(self) -> None:
        """Do nothing: no resource is held."""

    def _due(self) -> float:
        assert self._recording is not None
        if np.isinf(self._request.speed):
            return float(self._done + STEP)
        passed = (time.monotonic() - self._begin) * self._request.speed
        step = max(STEP, STEP * self._request.speed)
        return float(min(self._recording.start + passed, self._done + step))


def _between(recording: Recording, after: float, until: float) -> list[Samples]:
    """Samples later than `after` and not later than `until` [s]."""
    found: list[Samples] = []
    for name, stream in recording.streams.items():
        first, last = np.searchsorted(stream.time, (after, until), side="right")
        if last > first:
            part = slice(first, last)
            found.append(Samples(name, stream.time[part], stream.values[part]))
    return found


SOURCE = PlayedLog

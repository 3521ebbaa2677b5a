"""`hefting.live`: successive live estimates from a source."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from hefting.core.errors import HeftingError, InputError
from hefting.core.messages import Message, note, warning
from hefting.logs.given import as_recording
from hefting.online.identifier import LiveIdentifier
from hefting.online.live_estimate import LiveEstimate
from hefting.online.samples import EndOfSource, Samples, Source, SourceLostError
from hefting.sources import Request, check, source_of
from hefting.sources.played_log import PlayedLog

SHORTEST_WAIT, LONGEST_WAIT = 0.1, 5.0
"""[s] Wait before the first attempt to connect again, doubled with each, and its upper
bound."""

STEP = 0.1
"""[s] Longest wait for samples between two checks whether to stop."""

SILENT = 2.0
"""[s] Time without samples, after the first, from which on a message says so."""

SILENCE = 5.0
"""[s] Longest time before the first sample."""

State = Literal["opening", "open", "silent", "lost", "ended", "failed"]


class Pump:
    """Reads a source in a thread of its own until the source ends or `close`.

    Parameters
    ----------
    source : opened, read and closed by the thread alone.
    deliver : called with checked samples; must not wait for long.
    tell : called with messages on the connection and on the chosen topics.
    patience : longest time [s] before the first sample; a longer one is an error.
        Infinite for a source that may start at any time.

    Attributes
    ----------
    state : of the connection.
    error : the error that ended it, if any.
    counts : number of samples delivered, and of connections lost.
    """

    def __init__(
        self,
        source: Source,
        deliver: Callable[[Samples], None],
        tell: Callable[[Message], None] = lambda message: None,
        patience: float = SILENCE,
    ):
        self.source, self.state, self.error = source, "opening", None
        self.state: State
        self.error: Exception | None
        self.counts: Counter[str] = Counter()
        self._deliver, self._tell, self._patience = deliver, tell, patience
        self._stop = threading.Event()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="source", daemon=True)

    def start(self) -> Pump:
        """Returns itself."""
        self._thread.start()
        return self

    def wait(self, timeout: float) -> bool:
        """Whether it is over, after waiting at most `timeout` [s]."""
        return self._over.wait(timeout)

    def close(self) -> None:
        """End it, and wait until the thread has closed the source; further calls do
        nothing."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(LONGEST_WAIT)

    def __enter__(self) -> Pump:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            with suppress(EndOfSource):
                self.source.open()
                self.state = "open"
                for message in self.source.chosen:
                    self._tell(message)
                self._read_until_stopped()
            if not self.counts["samples"]:
                self._check_readable()
            self.state = "ended"
        except Exception as error:  # any error, for the thread that waits
            self.state, self.error = "failed", error
        finally:
            self.source.close()
            self._over.set()

    def _read_until_stopped(self) -> None:
        begin = self._last_read = time.monotonic()
        while not self._stop.is_set():
            try:
                found = self.source.read(STEP)
            except (SourceLostError, InputError) as error:
                self._connect_again(error)
                continue
            for samples in found:
                good = check(samples, self.source.skipped)
                if good is not None:
                    self.counts["samples"] += len(good.time)
                    self._deliver(good)
            if found:
                self._heard()
            elif (
                self.counts["samples"]
                and self.state == "open"
                and time.monotonic() - self._last_read > SILENT
            ):
                self.state = "silent"
                what = f"{self.source.name}: no samples for {SILENT:g} s"
                self._tell(warning("source-silent", what))
            if not self.counts["samples"]:
                self._check_silence(time.monotonic() - begin)

    def _heard(self) -> None:
        before, self._last_read = self._last_read, time.monotonic()
        if self.state == "silent":
            self.state = "open"
            passed = self._last_read - before
            back = f"{self.source.name}: again after {passed:.1f} s"
            self._tell(note("source-back", back))

    def _check_silence(self, passed: float) -> None:
        if passed < self._patience:
            return
        self._check_readable()
        raise InputError(
            f"nothing arrives for {self._patience:g} s",
            self.source.name,
            "check that the robot's driver runs and sends",
        )

    def _check_readable(self) -> None:
        if skipped := self.source.skipped:
            (reason, count), *_ = skipped.most_common(1)
            raise InputError(
                f"nothing that can be read arrives: {count} skipped ({reason})",
                self.source.name,
                "see docs/sources.md for what is read",
            )

    def _connect_again(self, lost: HeftingError) -> None:
        self.counts["lost"] += 1
        self.state = "lost"
        self._tell(warning("source-lost", f"{lost}; trying to connect again"))
        pause, begin = SHORTEST_WAIT, time.monotonic()
        while True:
            self.source.close()
            if self._stop.wait(pause):
                return
            try:
                self.source.open()
            except (InputError, SourceLostError):
                pause = min(2 * pause, LONGEST_WAIT)
                continue
            break
        self.state, self._last_read = "open", time.monotonic()
        passed = time.monotonic() - begin
        text = f"{self.source.name}: connected again after {passed:.1f} s"
        self._tell(note("source-back", text))


LONGEST_STEP = 0.5
"""[s] Longest wait for an estimate between two checks whether the source has ended."""


def live(
    source: Any,
    shape: Any = None,
    *,
    speed: float = 1.0,
    tap: Callable[[Samples], None] | None = None,
    **options: Any,
) -> Iterator[LiveEstimate]:
    """Live estimates of what a robot holds, from a source of its streams.

    Parameters
    ----------
    source : Recording, Source, text, path, data frame or mapping
        A recording in any form that `hefting.identify` takes, which is played at its own
        speed; the address of a live source, as ``hefting live`` takes it; or a `Source`.
    shape : path, str, mesh, points or Shape, optional
        Where the object may have mass, as for `hefting.identify`.
    speed : float
        Factor on its own speed at which a recording is played; infinite: without
        pauses, with the same estimates as at its own speed.
    tap : callable, optional
        Called with all samples as they come, such as a recorder's ``add``.
    **options
        As for `hefting.LiveIdentifier`: ``until``, ``rate``, ``gravity`` and so on.

    Yields
    ------
    LiveEstimate
        When the source ends, the last one is that of `hefting.identify` on the whole
        stream; see `hefting.LiveIdentifier.close`.

    Raises
    ------
    InputError
        For a source that cannot be opened, or gives nothing.

    Examples
    --------
    >>> for now in hefting.live("demo/log.csv", speed=float("inf")):
    ...     last = now
    >>> last.state, round(last.estimate.mass, 2)
    ('identified', 0.67)
    """
    opened = _source(source, speed)
    if isinstance(opened, PlayedLog) and np.isinf(speed):
        yield from _as_fast_as_it_goes(opened, shape, tap, options)
        return
    with LiveIdentifier(shape, **options) as identifier:

        def deliver(samples: Samples) -> None:
            if tap is not None:
                tap(samples)
            identifier.add(samples)

        with Pump(opened, deliver, identifier.say) as pump:
            while not pump.wait(0.0):
                now = identifier.wait(LONGEST_STEP)
                if now is not None:
                    yield with_skipped(now, opened)
        if pump.error is not None:
            raise pump.error
        last = identifier.close()
        if last is not None:
            yield with_skipped(last, opened)


def _as_fast_as_it_goes(
    played: PlayedLog,
    shape: Any,
    tap: Callable[[Samples], None] | None,
    options: dict[str, Any],
) -> Iterator[LiveEstimate]:
    """The estimates at those times of the stream at which a live run yields them."""
    identifier = LiveIdentifier(shape, in_process=False, **options)
    played.open()
    for message in played.chosen:
        identifier.say(message)
    due = -np.inf
    for samples in _samples(played):
        begins = float(samples.time[0])
        due = begins + identifier.period if np.isinf(due) else due
        if begins > due:
            now = identifier.step()
            due = max(due + identifier.period, begins)
            if now is not None:
                yield now
        identifier.add(samples)
        if tap is not None:
            tap(samples)
    identifier.step()
    last = identifier.close()
    if last is not None:
        yield last


def _samples(played: PlayedLog) -> Iterator[Samples]:
    try:
        while True:
            yield from played.read(0.0)
    except EndOfSource:
        return


def with_skipped(now: LiveEstimate, source: Source) -> LiveEstimate:
    """An estimate whose counts include the messages that the source skipped."""
    skipped = now.counts.get("skipped", {}) + source.skipped
    return replace(now, counts={**now.counts, "skipped": skipped})


def _source(source: Any, speed: float) -> Source:
    if isinstance(source, str | Path):
        return source_of(str(source), Request(speed=speed))
    if isinstance(source, Source):
        return source
    recording = as_recording(source)
    return PlayedLog(recording.source, Request(speed=speed), recording)

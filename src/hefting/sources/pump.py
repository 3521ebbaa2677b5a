"""The thread between a source and who takes its samples: it opens, reads, connects
again, and counts."""

import threading
import time
from collections import Counter
from collections.abc import Callable
from typing import Literal

from hefting.core.errors import HeftingError, InputError
from hefting.core.messages import Message, note, warning
from hefting.online.samples import EndOfSource, Samples, Source, SourceLostError
from hefting.sources.limits import check

SHORTEST_WAIT, LONGEST_WAIT = 0.1, 5.0
"""Wait before the first attempt to connect again, doubled with each, and the longest
[s]."""

STEP = 0.1
"""Longest wait for samples before it is looked whether to stop [s]."""

SILENCE = 5.0
"""How long nothing may come at first [s]."""

State = Literal["opening", "open", "lost", "ended", "failed"]


class Pump:
    """Reads a source in a thread of its own until the source ends or `close`.

    Parameters
    ----------
    source : is opened, read and closed by the thread alone.
    deliver : is given samples that were checked; must not wait for long.
    tell : is given messages on the connection, and what was chosen, as they come.
    patience : how long nothing may come at first before that is an error [s]; infinite
        for a source that may begin whenever it likes.

    Attributes
    ----------
    state : of the connection.
    error : what ended it; None while nothing has, and where the source just ended.
    counts : samples delivered, and connections lost.
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

    def start(self) -> "Pump":
        """Begin; returns itself."""
        self._thread.start()
        return self

    def wait(self, timeout: float) -> bool:
        """Whether it is over, after waiting at most `timeout` [s]."""
        return self._over.wait(timeout)

    def close(self) -> None:
        """End it, and wait until the thread has closed the source; again does
        nothing."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(LONGEST_WAIT)

    def __enter__(self) -> "Pump":
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            self.source.open()
            self._open()
            self._read_until_stopped()
            self.state = "ended"
        except EndOfSource:
            self.state = "ended"
        except Exception as error:  # whatever it is, who waits is told
            self.state, self.error = "failed", error
        finally:
            self.source.close()
            self._over.set()

    def _open(self) -> None:
        self.state = "open"
        for message in self.source.chosen:
            self._tell(message)

    def _read_until_stopped(self) -> None:
        begin = time.monotonic()
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
            if not self.counts["samples"]:
                self._check_silence(time.monotonic() - begin)

    def _check_silence(self, passed: float) -> None:
        if passed < self._patience:
            return
        if skipped := self.source.skipped:
            (reason, count), *_ = skipped.most_common(1)
            raise InputError(
                f"nothing that can be read arrives: {count} skipped ({reason})",
                self.source.name,
                "see docs/sources.md for what is read",
            )
        raise InputError(
            f"nothing arrives for {self._patience:g} s",
            self.source.name,
            "check that the robot's driver runs and sends",
        )

    def _connect_again(self, lost: HeftingError) -> None:
        self.counts["lost"] += 1
        self.state = "lost"
        self._tell(warning("source-lost", f"{lost}; it is connected again"))
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
        self.state = "open"
        passed = time.monotonic() - begin
        text = f"{self.source.name}: connected again after {passed:.1f} s"
        self._tell(note("source-back", text))

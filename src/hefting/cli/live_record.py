"""What ``hefting live`` does beside estimates: the record of the samples that it gets,
where ``--record`` asks for one, and its end by Ctrl-C or a signal."""

import os
import signal
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.cli import render
from hefting.cli.parser import say
from hefting.core.errors import InputError

if TYPE_CHECKING:
    from hefting.online.samples import Samples


ENDS = ("SIGTERM", "SIGHUP")
"""Those signals, where the system has them: of ``timeout``, and of a closed terminal."""


@contextmanager
def interrupted_by_signals() -> Iterator[None]:
    """Make signals that request an end raise `KeyboardInterrupt` within the block."""
    asked = [getattr(signal, name) for name in ENDS if hasattr(signal, name)]
    asked = [each for each in asked if signal.getsignal(each) != signal.SIG_IGN]
    before = [signal.signal(each, _end) for each in asked]
    try:
        yield
    finally:
        for each, handler in zip(asked, before, strict=True):
            if signal.getsignal(each) is _end:
                signal.signal(each, handler)


def _end(number: int, _: Any) -> None:
    """End as Ctrl-C does; a closed terminal gets no output."""
    if number != signal.SIGTERM:
        signal.signal(number, signal.SIG_IGN)  # it may come again, from the shell
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for output in (1, 2):
            if stat.S_ISCHR(os.fstat(output).st_mode):
                os.dup2(nowhere, output)
    raise KeyboardInterrupt


class LiveRecord:
    """Writes samples to a file, if there is one. The first failure is shown, and ends
    the record alone: estimates do not need it.

    Parameters
    ----------
    path : of the file; None for no record.
    show : shows a line of text.

    Raises
    ------
    InputError, MissingDependencyError
        As `hefting.sources.record.Recorder` does.
    """

    def __init__(self, path: str | None, show: Callable[[str], None]):
        self.failed = False
        self._show, self._recorder = show, None
        if path:
            from hefting.sources.record import Recorder

            self._recorder = Recorder(path)

    def add(self, samples: "Samples") -> None:
        """Record samples, unless there was a failure."""
        if self._recorder is not None:
            self._attempt(self._recorder.add, samples)

    def close(self) -> None:
        """End the file, unless there was a failure."""
        if self._recorder is not None:
            self._attempt(self._recorder.close)

    def _attempt(self, step: "Callable[..., None]", *given: "Samples") -> None:
        if self.failed:
            return
        try:
            step(*given)
        except InputError as error:
            self.failed = True
            self._show(f"warning: recording stopped: {render(str(error))}")

    @property
    def whole(self) -> Path | None:
        """The file, if it is one with all samples; else None."""
        recorder = self._recorder
        if recorder is None or self.failed:
            return None
        if len(recorder.paths) > 1 or +recorder.left_out:
            return None
        return recorder.paths[0] if recorder.count else None

    def report(self) -> None:
        """Print which files were written, and which samples are not in them; nothing
        after a failure."""
        recorder = self._recorder
        if recorder is None or self.failed:
            return
        say(f"wrote {', '.join(map(str, recorder.paths))}")
        for name, count in recorder.left_out.items():
            if count:
                what = f"{count} samples of {name.replace('_', ' ')}"
                say(f"{what} are not in the record")

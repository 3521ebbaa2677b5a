"""The record of the samples that ``hefting live`` gets, where ``--record`` asks for
one."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli import render
from hefting.cli.parser import say
from hefting.core.errors import InputError

if TYPE_CHECKING:
    from hefting.online.samples import Samples


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

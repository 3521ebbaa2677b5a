"""Progress in a terminal: stage, share and time left of work of more than a second."""

import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import accumulate
from typing import TYPE_CHECKING

from hefting.core.progress import listening

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

PATIENCE = 1.0
"""[s] Time before progress is shown."""

STAGES = {
    "reading the log": 0.25,
    "smoothing the motion": 0.15,
    "finding sign, delay, bias and outliers": 0.1,
    "looking for changes of the object": 0.25,
    "looking for mistakes in the recording": 0.2,
    "identifying": 0.05,
}
"""Stages of reading and identifying, in order, and their typical share of the time."""


class Display:
    """One line on standard error, after `PATIENCE`, erased at the end. It shows `stage`
    until the first report. `stages` are the expected ones, in order, with their typical
    share of the time; of others it shows only the name."""

    def __init__(self, stage: str, stages: Mapping[str, float] = STAGES):
        total, begins = sum(stages.values()), accumulate(stages.values(), initial=0.0)
        self._parts = {
            name: (begin / total, length / total)
            for (name, length), begin in zip(stages.items(), begins, strict=False)
        }
        self._stage, self.share = stage, 0.0
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        self._is_closed, self._lock = False, threading.Lock()
        self._timer = threading.Timer(PATIENCE, self._appear)
        self._timer.daemon = True
        self._timer.start()

    def __call__(self, stage: str, share: float | None) -> None:
        """Show that a share of a stage is done; see `hefting.core.progress.Listener`."""
        begin, length = self._parts.get(stage, (0.0, 0.0))
        with self._lock:
            self._stage = stage
            self.share = max(self.share, begin + length * (share or 0.0))
            self._show()

    def close(self) -> None:
        """Erase it."""
        self._timer.cancel()
        with self._lock:
            self._is_closed = True
            if self._bar is not None:
                self._bar.stop()

    def _appear(self) -> None:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Progress,
            TaskProgressColumn,
            TextColumn,
            TimeRemainingColumn,
        )

        columns = (
            TextColumn("{task.description}"),
            BarColumn(20),
            TaskProgressColumn(),
            TimeRemainingColumn(compact=True),
            TextColumn("left"),
        )
        with self._lock:
            if self._is_closed:
                return
            console = Console(stderr=True)
            self._bar = Progress(*columns, console=console, transient=True)
            self._task = self._bar.add_task(self._stage, total=1.0)
            self._bar.start()
            self._show()

    def _show(self) -> None:
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, description=self._stage, completed=self.share)


@contextmanager
def progress(
    stage: str, quiet: bool = False, stages: Mapping[str, float] = STAGES
) -> Iterator[None]:
    """Show progress within the block, unless `quiet` or standard error is no terminal;
    `stages` as for `Display`."""
    if quiet or sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    display = Display(stage, stages)
    try:
        with listening(display):
            yield
    finally:
        display.close()

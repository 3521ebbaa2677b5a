"""Progress of a run: a bar an experiment on standard error."""

import sys
from typing import Self


class Bars:
    """Bars by name, updated by calling; nothing unless `shown` and standard error is a
    terminal."""

    def __init__(self, shown: bool):
        self.bars = None
        if shown and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import (
                BarColumn,
                MofNCompleteColumn,
                Progress,
                TextColumn,
                TimeRemainingColumn,
            )

            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
            )
            self.bars = Progress(*columns, console=Console(stderr=True))
        self.tasks: dict[str, int] = {}

    def __enter__(self) -> Self:
        if self.bars:
            self.bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.bars:
            self.bars.stop()

    def __call__(self, name: str, done: int, total: int) -> None:
        """Of the experiment called `name`, so many jobs of so many are done."""
        if self.bars:
            if name not in self.tasks:
                self.tasks[name] = self.bars.add_task(name, total=total)
            self.bars.update(self.tasks[name], completed=done)  # type: ignore[arg-type]

"""Jobs, and the understanding of live streams, in this process: for tests of what
becomes of results, not of processes. These have tests of their own in jobs/ and
online/."""

import pickle
from collections.abc import Callable, Generator, Iterator
from typing import Any

import pytest

from hefting.jobs.worker import Task
from hefting.online.process import Inline


class Here:
    """Does each task where it is asked for, as it would be sent to a process."""

    def __init__(self, size: int) -> None:
        self.size = size

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task and its result."""
        for task in tasks:
            yield task, self.run_alone(function, task)

    def run_alone(self, function: Callable[[Any], Any], task: Task) -> Any:
        """Result of a task."""
        sent, argument = pickle.loads(pickle.dumps((function, task.argument)))
        return pickle.loads(pickle.dumps(sent(argument)))

    def close(self) -> None:
        """There is nothing to end."""


def do_jobs_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """No processes are begun for jobs."""
    monkeypatch.setattr("hefting.jobs.Processes", Here)


class Understander(Inline):
    """In place of a process that has an end."""

    def close(self) -> None:
        """There is nothing to end."""


def understand_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """No process is begun to understand what a live stream has brought."""
    monkeypatch.setattr("hefting.online.identifier.Remote", Understander)

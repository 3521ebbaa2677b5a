"""What comes of a task, and who does it."""

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol


@dataclass(frozen=True)
class Lost:
    """In place of the result of a task that no worker survives."""

    reason: str
    """One line."""


@dataclass(frozen=True)
class Died:
    """The worker of a task died; whether by that task is not known."""

    how: str
    """What goes on after "its worker"."""


class Task(NamedTuple):
    """What a function is called with, numbered."""

    number: int
    argument: Any


class Workers(Protocol):
    """Processes that do tasks: local ones, or those of a cluster."""

    attempts: int
    """How often a task is begun alone before it is given up."""

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task, as it comes, and its result or `Died`."""
        ...

    def close(self) -> None:
        """End them, or leave them."""
        ...

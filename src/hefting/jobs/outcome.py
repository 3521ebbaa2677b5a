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

    reason: str
    """One line."""


class Task(NamedTuple):
    """What a function is called with, numbered."""

    number: int
    argument: Any


class Workers(Protocol):
    """Processes that do tasks: local ones, or those of a cluster."""

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task, as it comes, and its result or `Died`."""
        ...

    def run_alone(self, function: Callable[[Any], Any], task: Task) -> Any:
        """Result of a task while no other is done, so that no other is at fault; or
        `Died` when it has been tried often enough."""
        ...

    def close(self) -> None:
        """End them, or leave them."""
        ...

"""Progress of a long call, for a listener.

A part that may take more than a second reports its stage, and the share of it that is
done if known. Without a listener this does nothing; the command line has one.
"""

from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")

Listener = Callable[[str, float | None], None]
"""Called with the stage in words and the share of it done (0 to 1), None if unknown."""

_listener: ContextVar[Listener | None] = ContextVar("progress", default=None)


def report(stage: str, share: float | None = None) -> None:
    """Tell the listener, if there is one, a stage and the share of it that is done."""
    listener = _listener.get()
    if listener is not None:
        listener(stage, share)


def each(stage: str, items: Sequence[T]) -> Iterable[T]:
    """The items one by one, each reported as a part of the stage."""
    for k, item in enumerate(items):
        report(stage, k / len(items))
        yield item


@contextmanager
def listening(listener: Listener) -> Generator[None, None, None]:
    """Context in which reports go to `listener`."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)

"""Dashboard: what a kind of file is."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from hefting.dashboards.replay import Replay


@dataclass(frozen=True, eq=False, kw_only=True)
class Dashboard:
    """A kind of file that a dashboard shows."""

    name: str
    """Of the program that shows it."""
    suffixes: tuple[str, ...]
    """Endings of the file names, in small letters."""
    check: Callable[[], None]
    """Raises `MissingDependencyError` where what writes it is not installed."""
    write: Callable[[Replay, str | Path, Callable[[str], str]], tuple[str, ...]]
    """Writes a replay, whole or not at all, and returns the names of the streams that it
    does not hold; the last argument turns names of arguments in messages into the
    reader's."""

"""Dashboards: a recording and what was found from it in one file, for programs of
others to show.

    write_dashboard(replay_of(recording, estimate, shape), "out.mcap")

Each kind of file is a module of this package that ends in its `DASHBOARD`; here is
their list, and what is done with one.
"""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.progress import report
from hefting.dashboards.replay import Dashboard, Replay, replay_of

__all__ = ["Dashboard", "Replay", "dashboard_for", "replay_of", "write_dashboard"]

FILES = ("foxglove",)
"""The module of each kind of file."""
WRITING = "writing the file"
"""What is reported as progress while a file is written."""


def dashboard_for(path: str | Path) -> Dashboard:
    """The kind of file that is written to `path`, by its suffix; `InputError` where
    there is none."""
    known = [import_module(f"{__name__}.{file}").DASHBOARD for file in FILES]
    suffix = Path(path).suffix.lower()
    for each in known:
        if suffix in each.suffixes:
            return each
    suffixes = ", ".join(suffix for each in known for suffix in each.suffixes)
    raise InputError(
        f"'{suffix}' cannot hold an estimate beside a recording",
        path,
        f"use {suffixes}",
    )


def write_dashboard(
    replay: Replay, path: str | Path, say: Callable[[str], str] = str
) -> tuple[str, ...]:
    """Write a recording and what was found from it, whole or not at all.

    Parameters
    ----------
    replay : Replay
        Of `replay_of`.
    path : str or Path
        The file; its suffix says which kind.
    say : callable
        Turns names of arguments in backquotes, in messages, into the reader's.

    Returns
    -------
    tuple of str
        Names of the recording's streams that the file cannot hold.

    Raises
    ------
    InputError
        For another suffix, and where the file cannot be written.
    MissingDependencyError
        Where a library that writes the file is not installed.
    """
    kind = dashboard_for(path)
    kind.check()
    report(WRITING)
    return kind.write(replay, path, say)

"""The registry of log formats: the class of a format, and the list of all formats.

A new format is one module that ends in its `Format`, and the module's name in `MODULES`.
Reading, writing, and help and errors of the commands use that list.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hefting.core.recording import Recording
    from hefting.logs.layout import Layout
    from hefting.logs.table import Table

READING = "reading the log"
"""Name of the stage of progress while a log is read."""

MODULES = (
    "hefting.logs.csv_file",
    "hefting.logs.parquet_file",
    "hefting.logs.npz_file",
    "hefting.logs.matlab_file",
    "hefting.logs.json_lines",
    "hefting.logs.ur_csv",
    "hefting.logs.ros_bag",
)
"""Modules of the formats, in the order in which they are tried and named.

They are imported whenever a log is read or written and for the help of commands, so that
their functions import what is slow to import.
"""


@dataclass(frozen=True, eq=False, kw_only=True)
class Format:
    """A log format: the names of its files, and how they are read and written.

    Of the three ways to read, a format gives one: `open_table` for a file with named
    columns (column maps, headers of other formats and the canonical columns then work
    in it), `read_table` for particular columns in any such file, and `read` for
    everything else.
    """

    name: str
    """in messages: "CSV", "bag" """
    description: str
    """one line for the README"""
    suffixes: tuple[str, ...] = ()
    """endings of the file names that are read, in small letters"""
    help_names: tuple[str, ...] = ()
    """what the help of commands calls the logs that are read"""
    open_table: "Callable[[str | Path, Layout | None], Table] | None" = None
    """opens a file with named columns; the layout, which a column map may give, matters
    to text only"""
    in_blocks: bool = True
    """whether such a file is read block by block, so that one of any size can be cut
    into windows"""
    read_table: "Callable[[Table, bool], Recording] | None" = None
    """the recording in a table; the second argument says whether a log without a wrench
    is refused"""
    is_header: Callable[[Sequence[str]], bool] | None = None
    """whether column names are those that `read_table` reads"""
    read: "Callable[..., Recording] | None" = None
    """the recording at a path; takes also the keywords ``wrench_needed`` and those of
    `options`"""
    options: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    """keyword options of `read`: what the command's option takes, and its help"""
    recognise: Callable[[str | Path], bool] | None = None
    """whether a path is such a log; None: its suffix says"""
    folder: str = ""
    """what a folder is that holds such a log: "ROS 2 bag"; empty: only files"""
    written: tuple[str, ...] = ()
    """endings of the file names that are written; an empty one stands for a folder"""
    write: "Callable[[Recording, str | Path], tuple[str, ...]] | None" = None
    """writes a recording whole or not at all; returns the names of the streams that the
    format cannot hold"""

    @property
    def is_table(self) -> bool:
        """Whether its files have named columns."""
        return self.open_table is not None

    def matches(self, path: str | Path) -> bool:
        """Whether the log at `path`, which need not exist, is taken for this format."""
        return (
            self.recognise(path) if self.recognise else suffix_of(path) in self.suffixes
        )


def formats() -> tuple[Format, ...]:
    """All log formats."""
    return tuple(
        each
        for module in MODULES
        for each in vars(import_module(module)).values()
        if isinstance(each, Format)
    )


def table_formats() -> tuple[Format, ...]:
    """The formats whose files have named columns."""
    return tuple(each for each in formats() if each.is_table)


def find_format(path: str | Path) -> Format | None:
    """The format of the log at `path`, by its name or its folder; None for none."""
    return next((each for each in formats() if each.matches(path)), None)


def find_writer(path: str | Path) -> Format | None:
    """The format that is written to `path`, by its suffix; None when there is none."""
    return next((each for each in formats() if suffix_of(path) in each.written), None)


def all_options() -> dict[str, tuple[str, str]]:
    """Keyword options of all formats: what the command's option takes, and its help."""
    return {
        name: about
        for each in reversed(formats())
        for name, about in each.options.items()
    }


def suffix_of(path: str | Path) -> str:
    """The ending of a file name, in small letters; empty when there is none."""
    return Path(path).suffix.lower()


def join_words(words: Iterable[str], last: str) -> str:
    """Words in a line, the last two joined by the word `last`: "a, b or c"."""
    *others, end = words
    return f"{', '.join(others)} {last} {end}" if others else end

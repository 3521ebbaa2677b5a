"""JSON lines: one object a sample, nested as ROS messages are; see `MemoryTable`."""

import io
import json
from array import array
from collections.abc import Container
from dataclasses import replace
from itertools import chain
from math import inf, nan, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import warning
from hefting.logs.canonical import MAX_COLUMNS
from hefting.logs.csv_cells import NOTHING, seconds_of
from hefting.logs.csv_file import texts
from hefting.logs.layout import Layout
from hefting.logs.registry import Format
from hefting.logs.table import LONGEST_LIST, check_cells

if TYPE_CHECKING:
    from hefting.logs.memory_table import MemoryTable

ONE_A_LINE = "write one object a sample and line, as jq -c '.[]' does of a list"
DEEPEST = 20
"""Largest number of objects in one another that are looked into."""


def open_json_lines(path: str | Path, _layout: Layout | None = None) -> "MemoryTable":
    """The objects in the lines of the file at `path`; the layout is not used.

    ``{"pose": {"position": {"x": 1}}}`` has a column ``pose.position.x``, a list of
    numbers is an array, and lists beside a list ``name``, as of joints, have columns of
    these names. Objects beside a ``topic`` or ``channel`` begin with that. A key that
    is absent or null is blank; a last line that was cut is left out, with a warning.

    Raises `InputError` for a line that is no object, and for more than `MAX_COLUMNS`
    names or `MAX_CELLS` numbers.
    """
    from hefting.logs.memory_table import MemoryTable

    columns, cut = _Columns(path), None
    lines = chain.from_iterable(map(io.BytesIO, texts(path)))
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        if cut is not None:
            raise cut
        try:
            content = json.loads(line)
            if not isinstance(content, dict):
                raise ValueError("it is another value")
        except (ValueError, RecursionError) as error:
            what = f"is no JSON object ({str(error)[:80]})"
            cut = InputError(what, f"{path}, row {number}", ONE_A_LINE)
        else:
            columns.add(content)
    if cut is not None and columns.rows < 2:
        raise cut
    table = MemoryTable.of_arrays(str(path), columns.arrays())
    what = f"left out the last line, which {cut.what}" if cut else ""
    warnings = (warning("end-left-out", what),) if cut else ()
    return replace(table, first=1, warnings=warnings)


class _Columns:
    """Columns of numbers that grow by an object."""

    def __init__(self, path: str | Path):
        self._path, self.rows = path, 0
        self._numbers: dict[str, array[float]] = {}
        self._shapes: dict[str, tuple[int, ...]] = {}  # of lists
        self._others: set[str] = set()  # names that hold other things as well

    def add(self, content: dict[str, Any]) -> None:
        """Add a row."""
        topic = content.get("topic", content.get("channel"))
        self._add("", content, f"{topic}." if isinstance(topic, str) else "")
        self.rows += 1
        check_cells(self.rows * len(self._numbers), self._path)

    def arrays(self) -> dict[str, Any]:
        """Arrays (K,), or (K, n) and (K, m, n) of lists, with NaN for blanks; objects in place of
        what is not numbers alone."""
        held: dict[str, Any] = {n: self._filled(n) for n in self._numbers}
        for name, shape in self._shapes.items():
            parts = [held.pop(f"{name}_{j}") for j in range(prod(shape))]
            held[name] = np.stack(parts, axis=1).reshape(-1, *shape)
        blank = np.broadcast_to(np.full((), "", object), self.rows)
        return held | dict.fromkeys(self._others, blank)

    def _add(self, before: str, fields: dict[str, Any], topic: str = "") -> None:
        """Add fields whose names begin so, and objects in them with the topic."""
        if len(before) + len(topic) > 1000:
            what = "has a name of more than 1,000 characters"
            raise InputError(what, self._path, ONE_A_LINE)
        given: Any = fields.get("name")
        names = [str(n)[:99] for n in given] if isinstance(given, list) else []
        count = len(given) if isinstance(given, list) else None
        for key, value in fields.items():
            name = before + key
            if isinstance(value, dict) and name.count(".") < DEEPEST:
                self._add(f"{topic}{name}.", value)
            elif not isinstance(value, list):
                self._add_number(name, value)
            elif len(value) == count and key != "name":
                for one, number in zip(names, value, strict=True):
                    self._add_number(f"{before}{one}.{key}", number)
            else:
                self._add_list(name, value)

    def _add_list(self, name: str, value: list[Any]) -> None:
        """Add a list of numbers, in lists or not, whose shape does not change."""
        try:
            numbers = np.asarray(value, dtype=float)
        except (TypeError, ValueError, OverflowError):
            numbers = np.zeros(LONGEST_LIST + 1)
        if not numbers.size:
            return
        shape = self._shapes.get(name, numbers.shape)
        large = numbers.size > LONGEST_LIST or numbers.ndim > 2
        if numbers.shape != shape or large:
            self._know(name, self._others)
            self._others.add(name)
            return
        self._shapes[name] = shape
        for j, each in enumerate(numbers.flat):
            self._add_number(f"{name}_{j}", each)

    def _add_number(self, name: str, value: Any) -> None:
        """Add a number, or a date [s]; nothing for a blank."""
        if value is None or (isinstance(value, str) and value in ("", *NOTHING)):
            return
        try:
            number = float(value)
        except OverflowError:
            number = inf
        except (TypeError, ValueError):
            number = seconds_of(value) if isinstance(value, str) else None
        self._know(name, self._others if number is None else self._numbers)
        if number is None:
            self._others.add(name)
            return
        self._numbers.setdefault(name, array("d"))
        self._filled(name)[self.rows :] = array("d", [number])  # once a row

    def _know(self, name: str, names: Container[str]) -> None:
        """`InputError` for a name that is not among these, and is one too many."""
        known = len(self._numbers) + len(self._others)
        if name not in names and known >= MAX_COLUMNS:
            what = f"has more than {MAX_COLUMNS} names of numbers"
            raise InputError(what, self._path, ONE_A_LINE)

    def _filled(self, name: str) -> "array[float]":
        """A column with blanks up to the last row."""
        column = self._numbers[name]
        column.extend([nan] * (self.rows - len(column)))
        return column


FORMAT = Format(
    name="JSON lines",
    description="one JSON object a line and sample, nested as ROS messages are",
    suffixes=(".jsonl", ".ndjson"),
    help_names=(".jsonl",),
    open_table=open_json_lines,
    in_blocks=False,
)
"""Objects of numbers, lines of text."""

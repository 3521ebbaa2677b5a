"""Repair of a URDF: the nearest possible tensors replace those that no body can have, and
all other bytes are kept."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any

from hefting.core.errors import encodable
from hefting.core.files import read_xml, tag_end
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array
from hefting.robots.inertia_check import LinkCheck, check_links
from hefting.robots.inertials import ENTRIES, read_inertials

ATTRIBUTE = re.compile(rb"""([^\s=<>"'/]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
"""An attribute of a tag: name, and value in double or single quotes."""

SCHEMA = "hefting.check/1"

METRIC = "Frobenius norm of second moments about the COM"
"""Distance between tensors, as named in JSON."""

CONTEXT = 3
"""Unchanged lines around each change in a diff."""

NO_END = "\\ No newline at end of file"
"""Line of a diff after a last line without newline."""


@dataclass(frozen=True)
class Repaired:
    """A URDF before and after its repair."""

    source: str
    """Path of the file."""
    before: bytes
    """Its content."""
    after: bytes
    """Repaired content."""
    checks: list[LinkCheck]
    """All links, before the repair."""
    remaining: list[LinkCheck]
    """Links with a fault that no tensor repairs."""

    @property
    def failing(self) -> list[LinkCheck]:
        """Links with a fault before the repair."""
        return [checked for checked in self.checks if checked.fault]

    def to_dict(self) -> dict[str, Any]:
        """Values for JSON."""
        from hefting import __version__

        return {
            "schema": SCHEMA,
            "version": __version__,
            "file": encodable(self.source),
            "metric": METRIC,
            "links": [checked.to_dict() for checked in self.checks],
            "impossible": len(self.failing),
            "impossible_after_repair": len(self.remaining),
        }

    def diff(self, name: str | None = None) -> str:
        """The changes as a unified diff for `patch`, empty without changes. `name` is
        that of the repaired file, by default the same."""
        before, after = BytesIO(self.before), BytesIO(self.after)
        hunks = "".join(_hunks(before.readlines(), after.readlines()))
        head = f"--- {self.source}\n+++ {name or self.source}\n"
        return head + hunks if hunks else ""


def repair_inertias(path: str | Path) -> Repaired:
    """Repair a URDF in memory: the nearest possible tensor replaces that of each link
    with a fault.

    Mass, COM and every byte outside the numbers that change are kept. Links whose mass
    is not positive, or whose inertial cannot be read, are not repaired. Raises
    `InputError` as `check_inertias`.

    Examples
    --------
    >>> repaired = repair_inertias("robot.urdf")  # doctest: +SKIP
    >>> print(repaired.diff())  # doctest: +SKIP
    """
    before = read_xml(path)
    checks = check_links(read_inertials(before, path))
    after = _replaced(before, checks)
    remaining = [c for c in check_links(read_inertials(after, path)) if c.fault]
    return Repaired(str(path), before, after, checks, remaining)


def _replaced(data: bytes, checks: list[LinkCheck]) -> bytes:
    pieces, done = [], 0
    for checked in checks:
        if checked.nearest is None:
            continue
        inertial = checked.inertial
        for start, end, text in _edits(
            data, inertial.offset, inertial.inertia, checked.nearest
        ):
            pieces += [data[done:start], text]
            done = end
    return b"".join([*pieces, data[done:]])


def _edits(
    data: bytes, offset: int, old: Array, new: Array
) -> Iterator[tuple[int, int, bytes]]:
    """Start, end and new text of each number that changes in the tag at `offset`."""
    values = dict(zip(ENTRIES, new[TENSOR_ROWS, TENSOR_COLUMNS], strict=True))
    kept = dict(zip(ENTRIES, old[TENSOR_ROWS, TENSOR_COLUMNS], strict=True))
    for match in ATTRIBUTE.finditer(data, offset, tag_end(data, offset)):
        name = match[1].decode()
        if name not in values or values[name] == kept[name]:
            continue
        group = 2 if match[2] is not None else 3
        number = match[group].strip()
        start = match.start(group) + match[group].index(number)
        yield start, start + len(number), repr(float(values[name]) + 0.0).encode()


def _hunks(before: list[bytes], after: list[bytes]) -> Iterator[str]:
    """Hunks of a unified diff of two texts whose lines correspond one to one, so that no
    search for the fewest changes, of quadratic cost, is needed."""
    changed = [i for i, line in enumerate(before) if line != after[i]]
    while changed:
        count = 1
        while changed[count:] and changed[count] - changed[count - 1] <= 2 * CONTEXT:
            count += 1
        first = max(changed[0] - CONTEXT, 0)
        last = min(changed[count - 1] + CONTEXT + 1, len(before))
        yield f"@@ -{first + 1},{last - first} +{first + 1},{last - first} @@\n"
        yield from _hunk(before[first:last], after[first:last])
        changed = changed[count:]


def _hunk(before: list[bytes], after: list[bytes]) -> Iterator[str]:
    """Lines of a hunk: for each run of changed lines the old, then the new ones."""
    pairs = zip(before, after, strict=True)
    for is_same, run in groupby(pairs, lambda pair: pair[0] == pair[1]):
        old, new = zip(*run, strict=True)
        yield from (_line(" " if is_same else "-", line) for line in old)
        if not is_same:
            yield from (_line("+", line) for line in new)


def _line(mark: str, line: bytes) -> str:
    text = line.decode()
    return mark + (text if text[-1:] == "\n" else f"{text}\n{NO_END}\n")

"""A guessed column map as TOML, and what it says in one line."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hefting.core.errors import printable
from hefting.logs.map_sample import Sample

CHECK = "check each line against the manual of robot and sensor"


@dataclass(frozen=True)
class Guess:
    """A line of the map."""

    key: str
    columns: tuple[int, ...]
    rest: tuple[str, ...] = ()
    """more of its table: unit, form"""
    remark: str = ""
    """why, where numbers say it"""


def unit_entry(name: str) -> str:
    """What a line says of its unit."""
    return f"unit = {json.dumps(name)}"


def map_text(sample: Sample, guesses: Sequence[Guess], missing: Sequence[str]) -> str:
    """The map as TOML."""
    lines = [f"# guessed from {printable(Path(sample.source).name)}: {CHECK}"]
    for guess in guesses:
        names = [sample.toml_name(column) for column in guess.columns]
        one = f"column = {names[0]}"
        columns = one if guess.key == "time" else f"columns = [{', '.join(names)}]"
        line = f"{guess.key} = {{ {', '.join((columns, *guess.rest))} }}"
        lines.append(f"{line}  # {guess.remark}" if guess.remark else line)
    lines += [f"# not found; name its columns: {line}" for line in missing]
    lines += ['nan = "blank"'] if sample.has_nan else []
    used = {column for guess in guesses for column in guess.columns}
    others = [n for j, n in enumerate(sample.names) if n and j not in used]
    if others:
        lines.append(f"# not used: {printable(', '.join(others)[:400])}")
    return "\n".join(lines) + "\n"


def summary_of(sample: Sample, guess: Guess) -> str:
    """What is taken from which columns: "position X [mm] to Z [mm] (mm)"."""
    ends = dict.fromkeys((guess.columns[0], guess.columns[-1]))
    names = " to ".join(printable(sample.names[j] or f"number {j + 1}") for j in ends)
    told = [
        word for word in guess.rest if not word.startswith(("nanoseconds", "names"))
    ]
    how = ", ".join(re.findall(r'"([^"]*)"', " ".join(told)))
    remark = f"{', ' if how else ''}{guess.remark}" if guess.remark else ""
    return (
        f"{guess.key} from {names[:80]}{f' ({how}{remark})' if how or remark else ''}"
    )

"""A guessed column map as TOML, and what it says in one line; three angles that it names."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hefting.core.errors import printable
from hefting.logs.map_sample import OTHER, Groups, Sample, words_of
from hefting.logs.orientations import form_of_angles
from hefting.logs.units import find_unit

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


UNTOLD, RPY = "", 'form = "rpy"'
"""Forms of a map; the first is told by the numbers."""
ZYX = 'form = "euler", order = "ZYX"'

ANGLES = {
    ("roll", "pitch", "yaw"): (RPY, ""),
    ("rx", "ry", "rz"): (UNTOLD, ""),
    ("a", "b", "c"): (ZYX, "as of KUKA; other makes have other orders"),
    ("alpharad", "betarad", "gammarad"): (ZYX, ""),
    ("posxa", "posxb", "posxc"): ('form = "euler", order = "ZYZ"', ""),
    ("w", "p", "r"): (RPY, ""),
}
"""Names of three angles, what a map says of them, and a doubt; the last three are those
of KUKA's Sunrise, Doosan and Fanuc."""

ANOTHER_FORM = 'or "rpy", or "euler" with its order: the names do not tell'
ANOTHER_ORDER = 'or "euler" in another order'
"""What a map says of forms of angles that are guessed."""

KINDS = {
    "rotation-vector": ('form = "rotation-vector"', ""),
    "angles": (UNTOLD, ""),
    "roll-pitch-yaw": (RPY, ANOTHER_ORDER),
}
"""The same of three components x, y, z, by the kind of what stands before them."""


def angles_of(sample: Sample, groups: Groups) -> Guess | None:
    """Three angles by their names, or a rotation vector."""
    names: dict[str, int] = {}
    last: dict[str, int] = {}
    for column in reversed(range(len(sample.names))):
        words = words_of(sample.words(column))
        if words and not OTHER & set(words):
            names["".join(words)] = last[words[-1]] = column
            if sample.words(column).endswith("Rad"):
                last[f"{words[-1]}rad"] = column
    for angles, form in ANGLES.items():
        for where in (names, last):
            if set(angles) <= set(where) and (len(angles[0]) > 1 or where is names):
                return turned(sample, tuple(where[a] for a in angles), *form)
    for kind, form in KINDS.items():
        if (columns := groups.find(kind, "xyz")) is not None:
            return turned(sample, columns, *form)
    return None


def turned(
    sample: Sample, columns: tuple[int, ...], form: str, doubt: str = ""
) -> Guess:
    """Three angles. Those of an untold form are a rotation vector, as of UR, or roll,
    pitch and yaw, as of xArm, where that would jump."""
    unit, remark = sample.stated_or_by_size(columns, "angle")
    if form == UNTOLD:
        radians = find_unit(unit, "angle", sample.source).to_si(
            sample.values[:, list(columns)]
        )
        chosen, why = form_of_angles(radians)
        form = f'form = "{chosen}"'
        doubt = f"{why}; {ANOTHER_ORDER}" if why else ANOTHER_FORM
    remark = "; ".join(filter(None, (remark, doubt)))
    return Guess("orientation", columns, (form, unit_entry(unit)), remark)

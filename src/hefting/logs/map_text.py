"""A guessed column map as TOML, and what it says in one line; three angles that it names."""

import json
import re
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from pathlib import Path

from hefting.core.errors import printable
from hefting.logs.map_groups import (
    ASIDE,
    Choice,
    Groups,
    best_of,
    is_other,
    is_told,
    rank_of,
    words_of,
)
from hefting.logs.map_sample import UNKNOWN, Sample
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
    equals: tuple[int, ...] = ()
    """first columns of others that may be meant as well"""


def unit_entry(name: str) -> str:
    """What a line says of its unit."""
    return f"unit = {json.dumps(name)}"


def in_unit(
    key: str,
    kind: str,
    usual: str | None,
    sample: Sample,
    columns: tuple[int, ...],
) -> Guess:
    """A quantity in the unit of a kind that the header states, or in the usual one."""
    said = sample.said_unit(columns, kind)
    remark = "" if said or usual is None else sample.unknown_unit(columns)
    unit = said or usual
    return Guess(key, columns, (unit_entry(unit),) if unit else (), remark)


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
    names = [printable(sample.names[j] or f"number {j + 1}")[-60:] for j in ends]
    told = [
        word for word in guess.rest if not word.startswith(("nanoseconds", "names"))
    ]
    how = ", ".join(re.findall(r'"([^"]*)"', " ".join(told)))
    remark = f"{', ' if how else ''}{guess.remark}" if guess.remark else ""
    return (
        f"{guess.key} from {' to '.join(names)}"
        f"{f' ({how}{remark})' if how or remark else ''}"
    )


def doubts_of(sample: Sample, guesses: Sequence[Guess]) -> Iterator[str]:
    """What of the map may be another column, or in another unit."""
    for guess in guesses:
        names = [printable(sample.names[j])[-60:] for j in guess.equals[:3]]
        if names:
            first = printable(sample.names[guess.columns[0]])[-60:]
            what = f"the {guess.key} may begin with {first} or with"
            yield f"{what} {' or '.join(names)}, and the first is taken"
        if UNKNOWN in guess.remark:
            yield f"of the {guess.key} {guess.remark}"


UNTOLD, RPY = "", 'form = "rpy"'
"""Forms of a map; the first is told by the numbers."""
ZYZ = 'form = "euler", order = "ZYZ"'
ZYX = 'form = "euler", order = "ZYX"'

ANGLES = {
    ("roll", "pitch", "yaw"): (RPY, ""),
    ("rx", "ry", "rz"): (UNTOLD, ""),
    ("a", "b", "c"): (ZYX, "as of KUKA; other makes have other orders"),
    ("alpharad", "betarad", "gammarad"): (ZYX, ""),
    ("w", "p", "r"): (RPY, ""),
    ("o", "a", "t"): (ZYZ, ""),
    ("phi", "theta", "psi"): (RPY, 'or "euler" in another order'),
}
"""Names of three angles, what a map says of them, and a doubt; those with ``rad`` are of
KUKA's Sunrise, the next of Fanuc and Kawasaki. ``U V W`` may be z y x (Epson), or x y z."""

ANOTHER_FORM = 'or "rpy", or "euler" with its order: the names do not tell'
ANOTHER_ORDER = 'or "euler" in another order'
"""What a map says of forms of angles that are guessed."""

KINDS = {
    "rotation-vector": ('form = "rotation-vector"', ""),
    "angles": (UNTOLD, ""),
    "roll-pitch-yaw": (RPY, ANOTHER_ORDER),
}
"""The same of three components x, y, z, by the kind of what stands before them."""


def angles_of(
    sample: Sample, groups: Groups, near: Set[str]
) -> tuple[Choice, Guess] | None:
    """Three angles by their names, or a rotation vector, and which columns they are."""
    for angles, (form, doubt) in ANGLES.items():
        if (choice := _named_angles(sample, angles, near)) is not None:
            form = ZYZ if "posx" in choice.words else form
            doubt = "" if form == ZYZ else doubt
            return choice, turned(sample, choice.columns, form, doubt, choice.equals)
    for kind, (form, doubt) in KINDS.items():
        choice = groups.find(kind, "xyz", near) or groups.numbered(kind, 3, near)
        if choice is not None and not sample.said_unit(choice.columns, "length"):
            return choice, turned(sample, choice.columns, form, doubt, choice.equals)
    return None


def _named_angles(
    sample: Sample, angles: Sequence[str], near: Set[str]
) -> Choice | None:
    """Columns that end in the names of three angles; those of single letters have
    nothing before them, or what a position has."""
    found: dict[tuple[bool, tuple[str, ...]], dict[str, int]] = {}
    for column in range(len(sample.names)):
        name = sample.words(column)
        words = words_of(name)
        behind = [word for word in words if word in ASIDE]
        words = [word for word in words if word not in ASIDE]
        before = (*behind, *words[:-1])
        if words and not is_other((*behind, *words)) and not is_told(before, "force"):
            last = words[-1] + "rad" * name.endswith("Rad")
            case = name[-1:].isupper()  # beside ``O A T``, ``t`` is the time
            found.setdefault((case, before), {}).setdefault(last, column)
    return best_of(
        [
            Choice(tuple(columns[a] for a in angles), before, rank_of(before, near))
            for (_, before), columns in found.items()
            if set(angles) <= set(columns)
            and (len(angles[0]) > 1 or not before or is_told(before, "position"))
        ]
    )


def turned(
    sample: Sample,
    columns: tuple[int, ...],
    form: str,
    doubt: str = "",
    equals: tuple[int, ...] = (),
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
    rest = (form, unit_entry(unit))
    return Guess("orientation", columns, rest, remark, equals)

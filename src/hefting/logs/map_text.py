"""A guessed column map as TOML, and its summary and doubts; guesses of three angles."""

import json
import re
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.core.errors import printable
from hefting.logs.map_groups import (
    ASIDE,
    Choice,
    Groups,
    best_of,
    group_columns,
    is_of_kind,
    is_other,
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
    """other entries of its table: unit, form"""
    remark: str = ""
    """reason, where numbers decided, or doubt"""
    equals: tuple[int, ...] = ()
    """first columns of other groups that may be right as well"""


def unit_entry(name: str) -> str:
    """The entry of a unit."""
    return f"unit = {json.dumps(name)}"


def in_unit(
    key: str, kind: str, usual: str | None, sample: Sample, columns: tuple[int, ...]
) -> Guess:
    """A quantity in the unit that the header states, if it is of a kind, or in the usual
    one; None: no unit."""
    stated = sample.stated_unit(columns, kind)
    remark = "" if stated or usual is None else sample.unknown_unit(columns)
    unit = stated or usual
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
    """A quantity and its columns: "position from X [mm] to Z [mm] (mm)"."""
    ends = dict.fromkeys((guess.columns[0], guess.columns[-1]))
    names = [printable(sample.names[j] or f"number {j + 1}")[-60:] for j in ends]
    entries = [
        entry for entry in guess.rest if not entry.startswith(("nanoseconds", "names"))
    ]
    how = ", ".join(re.findall(r'"([^"]*)"', " ".join(entries)))
    remark = f"{', ' if how else ''}{guess.remark}" if guess.remark else ""
    return (
        f"{guess.key} from {' to '.join(names)}"
        f"{f' ({how}{remark})' if how or remark else ''}"
    )


def doubts_of(sample: Sample, guesses: Sequence[Guess]) -> Iterator[str]:
    """Quantities that may be in other columns, or in another unit, one sentence each."""
    used = {column for guess in guesses for column in guess.columns}
    for guess in guesses:
        equals = [j for j in guess.equals if j not in used]
        names = [printable(sample.names[j])[-60:] for j in equals[:3]]
        if names:
            first = printable(sample.names[guess.columns[0]])[-60:]
            what = f"the {guess.key} may begin with {first} or with"
            yield f"{what} {' or '.join(names)}, and the first is taken"
        if UNKNOWN in guess.remark:
            yield f"of the {guess.key} {guess.remark}"


def unread_of(sample: Sample, guesses: Sequence[Guess]) -> str:
    """A sentence on columns that may be the position; else empty."""
    if not (places := unread_positions(sample, guesses)):
        return ""
    names = [printable(sample.names[j])[-60:] for j in places[0].columns]
    entry = ", ".join(sample.toml_name(j) for j in places[0].columns)
    return (
        f"no position was found, and {', '.join(names)} are not read: if they "
        f"are the position, add position = {{ columns = [{entry}] }}"
    )


def unread_positions(sample: Sample, guesses: Sequence[Guess]) -> list[Choice]:
    """Where an orientation was found and no position, columns x, y, z that are not in the
    map, change, and are not of another quantity."""
    keys = {guess.key for guess in guesses}
    if "orientation" not in keys or "position" in keys:
        return []
    used = {column for guess in guesses for column in guess.columns}
    groups = group_columns([sample.words(j) for j in range(len(sample.names))])
    found = []
    for words, columns in groups.by_words.items():
        if not set("xyz") <= set(columns) or "w" in columns or _is_no_place(words):
            continue
        chosen = tuple(columns[c] for c in "xyz")
        values = sample.values[:, chosen]
        values = values[np.isfinite(values).all(axis=1)]
        if not used & set(chosen) and len(values) and np.ptp(values, axis=0).any():
            found.append(Choice(chosen, words, rank_of(words, set())))
    return found


def _is_no_place(words: Sequence[str]) -> bool:
    """Whether the words before x, y, z name another quantity, or another place."""
    return (
        is_other(words)
        or bool(NO_PLACE & {*words})
        or any(is_of_kind(words, kind) for kind in NO_POSITIONS)
        or (rank_of(words, set()) < 0 and "base" not in words)
    )


NO_PLACE = {
    *("v", "w", "a", "omega", "alpha", "angular", "mag", "magnetometer", "imu"),
    *("com", "cog", "joint", "voltage", "gauge", "temp", "temperature"),
}
"""Words of quantities that are no positions and have no kind of their own."""

NO_POSITIONS = (
    *("force", "torque", "orientation", "angles", "rotation-vector"),
    *("roll-pitch-yaw", "gyroscope", "linear_accelerometer", "accelerometer"),
)
"""Kinds of columns x, y, z that are no positions."""

BY_NUMBERS, RPY = "", 'form = "rpy"'
"""Entries of a form; the first stands for the form that the numbers show."""
ZYZ = 'form = "euler", order = "ZYZ"'
ZYX = 'form = "euler", order = "ZYX"'

ANGLES = {
    ("roll", "pitch", "yaw"): (RPY, ""),
    ("rx", "ry", "rz"): (BY_NUMBERS, ""),
    ("a", "b", "c"): (ZYX, "as of KUKA; other makes have other orders"),
    ("alpharad", "betarad", "gammarad"): (ZYX, ""),
    ("w", "p", "r"): (RPY, ""),
    ("o", "a", "t"): (ZYZ, ""),
    ("phi", "theta", "psi"): (RPY, 'or "euler" in another order'),
}
"""Entry of the form, and a doubt, by the names of three angles; those with ``rad`` are of
KUKA's Sunrise, the next two of Fanuc and Kawasaki. ``U V W``, which may be z y x (Epson)
or x y z, is not here."""

ANOTHER_FORM = 'or "rpy", or "euler" with its order: the names do not tell'
ANOTHER_ORDER = 'or "euler" in another order'
"""Doubts about guessed forms of angles."""

KINDS = {
    "rotation-vector": ('form = "rotation-vector"', ""),
    "angles": (BY_NUMBERS, ""),
    "roll-pitch-yaw": (RPY, ANOTHER_ORDER),
}
"""The same for components x, y, z, by the kind of the words before them."""


def angles_of(
    sample: Sample, groups: Groups, near: Set[str]
) -> tuple[Choice, Guess] | None:
    """The columns of three angles or a rotation vector by their names, and the guess."""
    for angles, (form, doubt) in ANGLES.items():
        if (choice := _named_angles(sample, angles, near)) is not None:
            form = ZYZ if "posx" in choice.words else form
            doubt = "" if form == ZYZ else doubt
            guess = angles_guess(sample, choice.columns, form, doubt, choice.equals)
            return choice, guess
    for kind, (form, doubt) in KINDS.items():
        choice = groups.find(kind, "xyz", near) or groups.numbered(kind, 3, near)
        if choice is not None and not sample.stated_unit(choice.columns, "length"):
            guess = angles_guess(sample, choice.columns, form, doubt, choice.equals)
            return choice, guess
    return None


def _named_angles(
    sample: Sample, angles: Sequence[str], near: Set[str]
) -> Choice | None:
    """Columns whose names end in those of three angles; before single letters there may
    only be words of a position."""
    found: dict[tuple[bool, tuple[str, ...]], dict[str, int]] = {}
    for column in range(len(sample.names)):
        name = sample.words(column)
        words = words_of(name)
        behind = [word for word in words if word in ASIDE]
        words = [word for word in words if word not in ASIDE]
        before = (*behind, *(word for word in words[:-1] if word != "winkel"))
        if (
            words
            and not is_other((*behind, *words))
            and not is_of_kind(before, "force")
        ):
            last = words[-1] + "rad" * name.endswith("Rad")
            case = name[-1:].isupper()  # beside ``O A T``, ``t`` is the time
            found.setdefault((case, before), {}).setdefault(last, column)
    return best_of(
        [
            Choice(tuple(columns[a] for a in angles), before, rank_of(before, near))
            for (_, before), columns in found.items()
            if set(angles) <= set(columns)
            and (len(angles[0]) > 1 or not before or is_of_kind(before, "position"))
        ]
    )


def angles_guess(
    sample: Sample,
    columns: tuple[int, ...],
    form: str,
    doubt: str,
    equals: tuple[int, ...],
) -> Guess:
    """The guess of three angles. For `BY_NUMBERS` the form is that of
    `form_of_angles`."""
    unit, remark = sample.stated_or_by_size(columns, "angle")
    if form == BY_NUMBERS:
        angle = find_unit(unit, "angle", sample.source)
        radians = angle.to_si(sample.values[:, list(columns)])
        chosen, why = form_of_angles(radians, in_degrees=angle.name == "deg")
        form = f'form = "{chosen}"'
        doubt = f"{why}; {ANOTHER_ORDER}" if why else ANOTHER_FORM
    remark = "; ".join(filter(None, (remark, doubt)))
    rest = (form, unit_entry(unit))
    return Guess("orientation", columns, rest, remark, equals)

"""A column map guessed from the names and numbers of a table, for a person to check.

A column is told by the words in its name (``/ft/wrench/force/x``, ``Fx [N]``,
``actual_TCP_pose_3``) and its component, x, y, z, w or a number; a unit by what the
header says, else by the size of the numbers.
"""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError, printable
from hefting.logs.map_sample import Sample, read_sample
from hefting.logs.units import UNITS, find_unit

WORDS = {
    "force": ("f", "force", "forces"),
    "torque": ("t", "m", "torque", "torques", "moment", "moments", "tau", "mom"),
    "wrench": ("ft", "fts", "wrench", "ftsensor"),
    "position": ("", "p", "pos", "position", "translation", "trans", "xyz"),
    "orientation": ("q", "quat", "quaternion", "orientation", "ori", "rot", "rotation"),
    "rotation-vector": ("r", "rotvec", "rv", "axisangle"),
    "pose": ("pose", "tcppose"),
    "pose-matrix": ("ee", "pose", "matrix", "transform", "tf"),
    "joint_positions": ("q", "j", "joint", "joints", "jointposition", "jpos"),
    "gyroscope": ("g", "gyro", "gyroscope"),
    "linear_accelerometer": ("linearacc", "linearaccel", "linearaccelerometer"),
    "accelerometer": ("acc", "accel", "accelerometer"),
}
"""Words that a column of each kind may have before its component."""

TIMES = ("t", "time", "timestamp", "stamp", "ts", "clock", "sec", "secs", "seconds")
"""Names of the time, without its unit."""

OTHER = {"velocity", "vel", "speed", "acceleration", "current", "effort", "target"}
"""Words of columns that are none of those."""

ANGLES = {
    ("roll", "pitch", "yaw"): 'form = "rpy"',
    ("rx", "ry", "rz"): 'form = "rotation-vector"',
    ("a", "b", "c"): 'form = "euler", order = "ZYX"',
}
"""Names of three angles, and what a map says of them."""

LARGEST_METRES, LARGEST_RADIANS, LARGEST_LEVER = 10.0, 6.5, 5.0
"""Sizes of positions [m], angles [rad] and torque over force [m] above which they are
taken for millimetres, degrees and newton-millimetres."""
UNIT_NORM = 0.02
"""Deviation of a quaternion's norm from one."""

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


@dataclass(frozen=True)
class GuessedMap:
    """What `guess_map` found."""

    text: str
    """the column map, TOML"""
    missing: tuple[str, ...]
    """what a recording needs and no column seems to be"""


def guess_map(path: str | Path) -> GuessedMap:
    """A column map of the table at `path`, as far as names and numbers tell.

    Raises `InputError` where the table cannot be read, and where no column is known.
    """
    sample = read_sample(path)
    guesses = _guesses(sample)
    keys = {guess.key for guess in guesses}
    if not keys - {"time"}:
        raise InputError(
            "no column has a name that says what it holds",
            path,
            "write the map by hand, with the numbers of the columns",
        )
    missing = []
    if not keys & {"wrench", "force"}:
        missing.append('wrench = { columns = ["fx", "fy", "fz", "tx", "ty", "tz"] }')
    if not keys & {"orientation", "pose", "joint_positions"}:
        missing.append('orientation = { columns = ["qx", "qy", "qz", "qw"] }')
    return GuessedMap(_text(sample, guesses, missing), tuple(missing))


def _guesses(sample: Sample) -> list[Guess]:
    """All that is recognised, without what two guesses would claim."""
    groups = _groups(sample)
    makers: Sequence[Callable[[Sample, Groups], Guess | list[Guess] | None]] = (
        _time,
        _wrench,
        _poses,
        _angles,
        _quaternion,
        _position,
        _joints,
        _inertial,
    )
    found: list[Guess] = []
    taken: set[int] = set()
    keys: set[str] = set()
    for make in makers:
        made = make(sample, groups) or []
        for guess in made if isinstance(made, list) else [made]:
            if guess.key not in keys and not taken & set(guess.columns):
                found.append(guess)
                taken |= set(guess.columns)
                keys.add(guess.key)
    return found


@dataclass(frozen=True)
class Groups:
    """Columns by what stands before their component: ``("ft", "force")`` -> ``{"x":
    3}``."""

    by_words: Mapping[tuple[str, ...], Mapping[str, int]]

    def find(self, kind: str, components: Sequence[str]) -> tuple[int, ...] | None:
        """Columns of the first group of a kind that has all these components."""
        for words, columns in self.by_words.items():
            last = words[-1] if words else ""
            told = last in WORDS[kind] or "".join(words[-2:]) in WORDS[kind]
            told = told and (kind != "accelerometer" or "linear" not in words)
            if told and not OTHER & set(words) and set(components) <= set(columns):
                return tuple(columns[c] for c in components)
        return None

    def numbered(self, kind: str, count: int) -> tuple[int, ...] | None:
        """The same for components that are numbers, from 0 or from 1."""
        for first in (0, 1):
            names = [str(first + k) for k in range(count)]
            if (columns := self.find(kind, names)) is not None:
                return columns
        return None


def _groups(sample: Sample) -> Groups:
    groups: dict[tuple[str, ...], dict[str, int]] = {}
    for column in range(len(sample.names)):
        words = _split(sample.words(column))
        if words:
            groups.setdefault(tuple(words[:-1]), {}).setdefault(words[-1], column)
    return Groups(groups)


def _split(name: str) -> list[str]:
    """Words of a name in small letters, its component as the last: ``Force_X`` and
    ``forceX`` are ``force``, ``x``."""
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name)
    words = [word for word in re.split(r"[^a-z0-9]+", name.lower()) if word]
    if not words:
        return []
    if len(words) > 1 and words[0] in "xyzw" and words[-1] not in "xyzw":
        return [*words[1:], words[0]]
    match = re.fullmatch(r"(.*?[a-z])([xyzw]|\d+)|([xyzw])", words[-1])
    if match and match[1] and not words[-1].isdigit():
        return [*words[:-1], match[1], match[2]]
    return words


def _time(sample: Sample, groups: Groups) -> Guess | None:
    for column in range(len(sample.names)):
        words = re.split(r"[^a-z0-9]+", sample.words(column).lower())
        bare = [word for word in words if word and word not in UNITS["time"]]
        if not bare or bare[-1] in TIMES[1:] or bare == ["t"]:
            said = sample.units[column] or next(
                (word for word in words if word in UNITS["time"]), ""
            )
            unit, remark = _time_unit(sample.values[:, column], said)
            return Guess("time", (column,), (_unit(unit),), remark)
    return None


def _time_unit(values: np.ndarray, said: str) -> tuple[str, str]:
    """Unit of the time, by its name or its steps, and why."""
    if said in UNITS["time"]:
        return said, ""
    steps = np.diff(values[np.isfinite(values)])
    step = float(np.median(np.abs(steps))) if len(steps) else 0.0
    for unit, least in (("ns", 1e5), ("us", 1e2), ("ms", 1.0)):
        if step >= least:
            return unit, f"by its steps of {step:.4g}"
    return "s", ""


def _wrench(sample: Sample, groups: Groups) -> list[Guess] | None:
    six = groups.numbered("wrench", 6) or groups.numbered("force", 6)
    force, torque = (groups.find(kind, "xyz") for kind in ("force", "torque"))
    if six is not None:
        force, torque = six[:3], six[3:]
    if force is None or torque is None:
        return None
    units, remark = _wrench_units(sample, force, torque)
    return [Guess("wrench", (*force, *torque), (units,), remark)]


def _wrench_units(
    sample: Sample, force: tuple[int, ...], torque: tuple[int, ...]
) -> tuple[str, str]:
    one = _said(sample, force, "force")
    two = _said(sample, torque, "torque")
    remark = ""
    if two is None:
        f, t = (_size(sample, columns) for columns in (force, torque))
        two = "N m"
        if f > 0.0 and t / f > LARGEST_LEVER:
            two, remark = "N mm", f"by its size: {t / f:.3g} times the force"
    return f"unit = {json.dumps([one or 'N', two])}", remark


def _poses(sample: Sample, groups: Groups) -> list[Guess] | None:
    """Poses in one numbered group: a matrix, or a position with what turns it."""
    if (matrix := groups.numbered("pose-matrix", 16)) is not None:
        rows = np.abs(sample.values[:, list(matrix[12:15])]) < 1e-6
        form = "matrix4" if rows.all() else "matrix4-columns"
        return [Guess("pose", matrix, (f'form = "{form}"',))]
    if (seven := groups.numbered("pose", 7)) is not None:
        return [_length("position", sample, seven[:3]), _four(sample, seven[3:])]
    if (six := groups.numbered("pose", 6)) is not None:
        turned = _turned(sample, six[3:], 'form = "rotation-vector"')
        return [_length("position", sample, six[:3]), turned]
    return None


def _angles(sample: Sample, groups: Groups) -> Guess | None:
    """Three angles by their names, or a rotation vector."""
    names = {sample.words(j).lower(): j for j in reversed(range(len(sample.names)))}
    last = {re.split(r"[^a-z0-9]+", name)[-1]: j for name, j in names.items()}
    for angles, form in ANGLES.items():
        for where in (names, last):
            if set(angles) <= set(where) and (len(angles[0]) > 1 or where is names):
                return _turned(sample, tuple(where[a] for a in angles), form)
    vector = groups.find("rotation-vector", "xyz")
    if vector is None:
        return None
    return _turned(sample, vector, 'form = "rotation-vector"')


def _quaternion(sample: Sample, groups: Groups) -> Guess | None:
    named = groups.find("orientation", "xyzw")
    if named is not None:
        return Guess("orientation", named)
    numbered = groups.numbered("orientation", 4)
    if numbered is None or not _has_unit_norm(sample, numbered):
        return None
    return _four(sample, numbered)


def _four(sample: Sample, columns: tuple[int, ...]) -> Guess:
    """A quaternion whose columns are numbers."""
    remark = "or wxyz: their numbers do not tell which is w"
    return Guess("orientation", columns, ('form = "xyzw"',), remark)


def _has_unit_norm(sample: Sample, columns: tuple[int, ...]) -> bool:
    norms = np.linalg.norm(sample.values[:, list(columns)], axis=1)
    known = norms[np.isfinite(norms)]
    return len(known) > 0 and bool((np.abs(known - 1.0) < UNIT_NORM).all())


def _position(sample: Sample, groups: Groups) -> Guess | None:
    columns = groups.find("position", "xyz")
    return None if columns is None else _length("position", sample, columns)


def _joints(sample: Sample, groups: Groups) -> Guess | None:
    for count in range(9, 3, -1):
        columns = groups.numbered("joint_positions", count)
        if columns is not None and not (count == 4 and _has_unit_norm(sample, columns)):
            unit, remark = _angle_unit(sample, columns)
            return Guess("joint_positions", columns, (_unit(unit),), remark)
    return None


def _inertial(sample: Sample, groups: Groups) -> list[Guess] | None:
    found = []
    for key, kind in (
        ("gyroscope", "angular speed"),
        ("linear_accelerometer", "acceleration"),
        ("accelerometer", "acceleration"),
    ):
        columns = groups.find(key, "xyz")
        if columns is not None:
            said = _said(sample, columns, kind)
            found.append(Guess(key, columns, (_unit(said),) if said else ()))
    return found


def _length(key: str, sample: Sample, columns: tuple[int, ...]) -> Guess:
    said, size = _said(sample, columns, "length"), _size(sample, columns)
    if said is None and size > LARGEST_METRES:
        return Guess(key, columns, (_unit("mm"),), f"by its size, up to {size:.4g}")
    return Guess(key, columns, (_unit(said or "m"),))


def _turned(sample: Sample, columns: tuple[int, ...], form: str) -> Guess:
    unit, remark = _angle_unit(sample, columns)
    return Guess("orientation", columns, (form, _unit(unit)), remark)


def _angle_unit(sample: Sample, columns: tuple[int, ...]) -> tuple[str, str]:
    said, size = _said(sample, columns, "angle"), _size(sample, columns)
    if said is None and size > LARGEST_RADIANS:
        return "deg", f"by its size, up to {size:.4g}"
    return said or "rad", ""


def _said(sample: Sample, columns: Sequence[int], kind: str) -> str | None:
    """The unit that the header says of the columns, if it is one of a kind."""
    try:
        return find_unit(sample.units[columns[0]], kind, sample.source).name
    except InputError:
        pass
    words = re.split(r"[^A-Za-z0-9]+", sample.names[columns[0]])
    return next(
        (word for word in words[1:] if word in UNITS[kind] and word != "m"), None
    )


def _size(sample: Sample, columns: Sequence[int]) -> float:
    """Largest absolute value, spikes aside; 0 where there is none."""
    values = np.abs(sample.values[:, list(columns)])
    values = values[np.isfinite(values)]
    return float(np.quantile(values, 0.99)) if len(values) else 0.0


def _unit(name: str) -> str:
    return f"unit = {json.dumps(name)}"


def _text(sample: Sample, guesses: Sequence[Guess], missing: Sequence[str]) -> str:
    """The map as TOML."""
    lines = [f"# guessed from {printable(Path(sample.source).name)}: {CHECK}"]
    for guess in guesses:
        names = [_name(sample, column) for column in guess.columns]
        one = f"column = {names[0]}"
        columns = one if guess.key == "time" else f"columns = [{', '.join(names)}]"
        line = f"{guess.key} = {{ {', '.join((columns, *guess.rest))} }}"
        lines.append(f"{line}  # {guess.remark}" if guess.remark else line)
    lines += [f"# not found; name its columns: {line}" for line in missing]
    lines += sample.layout
    used = {column for guess in guesses for column in guess.columns}
    others = [n for j, n in enumerate(sample.names) if n and j not in used]
    if others:
        lines.append(f"# not used: {printable(', '.join(others)[:400])}")
    return "\n".join(lines) + "\n"


def _name(sample: Sample, column: int) -> str:
    """A column as TOML names it: by its number where its name is not its own."""
    name = sample.names[column]
    if sample.names.count(name) > 1 or "{" in name or not name.isprintable():
        return str(column + 1)
    return json.dumps(name)

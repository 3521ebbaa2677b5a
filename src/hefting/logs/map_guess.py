"""A column map guessed from the names and numbers of a table, for a person to check.

A column is told by the words in its name (``/ft/wrench/force/x``, ``Fx [N]``,
``actual_TCP_pose_3``) and its component, x, y, z, w or a number; a unit by what the
header says, else by the size of the numbers.
"""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.logs.map_sample import (
    OTHER,
    Groups,
    Sample,
    group_columns,
    read_sample,
    words_of,
)
from hefting.logs.map_text import (
    UNTOLD,
    Guess,
    angles_of,
    map_text,
    summary_of,
    turned,
    unit_entry,
)
from hefting.logs.table import SINCE_1970
from hefting.logs.units import UNITS

TIMES = (
    *("t", "time", "timestamp", "stamp", "ts", "clock", "sec", "secs", "seconds"),
    *("robtime", "robottime", "systime", "zeit", "zeitstempel", "datetime"),
)
"""Names of the time, without its unit."""

TIME_EXAMPLE = (
    'time = { column = "time", unit = "s" }, or { rate = 250 } of rows at 250 Hz'
)
ORIENTATION_EXAMPLE = (
    'orientation = { columns = ["qx", "qy", "qz", "qw"] }, or { columns = '
    '["rx", "ry", "rz"], form = "euler", order = "ZYX", unit = "deg" }'
)
"""What a map says of times and orientations that no column seems to be."""

PANDAS_INDEX = "__index_level_0__"
"""What pandas calls an index without a name in a Parquet file; of rows that were picked
it holds whole numbers, as a count does."""

NANOSECONDS = ("nsec", "nsecs", "nanosec", "nanosecs", "nanosecond", "nanoseconds")
"""Names of what counts on top of the seconds of a stamp."""

LARGEST_LEVER = 5.0
"""Torque over force [m] above which it is taken for newton-millimetres."""
UNIT_NORM = 0.02
"""Deviation of a quaternion's norm from one."""

FEWEST_JOINTS = 4
"""Fewest columns that are taken for the joints of an arm."""


@dataclass(frozen=True)
class GuessedMap:
    """What `guess_map` found."""

    text: str
    """the column map, TOML"""
    missing: tuple[str, ...]
    """what a recording needs and no column seems to be"""
    columns: frozenset[str]
    """names of those that the map takes"""
    summary: str
    """what is taken from which columns, in one line"""


def guess_map(path: str | Path) -> GuessedMap:
    """A column map of the table at `path`, as far as names and numbers tell.

    Raises `InputError` where the table cannot be read, and where no column is known.
    """
    return guess_map_of(read_sample(path))


def guess_map_of(sample: Sample) -> GuessedMap:
    """A column map of the table that begins with `sample`; `InputError` where no column
    is known."""
    guesses = _guesses(sample)
    keys = frozenset(guess.key for guess in guesses)
    if not keys - {"time"}:
        raise InputError(
            "no column has a name that says what it holds",
            sample.source,
            "write the map by hand, with the numbers of the columns",
        )
    missing = [] if "time" in keys else [TIME_EXAMPLE]
    if not keys & {"wrench", "force"}:
        missing.append('wrench = { columns = ["fx", "fy", "fz", "tx", "ty", "tz"] }')
    if not keys & {"orientation", "pose", "joint_positions"}:
        missing.append(ORIENTATION_EXAMPLE)
    summary = "; ".join(summary_of(sample, guess) for guess in guesses)
    columns = frozenset(sample.names[j] for guess in guesses for j in guess.columns)
    text = map_text(sample, guesses, missing)
    return GuessedMap(text, tuple(missing), columns, summary)


def _guesses(sample: Sample) -> list[Guess]:
    """All that is recognised, without what two guesses would claim."""
    groups = group_columns([sample.words(j) for j in range(len(sample.names))])
    makers: Sequence[Callable[[Sample, Groups], Guess | list[Guess] | None]] = (
        _time,
        _wrench,
        _poses,
        angles_of,
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


def names_time(text: str) -> bool:
    """Whether a name is one of the time, its unit aside."""
    words = re.findall(r"[a-z0-9]+", text.lower())
    bare = [word for word in words if word not in UNITS["time"]]
    return bool(words) and (not bare or bare[-1] in TIMES[1:] or bare == ["t"])


def _time(sample: Sample, groups: Groups) -> Guess | None:
    for column in range(len(sample.names)):
        text = sample.words(column).lower()
        words = re.findall(r"[a-z0-9]+", text)
        if not names_time(text) or not np.isfinite(sample.values[:, column]).any():
            continue
        if (more := _nanoseconds(sample, words[:-1])) is not None:
            how = f"nanoseconds = {sample.toml_name(more)}"
            return Guess("time", (column, more), (how,))
        said = sample.said_unit((column,), "time") or next(
            (word for word in words if word in UNITS["time"]), ""
        )
        unit, remark = _time_unit(sample.values[:, column], said)
        return Guess("time", (column,), (unit_entry(unit),), remark)
    return _index(sample)


def _index(sample: Sample) -> Guess | None:
    """The index of a data frame, a first column without a name or pandas' own, where it
    grows and does not just count rows."""
    own = sample.names.count(PANDAS_INDEX)
    column = sample.names.index(PANDAS_INDEX) if own else 0
    values = sample.values[:, column]
    steps = np.diff(values)
    if (sample.names[0] and not own) or not len(steps) or not (steps > 0.0).all():
        return None
    counts = (values % 1 == 0.0).all() and values[0] < SINCE_1970
    if counts and (own or (steps == 1.0).all()):
        return None
    unit, remark = _time_unit(values, "")
    return Guess("time", (column,), (unit_entry(unit),), remark)


def _nanoseconds(sample: Sample, before: Sequence[str]) -> int | None:
    """The column of nanoseconds whose name begins with the words that stand before
    ``sec``."""
    for column in range(len(sample.names)):
        words = re.findall(r"[a-z0-9]+", sample.words(column).lower())
        if words[:-1] == list(before) and words[-1:] and words[-1] in NANOSECONDS:
            return column
    return None


def _time_unit(values: np.ndarray, said: str) -> tuple[str, str]:
    """Unit of the time, by its name or its steps, and why."""
    if said:
        return said, ""
    steps = np.diff(values[np.isfinite(values)])
    step = float(np.median(np.abs(steps))) if len(steps) else 0.0
    for unit, least in (("ns", 1e5), ("us", 1e2), ("ms", 1.0)):
        if step >= least:
            return unit, f"by its steps of {step:.4g}"
    return "s", ""


def _wrench(sample: Sample, groups: Groups) -> list[Guess] | None:
    six = groups.numbered("wrench", 6) or groups.numbered("force", 6)
    force, torque = (
        groups.find(kind, "xyz") or groups.numbered(kind, 3)
        for kind in ("force", "torque")
    )
    torque = torque or groups.find("torque-or-translation", "xyz")
    if six is not None:
        force, torque = six[:3], six[3:]
    if force is None or torque is None:
        return None
    units, remark = _wrench_units(sample, force, torque)
    axes = ('axes = "world"',) if _is_in_base(sample.words(force[0])) else ()
    return [Guess("wrench", (*force, *torque), (units, *axes), remark)]


def _is_in_base(name: str) -> bool:
    """Whether a wrench is Franka's in the axes of the base, ``O_F_ext_hat_K_0``."""
    return words_of(name)[:3] == ["o", "f", "ext"]


def _wrench_units(
    sample: Sample, force: tuple[int, ...], torque: tuple[int, ...]
) -> tuple[str, str]:
    one = sample.said_unit(force, "force")
    two = sample.said_unit(torque, "torque")
    remarks = [] if one else [sample.unknown_unit(force)]
    if two is None:
        f, t = (sample.size(columns) for columns in (force, torque))
        two = "N m"
        remarks.append(sample.unknown_unit(torque))
        if f > 0.0 and t / f > LARGEST_LEVER:
            two = "N mm"
            remarks.append(f"by its size: {t / f:.3g} times the force")
    remark = "; ".join(filter(None, dict.fromkeys(remarks)))
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
        return [
            _length("position", sample, six[:3]),
            turned(sample, six[3:], UNTOLD),
        ]
    return None


def _quaternion(sample: Sample, groups: Groups) -> Guess | None:
    named = groups.find("orientation", "xyzw")
    if named is not None:
        return Guess("orientation", named)
    numbered = groups.numbered("orientation", 4)
    if numbered is None or not _has_unit_norm(sample, numbered):
        return None
    return _four(sample, numbered)


def _four(sample: Sample, columns: tuple[int, ...]) -> Guess:
    """A quaternion whose columns are numbers: of ``q0`` to ``q3``, as of ABB's ``q1`` or
    ``rot.q1`` to ``q4``, the first is w."""
    bare = re.fullmatch(r"(rot\.)?q\d", sample.words(columns[0]).lower()) is not None
    form, other = ("wxyz", "xyzw") if bare else ("xyzw", "wxyz")
    remark = f"or {other}: their numbers do not tell which is w"
    return Guess("orientation", columns, (f'form = "{form}"',), remark)


def _has_unit_norm(sample: Sample, columns: tuple[int, ...]) -> bool:
    norms = np.linalg.norm(sample.values[:, list(columns)], axis=1)
    known = norms[np.isfinite(norms)]
    return len(known) > 0 and bool((np.abs(known - 1.0) < UNIT_NORM).all())


def _position(sample: Sample, groups: Groups) -> Guess | None:
    columns = (
        groups.find("position", "xyz")
        or groups.numbered("position", 3)
        or groups.find("torque-or-translation", "xyz")
    )
    return None if columns is None else _length("position", sample, columns)


def _joints(sample: Sample, groups: Groups) -> Guess | None:
    if len(named := _named_joints(sample)) >= FEWEST_JOINTS:
        unit, remark = sample.stated_or_by_size(named, "angle")
        names = json.dumps([sample.words(column) for column in named])
        rest = (unit_entry(unit), f"names = {names}")
        return Guess("joint_positions", named, rest, remark)
    for count in range(9, FEWEST_JOINTS - 1, -1):
        columns = groups.numbered("joint_positions", count)
        if columns is not None and not (count == 4 and _has_unit_norm(sample, columns)):
            unit, remark = sample.stated_or_by_size(columns, "angle")
            return Guess("joint_positions", columns, (unit_entry(unit),), remark)
    return None


def _named_joints(sample: Sample) -> tuple[int, ...]:
    """Columns with the names of a robot's joints: ``wrist_3_joint``."""
    words = [words_of(sample.words(column)) for column in range(len(sample.names))]
    return tuple(
        column
        for column, each in enumerate(words)
        if len(each) > 1 and each[-1] == "joint" and not OTHER & set(each)
    )


def _inertial(sample: Sample, groups: Groups) -> list[Guess] | None:
    found = []
    for key, kind in (
        ("gyroscope", "angular speed"),
        ("linear_accelerometer", "acceleration"),
        ("accelerometer", "acceleration"),
    ):
        columns = groups.find(key, "xyz")
        if columns is not None:
            said = sample.said_unit(columns, kind)
            found.append(Guess(key, columns, (unit_entry(said),) if said else ()))
    return found


def _length(key: str, sample: Sample, columns: tuple[int, ...]) -> Guess:
    unit, remark = sample.stated_or_by_size(columns, "length")
    return Guess(key, columns, (unit_entry(unit),), remark)

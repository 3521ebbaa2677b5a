"""A column map guessed from the names and numbers of a table, for a person to check.

The words of its name (``/ft/wrench/force/x``, ``Fx [N]``, ``actual_TCP_pose_3``) tell a
column's quantity and component: x, y, z, w or a number. The header, or the size of the
numbers, tells its unit.
"""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.logs.map_groups import (
    ESTIMATED,
    QUANTITY_WORDS,
    Choice,
    Groups,
    best_of,
    group_columns,
    is_other,
    names_frame,
    rank_of,
    words_of,
)
from hefting.logs.map_joints import JOINT_EFFORTS, UNIT_NORM, has_unit_norm, joints_of
from hefting.logs.map_sample import Sample, read_sample
from hefting.logs.map_text import (
    ANOTHER_ORDER,
    BY_NUMBERS,
    RPY,
    ZYZ,
    Guess,
    angles_guess,
    angles_of,
    doubts_of,
    in_unit,
    map_text,
    summary_of,
    unit_entry,
    unread_of,
    unread_positions,
)
from hefting.logs.map_time import time_of
from hefting.logs.static_poses import FEWEST_SMOOTH

TIME_EXAMPLE = (
    'time = { column = "time", unit = "s" }, or { rate = 250 } of rows at 250 Hz'
)
ORIENTATION_EXAMPLE = (
    'orientation = { columns = ["qx", "qy", "qz", "qw"] }, or { columns = '
    '["rx", "ry", "rz"], form = "euler", order = "ZYX", unit = "deg" }'
)
"""Lines for a time or orientation that was not found."""

OF_FRANKA = re.compile("(?<![A-Za-z])([OK])_?F_?ext", re.IGNORECASE)
"""Franka's wrench about the stiffness frame, in axes of the base or of that frame."""
LARGEST_LEVER = 5.0
"""Torque over force [m] above which the torque is taken for newton-millimetres."""

LARGEST_ANGLE = 400.0
"""Size [mm or degrees] above which numbers are of a position and not of joints."""


@dataclass(frozen=True)
class GuessedMap:
    """Result of `guess_map`."""

    text: str
    """the column map, TOML"""
    missing: tuple[str, ...]
    """example lines for required quantities that were not found"""
    columns: frozenset[str]
    """names of the columns in the map"""
    summary: str
    """quantities and their columns, in one line"""
    doubts: tuple[str, ...] = ()
    """quantities that may be in other columns, or in another unit"""
    keys: frozenset[str] = frozenset()
    """of the map"""
    is_position_unread: bool = False
    """whether other columns may hold the position, which was not found"""


def guess_map(path: str | Path) -> GuessedMap:
    """A column map of the table at `path`.

    Raises `InputError` where it cannot be read, and where no column is recognised.
    """
    return guess_map_of(read_sample(path))


def guess_map_of(sample: Sample) -> GuessedMap:
    """A column map of the table that begins with `sample`; `InputError` where no column
    is recognised."""
    guesses = _guesses(sample)
    keys = frozenset(guess.key for guess in guesses)
    if not keys - {"time"}:
        what = "no column has a name that says what it holds"
        fix = "write the map by hand, with the numbers of the columns"
        raise InputError(what, sample.source, fix)
    used = {j for guess in guesses for j in guess.columns}
    missing = [] if "time" in keys or _are_poses(sample, used) else [TIME_EXAMPLE]
    if not keys & {"wrench", *JOINT_EFFORTS}:
        missing.append('wrench = { columns = ["fx", "fy", "fz", "tx", "ty", "tz"] }')
    if not keys & {"orientation", "pose", "joint_positions"}:
        missing.append(ORIENTATION_EXAMPLE)
    summary = "; ".join(summary_of(sample, guess) for guess in guesses)
    columns = frozenset(sample.names[j] for j in used)
    text = map_text(sample, guesses, missing)
    unread = unread_of(sample, guesses)
    doubts = (*doubts_of(sample, guesses), *filter(None, (unread,)))
    return GuessedMap(
        text, tuple(missing), columns, summary, doubts, keys, unread != ""
    )


def _are_poses(sample: Sample, used: set[int]) -> bool:
    """Whether rows are too few for a motion, and no other column than those `used`
    increases, as a time of an unknown name, except a count."""
    others = [j for j in range(len(sample.names)) if j not in used]
    steps = np.diff(sample.values[:, others], axis=0)
    grows = (steps > 0.0).all(axis=0) & (steps != 1.0).any(axis=0)
    return len(sample.values) < FEWEST_SMOOTH and not grows.any()


def _guesses(sample: Sample) -> list[Guess]:
    """Guesses of all quantities; a later one that needs a taken column is left out."""
    groups = group_columns([sample.words(j) for j in range(len(sample.names))])
    makers: Sequence[
        Callable[[Sample, Groups, set[str]], Guess | list[Guess] | None]
    ] = (_wrench, _poses, _orientation, _position, joints_of, _inertial)
    time = time_of(sample)
    found: list[Guess] = [time] if time else []
    taken: set[int] = set(time.columns) if time else set()
    keys: set[str] = set()
    for make in makers:
        firsts = [guess.columns[0] for guess in found if guess.key != "time"]
        near = {word for j in firsts for word in words_of(sample.words(j))}
        made = make(sample, groups, near) or []
        for guess in made if isinstance(made, list) else [made]:
            if guess.key not in keys and not taken & set(guess.columns):
                found.append(guess)
                taken |= set(guess.columns)
                keys.add(guess.key)
    places = [c for c in unread_positions(sample, found) if _is_position(sample, c)]
    if (place := best_of(places)) is not None:
        found.append(_length("position", sample, place.columns, place.equals))
    return found


def _wrench(sample: Sample, groups: Groups, near: set[str]) -> Guess | None:
    six = groups.numbered("wrench", 6) or groups.numbered("force", 6)
    of_torques = groups.words_of_kinds(("torque", "torque-or-translation"))
    first = groups.find("force", "xyz", of_torques) or groups.numbered("force", 3)
    if not (first or six):  # ``ft_x`` beside ``ft_rx``
        first = groups.find("wrench", "xyz")
    second = _torque(groups, {*first.words}) if first else None
    known = [
        c and not ESTIMATED.search(sample.names[c.columns[0]]) for c in (first, six)
    ]
    if first and second and (known[0] or not known[1]):
        force, torque = first.columns, second.columns
        equals = first.equals + second.equals
        if six and "tcp" not in six.words:  # of a TCP a controller estimates it
            equals += six.columns[:1]
    elif six:
        force, torque, equals = six.columns[:3], six.columns[3:], six.equals
    else:
        return None
    units, remark = _wrench_units(sample, force, torque)
    axes = ()
    if franka := OF_FRANKA.search(sample.words(force[0])):
        axes = ('axes = "world"',) if franka[1] in "Oo" else ()
        equals = tuple(j for j in equals if not OF_FRANKA.search(sample.words(j)))
    return Guess("wrench", (*force, *torque), (units, *axes), remark, equals)


def _torque(groups: Groups, near: set[str]) -> Choice | None:
    """The torque of a force. If there are ``tx`` and ``mx``, ``tx`` is a translation,
    unless the position is in other columns: then ``mx`` may be of a magnetometer."""
    torque = groups.find("torque", "xyz", near)
    kind = "torque-or-translation"
    either = groups.find(kind, "xyz", near) or groups.numbered(kind, 3, near)
    of = {*either.words} - QUANTITY_WORDS if either else set()
    if either is None or (of and not of & near):  # ``base_tx`` beside ``sensor_fx``
        return torque or groups.numbered("torque", 3, near)
    if torque is None:
        return either
    if groups.find("position", "xyz") or either.rank > torque.rank:
        doubt = () if groups.find("gyroscope", "xyz") else torque.columns[:1]
        return Choice(either.columns, either.words, either.rank, doubt)
    return torque


def _wrench_units(
    sample: Sample, force: tuple[int, ...], torque: tuple[int, ...]
) -> tuple[str, str]:
    force_unit = sample.stated_unit(force, "force")
    torque_unit = sample.stated_unit(torque, "torque")
    remarks = [] if force_unit else [sample.unknown_unit(force)]
    if torque_unit is None:
        f, t = (sample.size(columns) for columns in (force, torque))
        torque_unit = "N m"
        remarks.append(sample.unknown_unit(torque))
        if f > 0.0 and t / f > LARGEST_LEVER:
            torque_unit = "N mm"
            remarks.append(f"by its size: {t / f:.3g} times the force")
    remark = "; ".join(filter(None, dict.fromkeys(remarks)))
    return f"unit = {json.dumps([force_unit or 'N', torque_unit])}", remark


def _poses(sample: Sample, groups: Groups, near: set[str]) -> list[Guess] | None:
    """Poses in one numbered group: a matrix, or a position with an orientation."""
    if (matrix := groups.matrix("matrix", 4, near)) is not None:
        return [Guess("pose", matrix.columns, ('form = "matrix4"',), "", matrix.equals)]
    matrix = groups.numbered("pose-matrix", 16, near) or _rigid(sample, groups, near)
    if matrix is not None:
        last = np.abs(sample.values[:, list(matrix.columns[12:15])])
        form = "matrix4-columns" if (last > 1e-6).any() else "matrix4"
        return [Guess("pose", matrix.columns, (f'form = "{form}"',), "", matrix.equals)]
    if (seven := groups.numbered("pose", 7, near)) is not None:
        four = Choice(seven.columns[3:], seven.words, seven.rank, seven.equals)
        position = _length("position", sample, seven.columns[:3])
        return [position, _numbered_quaternion(sample, four)]
    six = groups.numbered("pose", 6, near)
    form, doubt = ZYZ if six and six.words[-1] == "posx" else BY_NUMBERS, ""
    position = groups.numbered("position", 6, near)
    if six is None and position is not None:
        if {"tcp", "flange"} & {*position.words}:  # Doosan's, like ``posx``
            six, form, doubt = position, ZYZ, "as of Doosan; other makes differ"
        elif sample.size(position.columns[:3]) > LARGEST_ANGLE:
            six, form, doubt = position, RPY, ANOTHER_ORDER  # of xArm
    if six is not None:
        return [
            _length("position", sample, six.columns[:3]),
            angles_guess(sample, six.columns[3:], form, doubt, six.equals),
        ]
    return None


def _rigid(sample: Sample, groups: Groups, near: set[str]) -> Choice | None:
    """Sixteen numbered columns of any name whose numbers are homogeneous matrices, but
    not of another place (a negative rank)."""
    found = []
    for words, columns in groups.by_words.items():
        numbers = sorted(filter(str.isdigit, columns), key=int)  # ``Tx`` beside ``T0``
        if is_other(words) or len(numbers) != 16:
            continue
        chosen = tuple(columns[c] for c in numbers)
        poses = sample.values[:, list(chosen)].reshape(-1, 4, 4)
        poses = poses[np.isfinite(poses).all(axis=(1, 2))]
        if (poses[:, 3, :3] != 0.0).any():
            poses = poses.swapaxes(1, 2)
        turns = poses[:, :3, :3]
        off = np.abs(turns @ turns.swapaxes(1, 2) - np.eye(3))
        last = np.abs(poses[:, 3] - np.eye(4)[3])
        if len(poses) and max(off.max(), last.max()) < UNIT_NORM:
            found.append(Choice(chosen, words, rank_of(words, near)))
    return best_of([choice for choice in found if choice.rank >= 0])


def _orientation(sample: Sample, groups: Groups, near: set[str]) -> Guess | None:
    """The orientation: a quaternion, unless angles have a higher rank, or a rotation
    matrix, or a numbered quaternion."""
    quaternion = groups.find("orientation", "xyzw", near)
    angles = angles_of(sample, groups, near)
    if quaternion is not None and (angles is None or quaternion.rank >= angles[0].rank):
        equals = quaternion.equals
        if angles and angles[0].rank == quaternion.rank:
            one, two = (
                {*each.words} - QUANTITY_WORDS for each in (quaternion, angles[0])
            )
            equals += angles[0].columns[:1] if one != two else ()
        return Guess("orientation", quaternion.columns, equals=equals)
    named = groups.matrix("rotation-matrix", 3, near)
    nine = named or groups.numbered("rotation-matrix", 9, near)
    by_columns = nine is not None and sample.names[nine.columns[0]] == "Rot[0]"
    if angles is not None and not by_columns:  # Qualisys' angles are in any order
        return angles[1]
    if nine is not None:
        columns, remark = nine.columns, "" if named else "row by row"
        if by_columns:
            remark = "column by column"
            columns = (*columns[::3], *columns[1::3], *columns[2::3])
        return Guess("orientation", columns, ('form = "matrix"',), remark, nine.equals)
    numbered = groups.numbered("orientation", 4, near)
    if numbered is None or not has_unit_norm(sample, numbered.columns):
        return None
    return _numbered_quaternion(sample, numbered)


def _numbered_quaternion(sample: Sample, choice: Choice) -> Guess:
    """A quaternion with numbered components. The first is w for ``q0`` to ``q3``, ABB's
    ``q1`` or ``rot.q1`` to ``q4``, ``u0`` or ``orient.u0`` to ``u3``, and MuJoCo's
    ``xquat`` and ``framequat``; else the last."""
    name = sample.words(choice.columns[0]).lower()
    w_first = (
        re.fullmatch(r"(rot\.)?q\d|(.*\W)?u\d|.*(wxyz|xquat|framequat).*", name)
        is not None
    )
    form, other = ("wxyz", "xyzw") if w_first else ("xyzw", "wxyz")
    remark = f"or {other}: their numbers do not tell which is w"
    if {"wxyz", "xyzw"} & set(choice.words):
        remark = ""
    return Guess(
        "orientation", choice.columns, (f'form = "{form}"',), remark, choice.equals
    )


def _position(sample: Sample, groups: Groups, near: set[str]) -> Guess | None:
    choice = (
        groups.find("position", "xyz", near)
        or groups.numbered("position", 3, near)
        or groups.xyz_of_words(near - QUANTITY_WORDS)
        or groups.find("torque-or-translation", "xyz", near)
    )
    if choice is None:
        return None
    return _length("position", sample, choice.columns, choice.equals)


def _is_position(sample: Sample, choice: Choice) -> bool:
    """Whether columns x, y, z that no quantity claims are a position, by a unit of length
    or the name of a frame alone without another unit."""
    if sample.stated_unit(choice.columns, "length"):
        return True
    others = (sample.stated_unit(choice.columns, k) for k in ("force", "torque"))
    is_other = sample.unknown_unit(choice.columns) or any(others)
    return names_frame(choice.words) and not is_other


def _inertial(sample: Sample, groups: Groups, near: set[str]) -> list[Guess] | None:
    found = []
    for key, kind in (
        ("gyroscope", "angular speed"),
        ("linear_accelerometer", "acceleration"),
        ("accelerometer", "acceleration"),
    ):
        choice = groups.find(key, "xyz", near)
        if choice is not None:
            found.append(in_unit(key, kind, None, sample, choice.columns))
    return found


def _length(
    key: str, sample: Sample, columns: tuple[int, ...], equals: tuple[int, ...] = ()
) -> Guess:
    unit, remark = sample.stated_or_by_size(columns, "length")
    return Guess(key, columns, (unit_entry(unit),), remark, equals)

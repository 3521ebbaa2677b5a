"""Column maps: a small TOML file that says which columns of someone else's log hold
what, and in which units.

::

    time = { column = "timestamp", unit = "ms" }          # s, ms, us, ns, min; or rate = 100 [Hz] for a frame number;
                                                          # { column = "sec", nanoseconds = "nanosec" }; or ISO dates
    position = { columns = ["x", "y", "z"], unit = "mm" }
    orientation = { columns = ["A", "B", "C"], form = "euler", order = "ZYX", unit = "deg" }
    wrench = { columns = "ft_{0..5}", unit = ["N", "N mm"] }

``wrench`` or both ``force`` and ``torque`` must be there, and ``orientation``, ``pose``
or ``joint_positions``. Further keys are the streams of
`hefting.core.recording.Recording`. Columns alone, without braces, are in SI units.

- A column is given by its name, or by its number counted from 1; ``"q[{0..6}]"`` stands
  for seven names, and ``"-fz"`` for the negative of a column that has a unit.
- ``form`` of an orientation: a key of `hefting.logs.orientations.FORMS` (xyzw when
  there is none). ``pose`` is a homogeneous matrix in 16 columns with the length unit of
  its last column, ``form = "matrix4"`` or ``"matrix4-columns"``.
- ``axes = "world"`` turns a wrench that was recorded in world axes; else it is in
  sensor axes.
- ``names`` of ``joint_positions`` are the joints' names in the URDF.
- Without ``time``, each row is a static pose; ``time = { rate = 1000 }`` counts rows.
- ``sensor_pose_in_log = [x, y, z, qx, qy, qz, qw]`` or ``sensor_turned = "z:45"``: the
  sensor in the frame whose pose is logged, where that is another.
- The file's layout, where it is not found by itself: ``separator`` (``,`` ``;`` ``|``
  ``tab`` ``space``), ``header`` (the line of the column names, from 1, or false),
  ``skip`` (lines of units and the like after it), ``decimal`` (``.`` or ``,``), and
  ``nan = "blank"`` where NaN means "not measured".
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError
from hefting.core.files import load_toml
from hefting.core.spatial import Array
from hefting.logs.layout import LAYOUT_KEYS, Layout, brief, layout_of, nan_is_blank
from hefting.logs.map_entries import (
    MappedTime,
    check_known,
    parse_columns,
    parse_entry,
    parse_time,
)
from hefting.logs.orientations import (
    ANGULAR,
    FORMS,
    POSE_FORMS,
    SENSOR_KEYS,
    is_euler_order,
    mapped_sensor_pose,
)
from hefting.logs.units import UNITS, Unit, find_unit

KINDS: dict[str, tuple[tuple[str, int], ...]] = {
    "position": (("length", 3),),
    "linear_velocity": (("speed", 3),),
    "angular_velocity": (("angular speed", 3),),
    "linear_acceleration": (("acceleration", 3),),
    "angular_acceleration": (("angular acceleration", 3),),
    "joint_positions": (("angle", 0),),
    "joint_velocities": (("angular speed", 0),),
    "joint_torques": (("torque", 0),),
    "joint_currents": (("current", 0),),
    "wrench": (("force", 3), ("torque", 3)),
    "force": (("force", 3),),
    "torque": (("torque", 3),),
    "gyroscope": (("angular speed", 3),),
    "accelerometer": (("acceleration", 3),),
    "linear_accelerometer": (("acceleration", 3),),
}
"""Kinds of unit of each key, with the number of columns of each kind; 0: any number."""

KEYS = ("time", "position", "orientation", "pose", *list(KINDS)[1:])
"""Keys of a column map that name columns, in the order in which messages list them."""

ALLOWED = {
    "orientation": ("columns", "unit", "form", "order"),
    "pose": ("columns", "unit", "form"),
    "joint_positions": ("columns", "unit", "names"),
    **dict.fromkeys(("wrench", "force", "torque"), ("columns", "unit", "axes")),
}
"""Words that a key may have; for all others ``columns`` and ``unit``."""


@dataclass(frozen=True)
class Quantity:
    """Columns of the log, and how to read them."""

    columns: tuple[str | int, ...]
    """names, or numbers counted from 1"""
    units: tuple[Unit, ...]
    """one for each column; empty for quantities without units"""
    form: str = ""
    """of an orientation or a pose"""
    order: str = ""
    """of Euler angles"""
    in_world: bool = False
    """a wrench in world axes"""
    names: tuple[str, ...] = ()
    """of joints"""


@dataclass(frozen=True)
class ColumnMap:
    """Content of a column map; `load_map` reads one."""

    source: str
    layout: Layout
    time: MappedTime | None
    """None: static poses"""
    quantities: Mapping[str, Quantity]
    """by key"""
    nan_is_blank: bool = False
    sensor_pose: Array | None = None
    """(4, 4) pose of the sensor in the logged frame [m]; None where they are the same"""


def load_map(path: str | Path, wrench_needed: bool = True) -> ColumnMap:
    """The column map in a TOML file. `InputError`, naming file and key, for unknown or
    contradictory content."""
    content = load_toml(path)
    if "poses" in content:
        raise InputError("has a map of a second file", path, "give that (`poses`)")
    return column_map_of(content, path, wrench_needed)


def column_map_of(
    content: Mapping[str, Any],
    path: str | Path,
    wrench_needed: bool = True,
    *,
    is_part: bool = False,
) -> ColumnMap:
    """The column map of a TOML file's content; errors are those of `load_map` and name
    `path`. With `is_part` another file holds the other streams."""
    check_known(content, (*KEYS, *SENSOR_KEYS, *LAYOUT_KEYS), path, "key")
    time = content.get("time")
    quantities = {
        key: _parse_quantity(key, content[key], f"{path}, key {key}")
        for key in KEYS[1:]
        if key in content
    }
    _check_combination(quantities, path)
    if not is_part:
        _check_whole(quantities, path, wrench_needed)
    return ColumnMap(
        str(path),
        layout_of(content, path),
        None if time is None else parse_time(time, f"{path}, key time"),
        quantities,
        nan_is_blank(content, path),
        mapped_sensor_pose(content, path),
    )


def _parse_quantity(key: str, value: Any, where: str) -> Quantity:
    words = ALLOWED.get(key, ("columns", "unit"))
    entry = parse_entry(value, "columns", words, where)
    if "columns" not in entry:
        raise InputError(
            "does not say which columns", where, 'give { columns = ["name", ...] }'
        )
    columns = parse_columns(entry["columns"], f"{where}.columns")
    form, order = _parse_form(key, entry, where)
    width = (
        {**FORMS, **POSE_FORMS}[form] if form else sum(count for _, count in KINDS[key])
    )
    if width and len(columns) != width:
        kind = f"{key} ({form})" if form else key
        raise InputError(
            f"names {len(columns)} columns, {kind} has {width}", f"{where}.columns"
        )
    if key == "orientation":
        kinds = (("angle", 3),) if form in ANGULAR else ()
        if not kinds and "unit" in entry:
            what = f"an orientation of form {form} has no unit"
            raise InputError(what, f"{where}.unit", "leave it out")
    else:
        kinds = (("length", 16),) if key == "pose" else KINDS[key]
    axes = entry.get("axes", "sensor")
    if axes not in ("sensor", "world"):
        raise InputError(
            f"{brief(axes)} are no axes", f"{where}.axes", "use sensor or world"
        )
    units = _parse_units(entry.get("unit"), kinds, len(columns), f"{where}.unit")
    return Quantity(
        columns,
        units,
        form,
        order,
        axes == "world",
        _parse_names(entry, len(columns), where),
    )


def _parse_form(key: str, entry: Mapping[str, Any], where: str) -> tuple[str, str]:
    """Form of an orientation or pose and order of its angles; empty for other keys."""
    if key not in ("orientation", "pose"):
        return "", ""
    forms = FORMS if key == "orientation" else POSE_FORMS
    form = entry.get("form", "xyzw" if key == "orientation" else None)
    order = entry.get("order")
    if not isinstance(form, str) or form not in forms:
        what = (
            f"{brief(form)} is no form of {key}"
            if form is not None
            else f"does not say the form of the {key}"
        )
        raise InputError(what, f"{where}.form", f"use {', '.join(forms)}")
    if form != "euler" and order is not None:
        fix = 'give form = "euler", or leave the order out'
        raise InputError(f"form {form} has no order", f"{where}.order", fix)
    if form == "euler" and not is_euler_order(order):
        fix = "give three axes: ZYX about moving axes, or xyz about fixed ones"
        raise InputError(
            f"{brief(order)} is no order of Euler angles", f"{where}.order", fix
        )
    return form, order or ""


def _parse_units(
    value: Any, kinds: Sequence[tuple[str, int]], width: int, where: str
) -> tuple[Unit, ...]:
    """Units of the columns of one quantity.

    `value` is the entry ``unit``: a name, a list with a name for each of the `kinds`,
    or None for SI units. Each kind has its number of columns; 0 stands for all `width`
    of them. `where` is named in errors. Returns a unit for each column. Raises
    `InputError` for too few or too many units, or an unknown one.
    """
    if not kinds:
        return ()
    if value is None:
        names = [next(iter(UNITS[kind])) for kind, _ in kinds]
    else:
        names = value if isinstance(value, list) else [value]
    if len(names) != len(kinds):
        expected = " and one of ".join(kind for kind, _ in kinds)
        raise InputError(
            f"{len(names)} units, not {len(kinds)}", where, f"give one of {expected}"
        )
    units: tuple[Unit, ...] = ()
    for name, (kind, columns) in zip(names, kinds, strict=True):
        units += (find_unit(name, kind, where),) * (columns or width)
    return units


def _parse_names(entry: Mapping[str, Any], width: int, where: str) -> tuple[str, ...]:
    names = entry.get("names", [])
    if not isinstance(names, list) or not all(
        isinstance(name, str) and name for name in names
    ):
        raise InputError(
            "are not a list of names", f"{where}.names", 'give ["joint_1", ...]'
        )
    if names and (len(names) != width or len(set(names)) < width):
        raise InputError(
            f"{len(set(names))} different names for {width} joints", f"{where}.names"
        )
    return tuple(names)


def _check_combination(quantities: Mapping[str, Quantity], path: str | Path) -> None:
    """`InputError` for half a wrench, and for two wrenches or poses."""
    if ("force" in quantities) != ("torque" in quantities):
        what = "gives only one of force and torque"
        raise InputError(what, path, "give both, or wrench with six columns")
    for one, others in (("wrench", ("force",)), ("pose", ("position", "orientation"))):
        for other in others:
            if one in quantities and other in quantities:
                raise InputError(f"gives both {one} and {other}", path, "leave one out")


def _check_whole(
    quantities: Mapping[str, Quantity], path: str | Path, wrench_needed: bool
) -> None:
    """`InputError` unless there are a wrench, if needed, and an orientation or joints."""
    if wrench_needed and not {"wrench", "force"} & set(quantities):
        fix = "give wrench = { columns = [six names] }, or force and torque"
        if {"joint_torques", "joint_currents"} & set(quantities):
            fix = f"of joint torques: hefting identify --torques; or {fix}"
        raise InputError("gives no wrench", path, fix)
    if not {"orientation", "pose", "joint_positions"} & set(quantities):
        fix = "give orientation, pose or joint_positions = { columns = [...] }"
        raise InputError("gives neither an orientation nor joint angles", path, fix)
    turned = [
        key
        for key in ("wrench", "force", "torque")
        if key in quantities and quantities[key].in_world
    ]
    if turned and not {"orientation", "pose"} & set(quantities):
        what = "has a wrench in world axes, but no orientation to turn it by"
        raise InputError(what, path, "give its orientation")

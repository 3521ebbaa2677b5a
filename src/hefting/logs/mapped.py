"""A table and a column map -> Recording, in SI units and this library's conventions."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, note
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, immutable
from hefting.logs.column_map import ColumnMap, Quantity
from hefting.logs.orientations import (
    ANGULAR,
    POSE_FORMS,
    check_matrices,
    in_sensor_axes,
    quaternions,
    split_pose,
    with_sensor_pose,
)
from hefting.logs.static_poses import warn_about_static, without_times
from hefting.logs.table import (
    Table,
    collect,
    in_seconds,
    label,
    require_streams,
    summarize_list,
)
from hefting.logs.units import Unit


@immutable
class Mapped:
    """Streams of a table by a column map."""

    streams: Mapping[str, Stream]
    """in SI units; their times are in `unit`"""
    unit: Unit | None
    """of the times; None: static poses"""
    warnings: tuple[Message, ...] = ()
    notes: tuple[Message, ...] = ()
    joint_names: tuple[str, ...] = ()
    in_world: bool = False
    """whether the wrench is in world axes"""
    sensor_pose: Array | None = None
    """(4, 4) pose of the sensor in the logged frame [m]; None where they are the same"""

    def recording(self, source: str, wrench_needed: bool = True) -> Recording:
        """The recording, its times in seconds and its wrench in sensor axes.

        `InputError` for a stream that is missing, and as `hefting.logs.table.in_seconds`
        and `Recording`.
        """
        require_streams(self.streams, source, wrench_needed)
        streams, warnings = dict(self.streams), self.warnings
        if self.sensor_pose is not None or self.in_world:
            streams.pop("angles", None)
        if self.unit is not None:
            streams, about_time = in_seconds(streams, source, self.unit)
            warnings += about_time
        angles = streams.pop("angles", None)
        recording = Recording(
            streams,
            self.unit is None,
            source,
            warnings,
            joint_names=self.joint_names,
            notes=self.notes,
            angles=angles,
        )
        if self.sensor_pose is not None:
            recording = with_sensor_pose(recording, self.sensor_pose)
        if recording.has("wrench") and self.in_world:
            wrench = recording["wrench"]
            values = in_sensor_axes(recording)
            turned = {**recording.streams, "wrench": replace(wrench, values=values)}
            recording = replace(recording, streams=turned)
        checked = warn_about_static if self.unit is None else without_times
        return checked(recording)


def read_mapped(
    table: Table, column_map: ColumnMap, wrench_needed: bool = True
) -> Recording:
    """Recording in the columns of `table` that `column_map` names.

    Raises `InputError` for absent and repeated columns, naming the map's key, and for
    cells that `hefting.logs.table.collect` and `Recording` refuse, naming row and column.
    """
    return mapped(table, column_map).recording(table.source, wrench_needed)


def mapped(table: Table, column_map: ColumnMap) -> Mapped:
    """Streams of `table` by `column_map`; `InputError` as `read_mapped`."""
    quantities = {
        key: _with_signs(quantity, table)
        for key, quantity in column_map.quantities.items()
    }
    wanted = {key: quantity.columns for key, quantity in quantities.items()}
    clock = column_map.time
    times = {} if clock is None else {"time": clock.columns}
    places = _find_columns(table, column_map, times | wanted)
    time, nanoseconds, *_ = *places.pop("time", ()), None, None
    notes = [
        note(
            f"{key.replace('_', '-')}-source",
            f"{key} from {_describe_source(table, places[key], quantity)}",
        )
        for key, quantity in quantities.items()
    ]
    if clock is not None:
        what = "row numbers" if time is None else f"column {label(table, time)}"
        notes.insert(0, note("time-source", f"time from {what} [{clock.unit.name}]"))
    if "force" in quantities:
        quantities["wrench"] = _join_force_and_torque(
            quantities.pop("force"), quantities.pop("torque"), column_map.source
        )
        places["wrench"] = places.pop("force") + places.pop("torque")
    streams, warnings = collect(
        table, time, places, column_map.nan_is_blank, nanoseconds
    )
    converted: dict[str, Stream] = {}
    for key in tuple(streams):
        labels = [label(table, column) for column in places[key]]
        converted |= _convert_to_si(
            key, streams.pop(key), quantities[key], table.source, labels
        )
    return Mapped(
        converted,
        None if clock is None else clock.unit,
        warnings,
        tuple(notes),
        quantities["joint_positions"].names if "joint_positions" in converted else (),
        "wrench" in quantities and quantities["wrench"].in_world,
        column_map.sensor_pose,
    )


def _with_signs(quantity: Quantity, table: Table) -> Quantity:
    """The quantity with ``"-name"`` replaced by ``"name"`` in a negative unit, where the
    table has no column ``"-name"``; except of poses, whose entries have no sign."""
    if quantity.form in POSE_FORMS:
        return quantity
    columns, units = list(quantity.columns), list(quantity.units)
    for i, unit in enumerate(units):
        name = str(columns[i])
        if name[0] == "-" and name not in table.names:
            columns[i] = name[1:]
            units[i] = Unit(f"-{unit.name}", -unit.multiplier, unit.divisor)
    return replace(quantity, columns=tuple(columns), units=tuple(units))


def _find_columns(
    table: Table, column_map: ColumnMap, wanted: Mapping[str, Sequence[str | int]]
) -> dict[str, list[int]]:
    """Indices in the table of the named and numbered columns of each key; `InputError`
    names all that are absent."""
    absent = [
        (key, column)
        for key, columns in wanted.items()
        for column in columns
        if not _is_there(table, column)
    ]
    if absent:
        raise _absent(table, column_map, absent)
    return {
        key: [_place(table, column_map, key, column) for column in columns]
        for key, columns in wanted.items()
    }


def has_columns(table: Table, column_map: ColumnMap) -> bool:
    """Whether a table has all the columns that a map names."""
    wanted = [_with_signs(each, table) for each in column_map.quantities.values()]
    named = [c for each in wanted for c in each.columns]
    named += column_map.time.columns if column_map.time else []
    return all(_is_there(table, column) for column in named)


def _is_there(table: Table, column: str | int) -> bool:
    if isinstance(column, int):
        return column <= len(table.names)
    return column in table.names


def _absent(
    table: Table, column_map: ColumnMap, absent: Sequence[tuple[str, str | int]]
) -> InputError:
    """The error for columns, by key, that the table does not have."""
    keys = list(dict.fromkeys(key for key, _ in absent))
    where = f"{column_map.source}, key{'s' if len(keys) > 1 else ''} {', '.join(keys)}"
    known = list(filter(None, table.names))
    names = [
        f"number {column}"
        if isinstance(column, int)
        else f"{column[:40]!r}{nearest(column, known)}"
        for _, column in absent
    ]
    plural = "s" if len(names) > 1 else ""
    what = f"{table.source} has no column{plural} {summarize_list(names)}"
    if any(isinstance(column, str) for _, column in absent):
        fix = (
            f"its columns are {summarize_list([repr(name[:40]) for name in known])}"
            if known
            else "its columns have no names: give their numbers"
        )
    else:
        fix = f"it has {len(table.names)} columns"
    return InputError(what, where, fix)


def _place(table: Table, column_map: ColumnMap, key: str, column: str | int) -> int:
    """Index of a present column; `InputError` for a repeated name."""
    if isinstance(column, int):
        return column - 1
    places = [j for j, name in enumerate(table.names) if name == column]
    if len(places) > 1:
        numbers = summarize_list([str(j + 1) for j in places])
        what = f"{table.source} has {len(places)} columns {column[:40]!r}"
        fix = f"give the number of one of them: {numbers}"
        raise InputError(what, f"{column_map.source}, key {key}", fix)
    return places[0]


def _join_force_and_torque(force: Quantity, torque: Quantity, source: str) -> Quantity:
    if force.in_world != torque.in_world:
        what = "force and torque are in different axes"
        raise InputError(what, source, "give both in the same axes")
    return replace(
        force, columns=force.columns + torque.columns, units=force.units + torque.units
    )


def _convert_to_si(
    key: str, stream: Stream, quantity: Quantity, source: str, labels: Sequence[str]
) -> Mapping[str, Stream]:
    if key == "pose":
        positions, matrices = split_pose(stream, quantity.form, source, labels)
        check_matrices(replace(stream, values=matrices), source, labels)
        positions = _scale_columns(positions, quantity.units[:3])
        return {
            "position": replace(stream, values=positions),
            "orientation": replace(stream, values=quaternions(matrices, "matrix")),
        }
    if key == "orientation" and quantity.form == "matrix":
        check_matrices(stream, source, labels)
    values = _scale_columns(stream.values, quantity.units)
    if quantity.form:
        turned = quaternions(values, quantity.form, quantity.order)
        found = {key: replace(stream, values=turned)}
        if quantity.form in ANGULAR:
            found["angles"] = replace(stream, values=values)
        return found
    return {key: replace(stream, values=values)}


def _scale_columns(values: Array, units: Sequence[Unit]) -> Array:
    """Columns (N, d) in SI units, each from its own unit."""
    if all(unit.to_si(np.ones(1))[0] == 1.0 for unit in units):
        return values
    return np.stack(
        [unit.to_si(column) for unit, column in zip(units, values.T, strict=True)],
        axis=1,
    )


def _describe_source(table: Table, places: Sequence[int], quantity: Quantity) -> str:
    units = ", ".join(dict.fromkeys(unit.name for unit in quantity.units))
    form = f", {quantity.form} {quantity.order}".rstrip() if quantity.form else ""
    axes = ", turned from world axes" if quantity.in_world else ""
    return f"columns {summarize_list([label(table, j) for j in places])}{units and f' [{units}]'}{form}{axes}"

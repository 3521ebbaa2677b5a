"""A table and a column map -> Recording, in SI units and the project's conventions."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.messages import note
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array
from hefting.logs.column_map import ColumnMap, Quantity
from hefting.logs.orientations import (
    check_matrices,
    in_sensor_axes,
    quaternions,
    split_pose,
)
from hefting.logs.sensor_pose import with_sensor_pose
from hefting.logs.table import (
    Table,
    collect,
    in_seconds,
    label,
    require_streams,
    summarize_list,
    warn_about_static,
)
from hefting.logs.units import Unit


def read_mapped(
    table: Table, column_map: ColumnMap, wrench_needed: bool = True
) -> Recording:
    """Recording in the columns of `table` that `column_map` names; the others do not
    matter.

    Raises `InputError` for columns that are not there or there twice, naming the map's
    key, and for cells that `hefting.logs.table.collect` and `Recording` refuse, naming
    row and column.
    """
    quantities = dict(column_map.quantities)
    places = {
        key: _find_columns(table, column_map, key, quantity.columns)
        for key, quantity in quantities.items()
    }
    time = (
        None
        if column_map.time is None
        else _find_columns(table, column_map, "time", (column_map.time,))[0]
    )
    notes = [
        note(
            f"{key.replace('_', '-')}-source",
            f"{key} from {_describe_source(table, places[key], quantity)}",
        )
        for key, quantity in quantities.items()
    ]
    if "force" in quantities:
        quantities["wrench"] = _join_force_and_torque(
            quantities.pop("force"), quantities.pop("torque"), column_map.source
        )
        places["wrench"] = places.pop("force") + places.pop("torque")
    streams, warnings = collect(table, time, places, column_map.nan_is_blank)
    converted = {}
    for key in tuple(streams):
        labels = [label(table, column) for column in places[key]]
        converted |= _convert_to_si(
            key, streams.pop(key), quantities[key], table.source, labels
        )
    require_streams(converted, table.source, wrench_needed)
    unit = column_map.time_unit
    if unit is not None:
        what = "row numbers" if time is None else f"column {label(table, time)}"
        notes.insert(0, note("time-source", f"time from {what} [{unit.name}]"))
        converted, about_time = in_seconds(converted, table.source, unit)
        warnings += about_time
    names = (
        quantities["joint_positions"].names if "joint_positions" in converted else ()
    )
    recording = Recording(
        converted,
        unit is None,
        table.source,
        warnings,
        joint_names=names,
        notes=tuple(notes),
    )
    if column_map.sensor_pose is not None:
        recording = with_sensor_pose(recording, column_map.sensor_pose)
    if recording.has("wrench") and quantities["wrench"].in_world:
        values = in_sensor_axes(
            recording["wrench"], recording["orientation"], table.source
        )
        turned = replace(recording["wrench"], values=values)
        recording = replace(recording, streams={**recording.streams, "wrench": turned})
    return warn_about_static(recording) if unit is None else recording


def _find_columns(
    table: Table, column_map: ColumnMap, key: str, columns: Sequence[str | int]
) -> list[int]:
    """Positions of named and numbered columns in the table."""
    where = f"{column_map.source}, key {key}"
    places = []
    for column in columns:
        if isinstance(column, int):
            if column > len(table.names):
                raise InputError(
                    f"there is no column number {column}: {table.source} has {len(table.names)}",
                    where,
                )
            places.append(column - 1)
            continue
        count = table.names.count(column)
        if count == 0:
            what = f"{table.source} has no column {column[:40]!r}{nearest(column, filter(None, table.names))}"
            named = [repr(name[:40]) for name in table.names if name]
            fix = (
                f"its columns are {summarize_list(named)}"
                if named
                else "its columns have no names: give their numbers"
            )
            raise InputError(what, where, fix)
        if count > 1:
            what = f"{table.source} has {count} columns {column[:40]!r}"
            numbers = [
                str(j) for j, name in enumerate(table.names, 1) if name == column
            ]
            raise InputError(
                what,
                where,
                f"give the number of one of them: {summarize_list(numbers)}",
            )
        places.append(table.names.index(column))
    return places


def _join_force_and_torque(force: Quantity, torque: Quantity, source: str) -> Quantity:
    """Force and torque as one wrench."""
    if force.in_world != torque.in_world:
        raise InputError(
            "force and torque are in different axes",
            source,
            "give both in the same axes",
        )
    return replace(
        force, columns=force.columns + torque.columns, units=force.units + torque.units
    )


def _convert_to_si(
    key: str, stream: Stream, quantity: Quantity, source: str, labels: Sequence[str]
) -> Mapping[str, Stream]:
    """The streams in SI units that a key stands for."""
    if key == "pose":
        positions, matrices = split_pose(stream, quantity.form, source, labels)
        turned = replace(stream, values=matrices)
        check_matrices(turned, source, labels)
        return {
            "position": replace(
                stream, values=_scale_columns(positions, quantity.units[:3])
            ),
            "orientation": replace(stream, values=quaternions(matrices, "matrix")),
        }
    if key == "orientation" and quantity.form == "matrix":
        check_matrices(stream, source, labels)
    values = _scale_columns(stream.values, quantity.units)
    return {
        key: replace(
            stream,
            values=quaternions(values, quantity.form, quantity.order)
            if quantity.form
            else values,
        )
    }


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

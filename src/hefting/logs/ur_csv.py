"""Real-time records of Universal Robots (RTDE's ``record.py``) -> Recording.

Fields are numbered columns (``actual_TCP_pose_0`` to ``_5``), cells are separated by
spaces or commas, units are SI. The fields (source: RTDE guide of Universal Robots; for
the reference point, the frames of the manufacturer's ROS driver):

================== ==================================================================================
timestamp          [s] since the controller started
actual_TCP_pose    TCP in the robot's base: x, y, z [m] and a rotation vector [rad]
tcp_offset         TCP in the flange, in the same form
actual_TCP_speed   of the TCP, base axes [m/s, rad/s]
ft_raw_wrench      of the sensor in the flange, flange axes; neither zeroed nor freed of any payload, so that
                   its bias may be thousands of newtons (e-Series from 5.9 on)
actual_TCP_force   in base axes; zeroed, and freed of the payload that is *configured in the controller*; about
                   the flange on e-Series, about the TCP on CB3, which has no sensor and guesses from currents
payload            configured mass [kg]
actual_q, _qd      joint angles and velocities [rad, rad/s]
actual_current     of the joints' motors [A]
================== ==================================================================================

The recording's sensor frame is the flange where ``tcp_offset`` is recorded, and its
world the robot's base.
"""

from collections.abc import Iterable

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array
from hefting.logs.map_groups import group_columns
from hefting.logs.orientations import rotate_into_sensor
from hefting.logs.registry import Format
from hefting.logs.table import Table, collect, in_seconds

FIELDS = {
    "actual_TCP_pose": 6,
    "actual_TCP_speed": 6,
    "tcp_offset": 6,
    "ft_raw_wrench": 6,
    "actual_TCP_force": 6,
    "payload": 1,
    "actual_q": 6,
    "actual_qd": 6,
    "actual_current": 6,
}
"""Number of columns of each field that is read."""

MARKS = frozenset(
    ("actual_TCP_pose_0", "ft_raw_wrench_0", "actual_TCP_force_0", "actual_q_0")
)
"""Columns of which a record has at least one."""

RAW = "ft_raw_wrench"
"""Field of the sensor's own wrench, in flange axes [N, N m]."""

FORCE = "actual_TCP_force"
"""Field of the wrench without the configured payload, in base axes [N, N m]."""


TIMES = ("timestamp", "time", "t")
"""Names of the column of times, the record's own first."""


def is_ur(names: Iterable[str]) -> bool:
    """Whether a header is that of a real-time record. One with the wrench of another
    sensor, or its forces alone where the record has no wrench, is not."""
    names = tuple(names)
    groups = group_columns([name for name in names if not name.startswith(RAW)])
    force = groups.find("force", "xyz")
    own = {f"{RAW}_0", f"{FORCE}_0"} & {*names}
    torque = [groups.find(k, "xyz") for k in ("torque", "torque-or-translation")]
    other = groups.numbered("wrench", 6) or (force and (any(torque) or not own))
    return not (MARKS.isdisjoint(names) or "fx" in names or other)


def read_ur(table: Table, wrench_needed: bool = True) -> Recording:
    """Recording in a real-time record; the sensor frame is the flange, or the TCP.

    Raises `InputError` for a record without timestamps, without a wrench where it is
    needed, or without a pose and joint angles, for a wrench from which the controller
    has removed a payload, and for cells that are no numbers.
    """
    fields = _find_fields(table)
    _check_fields(table, fields, wrench_needed)
    record, values, warnings = _read_record(table, fields)
    raw = _has_raw_wrench(values)
    notes = [note("log-format", "UR real-time record; world is the robot's base")]
    if FORCE in values and not raw:
        warnings += _check_payload(record, values, table.source)
    found = find_motion_and_wrench(values, table.source, raw, notes, warnings)
    if raw or FORCE in values:
        wrench = (
            f"{RAW}, flange axes, never zeroed: expect a large bias"
            if raw
            else f"{FORCE}, turned from base axes"
        )
        notes.append(note("wrench-source", f"wrench from {wrench}"))
    joints = {
        "joint_positions": "actual_q",
        "joint_velocities": "actual_qd",
        "joint_currents": "actual_current",
    }
    found |= {
        stream: values[field] for stream, field in joints.items() if field in values
    }
    recorded = {
        name: Stream(record.time, array, record.rows) for name, array in found.items()
    }
    return Recording(recorded, False, table.source, tuple(warnings), notes=tuple(notes))


def _check_fields(
    table: Table, fields: dict[str, list[int]], wrench_needed: bool
) -> None:
    if _time_of(table) is None:
        fix = "record it too, or give the column of times that name"
        raise InputError("there is no column timestamp", table.source, fix)
    if wrench_needed and not {RAW, FORCE} & set(fields):
        fix = f"record {RAW}, or {FORCE} with payload and tcp_offset"
        raise InputError("there is no wrench", table.source, fix)
    if not {"actual_TCP_pose", "actual_q"} & set(fields):
        what = "there is neither a pose nor joint angles"
        raise InputError(what, table.source, "record actual_TCP_pose")


def _time_of(table: Table) -> str | None:
    return next((name for name in TIMES if name in table.names), None)


def _read_record(
    table: Table, fields: dict[str, list[int]]
) -> tuple[Stream, dict[str, Array], list[Message]]:
    """All fields as one stream with times [s], the values of each, and warnings."""
    everything = [column for columns in fields.values() for column in columns]
    time = table.names.index(_time_of(table) or TIMES[0])
    streams, warnings = collect(table, time, {"record": everything})
    if "record" not in streams:
        raise InputError(
            "there are no samples: all cells are blank", where=table.source
        )
    streams, about_time = in_seconds(streams, table.source)
    record = streams["record"]
    ends = np.cumsum([len(columns) for columns in fields.values()])
    values = dict(zip(fields, np.split(record.values, ends[:-1], axis=1), strict=True))
    return record, values, [*warnings, *about_time]


def _has_raw_wrench(values: dict[str, Array]) -> bool:
    """Whether the sensor's own wrench is there and not constant; a constant one counts
    where there is no other."""
    return RAW in values and (
        FORCE not in values or bool(np.ptp(values[RAW], axis=0).any())
    )


def find_motion_and_wrench(
    values: dict[str, Array],
    source: str,
    raw: bool,
    notes: list[Message],
    warnings: list[Message],
) -> dict[str, Array]:
    """Streams of the flange's motion and the wrench, from the fields (N, width) of N
    records; messages are added to `notes` and `warnings`. `raw` says that the wrench is
    that of `RAW`, else of `FORCE`, if any."""
    has_wrench = raw or FORCE in values
    if "actual_TCP_pose" not in values:
        if has_wrench and not raw:
            what = f"{FORCE} is in base axes, and there is no pose to turn it by"
            raise InputError(what, source, f"record actual_TCP_pose too, or {RAW}")
        return {"wrench": values[RAW]} if raw else {}
    found, rotations, remark = _flange_motion(values)
    notes.append(note("pose-source", remark))
    if has_wrench:
        warnings += _check_reference(values, raw)
        found["wrench"] = (
            values[RAW] if raw else rotate_into_sensor(rotations, values[FORCE])
        )
    return found


def _find_fields(table: Table) -> dict[str, list[int]]:
    """Columns of each field; `InputError` for incomplete fields and repeated names."""
    fields = {}
    for field, width in FIELDS.items():
        names = [f"{field}_{i}" for i in range(width)] if width > 1 else [field]
        there = [name for name in names if name in table.names]
        if there:
            missing = [name for name in names if name not in there]
            if missing:
                what = f"column {missing[0]} is missing beside {there[0]}"
                raise InputError(what, table.source, f"record all of {field}")
            fields[field] = [table.names.index(name) for name in names]
    _check_repeated(table, fields)
    return fields


def _check_repeated(table: Table, fields: dict[str, list[int]]) -> None:
    read = [table.names[column] for columns in fields.values() for column in columns]
    for name in (*TIMES, *read):
        if table.names.count(name) > 1:
            what = f"column {name} is there {table.names.count(name)} times"
            raise InputError(what, table.source, "keep one")


def _check_payload(
    record: Stream, values: dict[str, Array], source: str
) -> list[Message]:
    """`InputError` where the controller has removed a payload from the wrench; a warning
    where that is unknown."""
    if "payload" not in values:
        what = (
            f"payload is not recorded: whatever is set in the controller is already removed from {FORCE}, "
            f"and then the result is not the object (record {RAW}, or add a column payload of 0 if none was set)"
        )
        return [warning("payload-unknown", what)]
    loaded = np.abs(values["payload"][:, 0]) > 1e-6
    if loaded.any():
        k = np.argmax(loaded)
        what = f"the controller has already removed a payload of {values['payload'][k, 0]:.4g} kg from {FORCE}"
        where = f"{source}, row {record.rows[k]}, column payload"
        fix = f"record {RAW}, or set the payload to 0 and record again"
        raise InputError(what, where=where, fix=fix)
    return []


def _flange_motion(values: dict[str, Array]) -> tuple[dict[str, Array], Array, str]:
    """Streams of position, orientation and, if recorded, velocities of the flange, or
    without `tcp_offset` of the TCP; its rotations (N, 3, 3); and a note which it is."""
    from scipy.spatial.transform import Rotation

    pose = values["actual_TCP_pose"]
    position = pose[:, :3]
    rotation = Rotation.from_rotvec(np.array(pose[:, 3:]))
    remark = "pose of the TCP"
    lever = np.zeros_like(position)
    if "tcp_offset" in values:
        offset = values["tcp_offset"]
        rotation = rotation * Rotation.from_rotvec(np.array(offset[:, 3:])).inv()
        # from the TCP to the flange, base axes
        lever = -rotation.apply(np.array(offset[:, :3]))
        position = position + lever
        remark = "pose of the flange: actual_TCP_pose less tcp_offset"
    motion = {"position": position, "orientation": rotation.as_quat()}
    if "actual_TCP_speed" in values:
        turning = values["actual_TCP_speed"][:, 3:]
        motion["linear_velocity"] = values["actual_TCP_speed"][:, :3] + np.cross(
            turning, lever
        )
        motion["angular_velocity"] = turning
    return motion, rotation.as_matrix(), remark


def _check_reference(values: dict[str, Array], raw: bool) -> list[Message]:
    if "tcp_offset" not in values:
        about = (
            "axes and origin of ft_raw_wrench are"
            if raw
            else "the origin of its torques on e-Series is"
        )
        what = (
            f"tcp_offset is not recorded: the TCP is taken to be at the flange, where {about} "
            "(if it was elsewhere, add columns tcp_offset_0 to _5)"
        )
        return [warning("tcp-offset-unknown", what)]
    if not raw and values["tcp_offset"][:, :3].any():
        what = f"torques of {FORCE} are taken about the flange, as on e-Series; CB3 gives them about the TCP"
        return [warning("torque-reference-assumed", what)]
    return []


FORMAT = Format(
    name="UR real-time record",
    description="UR real-time record (`record.py` of RTDE), recognised by its header",
    read_table=read_ur,
    is_header=is_ur,
)
"""Columns of a robot controller, in any file with named columns."""

"""A log's path, a table or arrays in memory -> Recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.recording import Recording
from hefting.logs import read_log
from hefting.logs.table_file import reader_of

FORMS = (
    "give the path of a log, a dictionary of columns, a data frame, a structured array, "
    "a Recording, or `time`, `orientation`, `position`, `wrench`"
)
"""Forms of a recording that are accepted, as advice in errors."""


def as_recording(
    source: Any = None,
    *,
    column_map: str | Path | None = None,
    time: ArrayLike | None = None,
    position: ArrayLike | None = None,
    orientation: Any = None,
    pose: ArrayLike | None = None,
    wrench: ArrayLike | None = None,
    wrench_time: ArrayLike | None = None,
    wrench_needed: bool = True,
    **streams: ArrayLike | None,
) -> Recording:
    """Recording from a path, a table in memory, or arrays.

    Parameters
    ----------
    source : path, mapping, data frame, structured array or Recording, optional
        A log's path; columns of the canonical names (`hefting.read_log`) in a
        dictionary, a data frame of pandas or polars, a PyArrow table or a structured
        array, where NaN and null mean "not measured then"; or a dictionary of the
        arrays below by their names, or by others that tell what they hold, such as
        ``{"t": (K,), "tcp_pose": (K, 4, 4), "ft": (K, 6)}``. A `Recording` is returned
        as it is.
    column_map : path, optional
        TOML file that says which columns hold what; see `hefting.logs.column_map`.
    time : (K,), optional
        [s], increasing; dates count from the first. Without it each sample is a static
        pose.
    position : (K, 3), optional
        Of the sensor origin in the world [m]. Without it only gravity is modelled.
    orientation : (K, 4), (K, 3, 3) or scipy Rotation
        Of the sensor in the world: quaternions x, y, z, w, or matrices that turn
        sensor axes into world axes.
    pose : (K, 4, 4) or (K, 7), optional
        Both at once: matrices, or x, y, z [m] and a quaternion x, y, z, w.
    wrench : (N, 6)
        Force [N], then torque [N m], in sensor axes about the sensor origin; or `force`
        and `torque` (N, 3) in its place.
    wrench_time : (N,), optional
        Of the wrench [s], on the clock of `time`, where it has times of its own.
    wrench_needed : bool
        Whether a recording without a wrench is refused.
    **streams : (K, d), optional
        Other streams of a `Recording`, such as ``gyroscope``, at `time`.

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        For what cannot be read without guessing, naming row or sample, which are
        counted from 0 in memory.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.arange(0.0, 2.0, 0.01)
    >>> pose = np.tile(np.eye(4), (200, 1, 1))
    >>> recording = hefting.as_recording(time=time, pose=pose, wrench=np.ones((200, 6)))
    >>> recording.duration
    1.99
    """
    arrays = {
        "time": time,
        "position": position,
        "orientation": orientation,
        "pose": pose,
        "wrench": wrench,
        "wrench_time": wrench_time,
    } | streams
    given = {name: value for name, value in arrays.items() if value is not None}
    if source is None:
        if not given:
            raise InputError("no recording is given", fix=FORMS)
        from hefting.logs.arrays import recording_from_arrays

        recording = recording_from_arrays(given)
    elif given:
        what = f"both a recording and `{next(iter(given))}` are given"
        raise InputError(what, fix="give one of them")
    else:
        recording = _from_source(source, column_map, wrench_needed)
    if wrench_needed and not recording.has("wrench"):
        raise InputError(
            "there is no wrench", recording.source, "give an array wrench (N, 6)"
        )
    return recording


def _from_source(
    source: Any, column_map: str | Path | None, wrench_needed: bool
) -> Recording:
    if isinstance(source, Recording):
        return source
    if isinstance(source, str | Path):
        return read_log(source, column_map, wrench_needed=wrench_needed)
    from hefting.logs.memory_table import MemoryTable

    table = MemoryTable.of(source)
    if table is None:
        shape = getattr(source, "shape", None)
        what = f"a value of type {type(source).__name__} is not a recording"
        if shape is not None:
            what = f"an array {shape} without column names is not a recording"
        raise InputError(what, fix=FORMS)
    if column_map is not None:
        from hefting.logs.column_map import load_map
        from hefting.logs.mapped import read_mapped

        chosen = load_map(column_map, wrench_needed)
        return read_mapped(table, chosen, wrench_needed)
    return reader_of(table, wrench_needed)(table)

"""Arrays in memory -> Recording: times, poses in any usual form, wrenches."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any, Literal

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.recording import COLUMNS, Recording, Stream, column_names
from hefting.core.spatial import Array, Mask, plain
from hefting.logs.gaps import FEW, without_repeats
from hefting.logs.orientations import no_rotations, quaternions
from hefting.logs.static_poses import warn_about_static, without_unit
from hefting.logs.table import in_seconds

ARRAYS = ("time", "wrench_time", "pose", *COLUMNS, "force", "torque")
"""Names under which arrays are given."""
SOURCE = "arrays"
"""What messages call a recording made of arrays."""
LARGEST_NORM_ERROR = 1e-2
"""Largest difference of a quaternion's norm from one, as in `Recording`."""
OWN_TIMES = "leave those samples out; `wrench_time` gives the wrench times of its own"


def recording_from_arrays(
    given: Mapping[str, Any], *, blanks: Literal["refused", "left out"] = "refused"
) -> Recording:
    """Recording in arrays by name, each a name of `ARRAYS`; see `as_recording`. Samples
    that hold NaN or are masked, as in a table, are `blanks`.

    Raises `InputError`, naming array and sample, for shapes that do not fit, values
    that are not finite, and what `Recording` refuses. Samples are counted from 0.
    """
    arrays = {name: value for name, value in given.items() if value is not None}
    for name in arrays:
        if name not in ARRAYS:
            fix = f"use {', '.join(ARRAYS)}"
            raise InputError(
                f"no array is called '{name}'{nearest(name, ARRAYS)}", fix=fix
            )
    arrays = _with_whole_wrench(arrays)
    times = _times(arrays)
    arrays, blank = _filled(arrays) if blanks == "left out" else (arrays, {})
    values = _streams(arrays)
    if not {"orientation", "joint_positions"} & set(values):
        fix = "give an array orientation (K, 4), or pose (K, 4, 4)"
        raise InputError("there is no orientation", SOURCE, fix)
    streams = {}
    for name, rows in values.items():
        own = name == "wrench" and "wrench_time" in times
        time = times.get("wrench_time" if own else "time")
        if time is not None and name in blank and time.shape == blank[name].shape:
            time = np.where(blank[name], 0.0, time)  # of rows that are left out
        streams[name] = _stream(name, rows, time, "wrench_time" if own else "time")
    if "time" not in times:  # a static pose needs a sample of every stream
        _check_lengths(streams)
        blank = dict.fromkeys(streams, np.any([*blank.values()], axis=0))
    for name, samples in streams.items():
        if name in blank and blank[name].any():
            streams[name] = samples[~blank[name]]
    if "time" not in times:
        _check_lengths(streams)
        return warn_about_static(Recording(streams, static=True, source=SOURCE))
    streams, repeats = without_repeats(streams)
    streams, about_time = in_seconds(streams, SOURCE)
    recorded = Recording(streams, source=SOURCE, warnings=repeats + about_time)
    return without_unit(recorded)


def _with_whole_wrench(arrays: dict[str, Any]) -> dict[str, Any]:
    """The arrays with force and torque (K, 3) as one wrench."""
    halves = {name: arrays[name] for name in ("force", "torque") if name in arrays}
    if not halves:
        return arrays
    if len(halves) == 1 or "wrench" in arrays:
        what = f"{next(iter(halves))} is given {'beside wrench' if 'wrench' in arrays else 'alone'}"
        raise InputError(what, SOURCE, "give force and torque, or wrench")
    force, torque = (numbers(values, name) for name, values in halves.items())
    if force.shape != torque.shape or force.ndim != 2 or force.shape[1] != 3:
        what = f"force has shape {force.shape}, torque {torque.shape}"
        raise InputError(what, SOURCE, "give (K, 3) of each")
    rest = {name: values for name, values in arrays.items() if name not in halves}
    return rest | {"wrench": np.hstack((force, torque))}


def unit_quaternions(orientation: Any) -> Array:
    """Orientations in any usual form as quaternions (K, 4) x, y, z, w.

    Parameters
    ----------
    orientation : (K, 4) quaternions x, y, z, w, (K, 3, 3) rotation matrices from sensor
        to world axes, or a scipy ``Rotation`` of K rotations, or a list of such.

    Raises `InputError` for another shape, and matrices that are no rotations.
    """
    if hasattr(orientation, "as_quat"):
        return np.atleast_2d(np.array(orientation.as_quat(), dtype=float))
    values = numbers(orientation, "orientation")
    if values.ndim == 3 and values.shape[1:] == (3, 3):
        return _from_matrices(values, "orientation")
    if values.ndim != 2 or values.shape[1] != 4:
        what = f"orientation has shape {values.shape}"
        fix = "give quaternions (K, 4) x, y, z, w, matrices (K, 3, 3) or a Rotation"
        raise InputError(what, fix=fix)
    _check_unit(values)
    return values


def position_and_orientation(pose: Any) -> tuple[Array, Array]:
    """Positions (K, 3) [m] and quaternions (K, 4) of poses (K, 4, 4) of the sensor in
    the world, or (K, 7): x, y, z [m], quaternion x, y, z, w.

    Raises `InputError` for another shape, and matrices that are no rigid motions.
    """
    values = numbers(pose, "pose")
    if values.ndim == 2 and values.shape[1] == 7:
        _check_unit(values[:, 3:])
        return values[:, :3], values[:, 3:]
    if values.ndim != 3 or values.shape[1:] != (4, 4):
        what = f"pose has shape {values.shape}"
        fix = "give matrices (K, 4, 4), or x, y, z, qx, qy, qz, qw (K, 7)"
        raise InputError(what, fix=fix)
    _check_finite("pose", values)
    wrong = (np.abs(values[:, 3] - (0.0, 0.0, 0.0, 1.0)) > 1e-6).any(axis=1)
    if wrong.any():
        what = f"the last row of pose[{np.argmax(wrong)}] is not 0, 0, 0, 1"
        raise InputError(what, SOURCE, "are its matrices transposed?")
    return values[:, :3, 3], _from_matrices(values[:, :3, :3], "pose")


def numbers(values: Any, name: str) -> Array:
    """`values` as an array of floats; `InputError`, naming it, for what holds none."""
    try:
        if isinstance(values, np.ma.MaskedArray):
            values = np.ma.asarray(values, dtype=float).filled(np.nan)
        array = np.asarray(plain(values))
        if array.dtype.kind not in "iufbO":
            raise TypeError(f"they are {array.dtype}")
        return array.astype(float)
    except (TypeError, ValueError, RuntimeError) as error:  # torch raises the last
        reason = str(error)[:100]
        raise InputError(f"{name} is not an array of numbers ({reason})") from error


def _filled(arrays: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Mask]]:
    """The arrays with another sample in place of each that holds NaN, and by stream
    which samples (K,) these are."""
    filled, blank = dict(arrays), {}
    for name in arrays.keys() & {"pose", *COLUMNS}:
        if hasattr(arrays[name], "as_quat"):
            continue
        values = numbers(arrays[name], name)
        if values.ndim < 2 or not values.size:
            continue
        lacks: Mask = np.isnan(values).reshape(len(values), -1)
        nan = lacks.any(axis=1)
        if not nan.any() or nan.all():
            continue
        gaps = int((nan & ~lacks.all(axis=1)).sum())
        if gaps > FEW * len(values):
            what = (
                f"{gaps} of {len(values)} samples of {name} lack some of their numbers"
            )
            fix = "give NaN throughout where nothing was measured"
            raise InputError(what, SOURCE, fix)
        filled[name] = np.array(values)
        filled[name][nan] = values[np.argmin(nan)]
        for stream in ("position", "orientation") if name == "pose" else (name,):
            blank[stream] = nan
    return filled, blank


def _streams(arrays: Mapping[str, Any]) -> dict[str, Array]:
    """Values of each stream that the arrays hold."""
    values: dict[str, Array] = {}
    if "pose" in arrays:
        for name in ("position", "orientation"):
            if name in arrays:
                raise InputError(
                    f"pose and {name} are both given", fix="give one of them"
                )
        values["position"], values["orientation"] = position_and_orientation(
            arrays["pose"]
        )
    for name in arrays.keys() & COLUMNS.keys():
        if name == "orientation":
            values[name] = unit_quaternions(arrays[name])
        else:
            values[name] = _rows(arrays[name], name)
    return {name: values[name] for name in COLUMNS if name in values}


def _rows(values: Any, name: str) -> Array:
    """`values` of a stream as an array (K, d) of its width."""
    array = numbers(values, name)
    width = len(column_names(name, array.shape[1] if array.ndim == 2 else 1))
    if array.ndim == 2 and array.shape[1] == width:
        return array
    turned = array.ndim == 2 and array.shape[0] == width
    fix = f"turn it, {name}.T" if turned else f"give {width} numbers a sample"
    raise InputError(f"{name} has shape {array.shape}, not (K, {width})", SOURCE, fix)


def _stream(name: str, values: Array, time: Array | None, clock: str) -> Stream:
    """A stream whose samples count from 0; `InputError` where it does not fit its
    times, is empty, or holds what is no number."""
    rows = np.arange(len(values))
    time = rows.astype(float) if time is None else time
    if len(time) != len(values):
        what = f"{name} has {len(values)} samples, but {clock} has {len(time)}"
        fix = None
        if name == "wrench" and clock == "time":
            fix = "give `wrench_time` where the wrench has times of its own"
        raise InputError(what, SOURCE, fix)
    if not len(values):
        raise InputError(f"{name} is empty", SOURCE)
    _check_finite(clock, time)
    _check_finite(name, values)
    return Stream(time, values, rows)


def _check_finite(name: str, values: Array) -> None:
    """`InputError`, naming the first value that is not finite."""
    if np.isfinite(values).all():
        return
    at = np.argwhere(~np.isfinite(values))[0].tolist()
    value = values[tuple(at)]
    place = ", ".join(map(str, at))
    raise InputError(f"{name}[{place}] is {value}", SOURCE, OWN_TIMES)


def _check_unit(quaternions: Array) -> None:
    """`InputError`, naming the first quaternion (K, 4) that is not of unit length."""
    with np.errstate(over="ignore"):
        norm = np.linalg.norm(quaternions, axis=1)
    off = np.abs(norm - 1.0) > LARGEST_NORM_ERROR
    if off.any():
        k = int(np.argmax(off))
        what = f"the quaternion of sample {k} has norm {norm[k]:.4g}, not 1"
        raise InputError(what, SOURCE, "give unit quaternions x, y, z, w")


def _check_lengths(streams: Mapping[str, Stream]) -> None:
    """`InputError` unless all streams of static poses have equally many samples."""
    (first, count), *others = ((name, len(s)) for name, s in streams.items())
    for name, other in others:
        if other != count:
            what = f"{name} has {other} samples, but {first} has {count}"
            raise InputError(what, SOURCE, "give `time`, or as many of each")


def _from_matrices(matrices: Array, name: str) -> Array:
    """Quaternions (K, 4) of rotation matrices (K, 3, 3) in the array `name`."""
    _check_finite(name, matrices)
    wrong = no_rotations(matrices)
    if wrong.any():
        what = f"{name}[{np.argmax(wrong)}] is no rotation matrix"
        raise InputError(what, SOURCE, "its columns are unit vectors at right angles")
    return quaternions(matrices.reshape(-1, 9), "matrix")


def _times(arrays: Mapping[str, Any]) -> dict[str, Array]:
    """The given times (K,) [s] by name; dates count from the earliest first one."""
    raw = {
        name: _dates(np.asarray(arrays[name]))
        for name in ("time", "wrench_time")
        if name in arrays
    }
    if "wrench_time" in raw and "time" not in raw:
        raise InputError("wrench_time is given without time", SOURCE, "give both")
    if "wrench_time" in raw and "wrench" not in arrays:
        raise InputError("wrench_time is given without wrench", SOURCE, "give both")
    for name, time in raw.items():
        if time.ndim != 1:
            raise InputError(f"{name} has shape {time.shape}, not (K,)", SOURCE)
    dates = [time.dtype.kind == "M" for time in raw.values()]
    if any(dates):
        if not all(dates):
            raise InputError("one of time and wrench_time is a date", SOURCE)
        begin = min(time[0] for time in raw.values() if len(time))
        return {name: elapsed(time - begin) for name, time in raw.items()}
    return {
        name: elapsed(time) if time.dtype.kind == "m" else numbers(time, name)
        for name, time in raw.items()
    }


def _dates(time: np.ndarray) -> np.ndarray:
    """Times (K,), with Python's dates as NumPy's, in UTC."""
    if time.dtype != object or not all(isinstance(t, datetime) for t in time.flat):
        return time
    naive = [t.astimezone(UTC).replace(tzinfo=None) if t.tzinfo else t for t in time]
    return np.array(naive, dtype="datetime64[us]")


def elapsed(durations: np.ndarray) -> Array:
    """Durations in any unit of time as seconds; NaT becomes NaN."""
    return durations / np.timedelta64(1, "s")

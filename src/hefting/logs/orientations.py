"""Forms of an orientation in a log -> unit quaternions x, y, z, w; the form of three
angles, found from their numbers; and the sensor in the logged frame: poses of a flange,
or of another frame fixed to the sensor, become those of the sensor."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.core.quantity import turned_about
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import (
    Array,
    Mask,
    check_pose,
    frozen,
    pose_matrix,
    rotation_matrices,
)

FORMS = {"xyzw": 4, "wxyz": 4, "rotation-vector": 3, "rpy": 3, "euler": 3, "matrix": 9}
"""Number of columns of each form. ``rpy``: roll, pitch, yaw about the fixed axes x, y, z;
``euler``: in a given order; ``matrix``: row by row."""

ANGULAR = ("rotation-vector", "rpy", "euler")
"""Forms that are angles, in rad or deg."""

POSE_FORMS = {"matrix4": 16, "matrix4-columns": 16}
"""Number of columns of each form of a pose: a homogeneous matrix row by row, or column by
column (Franka's ``O_T_EE``)."""

ORTHOGONAL = 1e-2
"""Largest entry of R R' - 1 that is taken for rounding."""


def is_euler_order(order: object) -> bool:
    """Whether `order` is three axes, none of them the same as the next: moving axes in
    capitals, or fixed ones in small letters."""
    return (
        isinstance(order, str)
        and bool(re.fullmatch(r"(?:[xyz]{3}|[XYZ]{3})", order))
        and order[0] != order[1] != order[2]
    )


def quaternions(values: Array, form: str, order: str = "") -> Array:
    """Unit quaternions (N, 4) x, y, z, w, sensor in world, of orientations (N, d) in a
    form of `FORMS` [rad].

    `order` is that of the Euler angles and of their columns. Matrices must be rotations.
    """
    from scipy.spatial.transform import Rotation

    if form == "xyzw":
        return values
    if form == "wxyz":
        return values[:, [1, 2, 3, 0]]
    makers: dict[str, Callable[[Array], Rotation]] = {
        "rotation-vector": Rotation.from_rotvec,
        "rpy": lambda angles: Rotation.from_euler("xyz", angles),
        "euler": lambda angles: Rotation.from_euler(order, angles),
        "matrix": lambda entries: Rotation.from_matrix(entries.reshape(-1, 3, 3)),
    }
    return makers[form](np.array(values)).as_quat()  # scipy takes no read-only arrays


def check_matrices(stream: Stream, source: str, labels: Sequence[str]) -> None:
    """`InputError`, naming the first row, unless the values (N, 9) are rotation
    matrices row by row."""
    wrong = no_rotations(stream.values.reshape(-1, 3, 3))
    if wrong.any():
        where = f"{source}, row {stream.rows[np.argmax(wrong)]}, columns {labels[0]}..{labels[-1]}"
        raise InputError(
            "this is no rotation matrix", where, "check the order of the columns"
        )


def no_rotations(matrices: Array) -> Mask:
    """Mask (N,) of matrices (N, 3, 3) that are no rotations, up to rounding."""
    with np.errstate(over="ignore", invalid="ignore"):
        products = np.matmul(matrices, matrices.transpose(0, 2, 1))
        error = np.abs(products - np.eye(3)).max(axis=(1, 2))
        return ~(error < ORTHOGONAL) | (np.linalg.det(matrices) < 0)


def split_pose(
    stream: Stream, form: str, source: str, labels: Sequence[str]
) -> tuple[Array, Array]:
    """Positions (N, 3) and rotation matrices row by row (N, 9) of homogeneous matrices
    (N, 16) in a form of `POSE_FORMS`. `InputError`, naming the first row whose last
    line is not 0 0 0 1."""
    matrices = stream.values.reshape(-1, 4, 4)
    if form == "matrix4-columns":
        matrices = matrices.transpose(0, 2, 1)
    wrong = (np.abs(matrices[:, 3] - (0.0, 0.0, 0.0, 1.0)) > 1e-6).any(axis=1)
    if wrong.any():
        other = "matrix4" if form == "matrix4-columns" else "matrix4-columns"
        where = f"{source}, row {stream.rows[np.argmax(wrong)]}, columns {labels[0]}..{labels[-1]}"
        fix = f'check the columns, or give form = "{other}"'
        raise InputError(
            "the last line of the homogeneous matrix is not 0 0 0 1", where, fix
        )
    return matrices[:, :3, 3].copy(), matrices[:, :3, :3].reshape(-1, 9)


def in_sensor_axes(recording: Recording) -> Array:
    """Wrenches (N, 6) of a recording turned from world axes into sensor axes; their
    reference point, the sensor origin, stays.

    Orientations are interpolated (`orientations_at`); wrenches before the first and after
    the last one are not used later. A static pose needs an orientation in its row, else
    `InputError`.
    """
    wrench, orientation = recording["wrench"], recording["orientation"]
    if not recording.static:
        turns = orientations_at(orientation, wrench.time)
        return rotate_into_sensor(turns.as_matrix(), wrench.values)
    at = np.searchsorted(orientation.rows, wrench.rows).clip(max=len(orientation) - 1)
    apart = orientation.rows[at] != wrench.rows
    if apart.any():
        what = "the wrench is in world axes, but there is no orientation in its row"
        where = f"{recording.source}, row {wrench.rows[np.argmax(apart)]}"
        raise InputError(what, where, "record both, or the wrench in sensor axes")
    return rotate_into_sensor(rotation_matrices(orientation.values[at]), wrench.values)


def orientations_at(orientation: Stream, time: Array) -> Any:
    """Orientations at times (K,) [s], a ``Rotation``: interpolated on great circles, and
    constant before the first and after the last sample."""
    from scipy.spatial.transform import Rotation, Slerp

    all_of = Rotation.from_quat(np.array(orientation.values))
    if np.array_equal(time, orientation.time):
        return all_of
    if len(orientation) == 1:
        return Rotation.from_quat(np.repeat(orientation.values, len(time), axis=0))
    inside = np.clip(time, orientation.time[0], orientation.time[-1])
    return Slerp(np.array(orientation.time), all_of)(inside)


def rotate_into_sensor(rotations: Array, wrenches: Array) -> Array:
    """Wrenches (N, 6) multiplied by the transposes of `rotations` (N, 3, 3), which turn
    sensor axes into those of the given wrenches."""
    return np.einsum("nji,nkj->nki", rotations, wrenches.reshape(-1, 2, 3)).reshape(
        -1, 6
    )


JUMP = 0.5
"""[rad] Turn from one row to the next that recordings of slow arms do not have."""
SMOOTHER = 0.2
"""Largest ratio of the largest turns by the right and by the wrong form; it is relative,
as both jump where messages are lost."""


def form_of_angles(angles: Array, *, in_degrees: bool = False) -> tuple[str, str]:
    """Form of the angles (N, 3) [rad] of successive poses, and a reason: a rotation
    vector, as UR writes in radians, or "rpy", as makes write that log degrees; the other
    where that one would jump."""
    known = angles[np.isfinite(angles).all(axis=1)]
    forms = ["rotation-vector", "rpy"]
    usual, other = reversed(forms) if in_degrees else forms
    wide, narrow = (_largest_turn(known, form) for form in (usual, other))
    if wide > JUMP and narrow < SMOOTHER * wide:
        return other, f"as {usual} it would jump"
    return usual, "in degrees" if in_degrees else ""


def _largest_turn(angles: Array, form: str) -> float:
    """[rad] Largest turn from one row to the next."""
    q = quaternions(angles, form)
    cosine = np.abs(np.einsum("ki,ki->k", q[1:], q[:-1]))
    return float(2.0 * np.arccos(np.clip(cosine, 0.0, 1.0)).max(initial=0.0))


SENSOR_KEYS = ("sensor_pose_in_log", "sensor_turned")
"""Keys of a column map that say where the sensor is in the logged frame."""
MOTION_OF_A_POINT = ("linear_velocity", "linear_acceleration")
"""Streams of the moving frame's origin, in world axes."""
POSES_ASSUMED = "pose-frame-assumed"
"""Code of a reader's message on poses that may be of another frame than the sensor's."""
FARTHEST_SENSOR = 3.0
"""[m] Largest distance from the logged frame; a larger one is in another unit."""


def with_sensor_pose(recording: Recording, pose: ArrayLike) -> Recording:
    """The recording with the poses of the sensor in place of the logged frame's.

    Parameters
    ----------
    recording : Recording
        With an orientation. Wrench, gyroscope and accelerometer are in sensor axes
        already, and stay.
    pose : ArrayLike
        (4, 4) constant pose of the sensor in the logged frame [m].

    Returns
    -------
    Recording
        Without logged linear velocities and accelerations where the sensor is not at
        the frame's origin: they are found from the poses then.

    Raises
    ------
    InputError
        If the pose is no rigid motion, or the recording has no orientation.

    Examples
    --------
    >>> flange = hefting.read_log("demo/log.csv")  # say that its poses are the flange's
    >>> pose = hefting.parse_pose("0,0,0.03,0,0,0,1")  # of the sensor in the flange
    >>> sensor = hefting.with_sensor_pose(flange, pose)
    >>> identified = hefting.identify(sensor)
    """
    matrix = check_pose(pose)
    arm = np.array(matrix[:3, 3])  # old versions of scipy need a writable array
    far = float(np.linalg.norm(arm))
    if far > FARTHEST_SENSOR:
        what = f"the sensor is {far:.3g} m from the logged frame"
        raise InputError(what, fix="give its pose in metres, or as in 40mm")
    orientation = recording["orientation"]
    from scipy.spatial.transform import Rotation

    logged = Rotation.from_quat(np.array(orientation.values))
    sensor = logged * Rotation.from_matrix(matrix[:3, :3])
    streams = dict(recording.streams)
    streams["orientation"] = replace(orientation, values=sensor.as_quat())
    if arm.any():
        for name in MOTION_OF_A_POINT:
            streams.pop(name, None)
        if "position" in streams:
            position = streams["position"]
            axes = orientations_at(orientation, position.time)
            streams["position"] = replace(
                position, values=position.values + axes.apply(arm)
            )
    kept = tuple(own for own in recording.warnings if codes((own,)) != {POSES_ASSUMED})
    return replace(recording, streams=streams, sensor_pose=None, warnings=kept)


def with_given_sensor_pose(recording: Recording, pose: ArrayLike) -> Recording:
    """`with_sensor_pose` for a pose that the user gave, which the recording keeps so that
    messages can propose another one."""
    placed = with_sensor_pose(recording, pose)
    return replace(placed, sensor_pose=frozen(pose))


def mapped_sensor_pose(content: Mapping[str, Any], path: str | Path) -> Array | None:
    """Pose (4, 4) of the sensor in the logged frame [m] in a column map's content, if
    any; `InputError`, naming the map's `path` and the key, for an invalid one."""
    given = [key for key in SENSOR_KEYS if key in content]
    if not given:
        return None
    where = f"{path}, key {given[0]}"
    if len(given) > 1:
        raise InputError(f"is given beside {given[1]}", where, "give one of them")
    value = content[given[0]]
    try:
        if given[0] == "sensor_turned":
            return turned_about(value)
        return pose_matrix(value)
    except (InputError, TypeError, ValueError, OverflowError):
        fix = 'give [x, y, z, qx, qy, qz, qw], or sensor_turned = "z:45"'
        raise InputError(f"{str(value)[:40]} is no pose", where, fix) from None

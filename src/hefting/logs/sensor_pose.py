"""The sensor in the logged frame: poses of a flange, or of another frame fixed to the
sensor, become those of the sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.core.quantity import turned_about
from hefting.core.recording import Recording
from hefting.core.spatial import Array, check_pose, frozen, pose_matrix
from hefting.logs.orientations import orientations_at

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

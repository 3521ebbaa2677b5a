"""The recording that is meant: a log, with poses by a robot's kinematics, of the
sensor."""

from typing import TYPE_CHECKING, Any

from hefting.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hefting.core.recording import Recording


def recording_of(a: Any, path: str, wrench_needed: bool = True) -> "Recording":
    """The log at `path`, with poses by a URDF's kinematics where one is given, and of
    the sensor where it is said to be elsewhere. `InputError` as `hefting.read_log`."""
    return placed(a, logged(a, path, wrench_needed), path)


def placed(a: Any, recording: "Recording", path: str) -> "Recording":
    """A recording as logged at `path`, with poses by a URDF's kinematics where one is
    given, and of the sensor."""
    if a.urdf:
        recording = _posed(a, recording)
    elif a.sensor_frame and "sensor_frame" not in _own_options(path):
        raise InputError("--sensor-frame is for bags and for --urdf", where=path)
    pose, turned = a.sensor_pose_in_log, a.sensor_turned
    if pose is None and turned is None:
        return recording
    if pose is not None and turned is not None:
        raise InputError(
            "is given beside --sensor-pose-in-log",
            "--sensor-turned",
            "give one of them",
        )
    from hefting.logs.sensor_pose import sensor_turned, with_given_sensor_pose
    from hefting.shapes import parse_pose

    if pose is not None:
        return with_given_sensor_pose(recording, parse_pose(pose))
    return with_given_sensor_pose(recording, sensor_turned(str(turned)))


def logged(a: Any, path: str, wrench_needed: bool) -> "Recording":
    """The recording as logged."""
    from hefting.logs import read_log
    from hefting.logs.registry import all_options

    own = _own_options(path)
    options = {name: getattr(a, name) for name in all_options()}
    if "sensor_frame" not in own:
        del options["sensor_frame"]  # names a link of the URDF then
    if a.urdf and "pose_topic" in own:
        # the URDF gives the poses
        options["pose_topic"] = options["pose_topic"] or "none"
    options["poses"] = getattr(a, "poses", None)
    return read_log(path, column_map=a.map, wrench_needed=wrench_needed, **options)


def _own_options(path: str) -> "Mapping[str, tuple[str, str]]":
    """Options that the format of a log has."""
    from hefting.logs.registry import find_format

    found = find_format(path)
    return found.options if found else {}


def _posed(a: Any, recording: "Recording") -> "Recording":
    """A recording of joint angles with poses by the URDF that is given."""
    if not a.sensor_frame:
        raise InputError(
            "which link holds the sensor?", a.urdf, "give --sensor-frame NAME"
        )
    from hefting.robots import Robot, with_poses

    return with_poses(recording, Robot.from_urdf(a.urdf, a.sensor_frame))

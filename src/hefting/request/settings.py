"""The library's values for a request: the recording with the poses of the sensor, how
it is read, the object's shape, and the hyperparameters of a method."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from hefting.core.errors import InputError
from hefting.core.quantity import numbers, quantities

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from hefting.core.accuracy import Accuracy
    from hefting.core.estimate import Estimate
    from hefting.core.gravity import Gravity
    from hefting.core.recording import Recording
    from hefting.core.sensor_accuracy import SensorAccuracy
    from hefting.core.spatial import Array
    from hefting.robots import Robot
    from hefting.shapes import Shape


WEAKEST_GRAVITY, STRONGEST_GRAVITY = 1.5, 30.0
"""[m/s²] Range of gravity that a command takes: the Moon has 1.6, Jupiter 25."""


def gravity_of(a: Any) -> "Gravity":
    """The given gravity, or that at the given latitude and altitude, or that of unknown
    places on the Earth."""
    from hefting.core.gravity import ON_EARTH, Gravity

    text, latitude = a.gravity, a.latitude
    if latitude is None and a.altitude is not None:
        raise InputError("what latitude?", "--altitude", "give --latitude DEG as well")
    if text not in (None, "estimate"):
        if latitude is not None:
            what = "gravity is given, so its size does not follow from a latitude"
            raise InputError(what, "--latitude", "leave one of them out")
        given = Gravity.of(numbers(text, 3, "--gravity"))
        size = sum(x * x for x in given.vector) ** 0.5
        if not WEAKEST_GRAVITY <= size <= STRONGEST_GRAVITY:
            what = f"of {size:.3g} m/s² is that of no place where robots hold things"
            fix = "give it in m/s², on the Earth as 0,0,-9.81"
            raise InputError(what, "--gravity", fix)
        return given
    if latitude is None:
        found = ON_EARTH
    else:
        with _naming("--latitude"):
            found = Gravity.at(latitude)
        with _naming("--altitude"):
            found = Gravity.at(latitude, a.altitude)
    return found if text is None else found.in_unknown_direction


@contextmanager
def _naming(option: str) -> Iterator[None]:
    """Make an `InputError` within the block name the option."""
    try:
        yield
    except InputError as error:
        raise InputError(error.what, option, error.fix) from None


def sensor_accuracy_of(a: Any) -> "SensorAccuracy | None":
    """The given accuracy of the sensor; `InputError` names the option."""
    from hefting.core.sensor_accuracy import SensorAccuracy

    with _naming("--sensor-accuracy"):
        return SensorAccuracy.of(a.sensor_accuracy)


def reading_of(a: Any) -> dict[str, Any]:
    """Arguments of `hefting.identify` for reading recordings."""
    from hefting.ingest.sign_and_bias import bias_of
    from hefting.ingest.tool import load_tool

    return {
        "gravity": gravity_of(a),
        "wrench": a.wrench,
        "bias": bias_of(a.bias),
        "motion": a.motion,
        "start": a.start,
        "duration": a.duration,
        "tool": load_tool(a.tool) if a.tool else None,
    }


def hyperparameters_of(a: Any) -> dict[str, Any]:
    """The given hyperparameters, by their names in the estimators."""
    from hefting.core.quantity import MassReading
    from hefting.estimators import options

    settings = {
        name: getattr(a, name) for name in options() if getattr(a, name) is not None
    }
    if a.pose_std is not None:
        settings["pose_std"] = quantities(
            a.pose_std, ("length", "angle"), "--pose-std", "5mm,5deg"
        )
    if a.shape_std is not None:
        settings["shape_std"] = quantities(
            a.shape_std, ("share",), "--shape-std", "20%"
        )[0]
        if settings["shape_std"] > 1.0:
            raise InputError(
                f"'{a.shape_std}' is more than all of the shape",
                "--shape-std",
                "as in 20%",
            )
    if a.sensor_accuracy is not None:
        settings["sensor_accuracy"] = sensor_accuracy_of(a)
    if a.mass is not None:
        with _naming("--mass"):
            settings["mass"] = MassReading.of(a.mass)
    if a.until is not None:
        settings["until"] = accuracy_of(a.until)
    return settings


def accuracy_of(text: str) -> "Accuracy":
    """The accuracy that `--until` asks for; `InputError` names the option."""
    from hefting.core.accuracy import Accuracy

    with _naming("--until"):
        return Accuracy.parse(text)


def shape_of(a: Any) -> "Shape | None":
    """The given shape, or None. `InputError` as `hefting.load_shape`."""
    if a.hull and (a.shape is None or a.shape.lower().startswith("box:")):
        raise InputError("there is no shape", "--hull", "give --shape FILE")
    from hefting.shapes import load_shape

    pose = pose_of(a.object_pose)
    if a.box is None and a.shape is None:
        return None
    if a.box is not None:
        return _box(a, pose)
    return load_shape(a.shape, a.unit, pose, a.points, a.points_per_cm3, a.hull)


def pose_of(text: str | None) -> "Array | None":
    """The given pose (4, 4) [m], or None. `InputError` as `hefting.parse_pose`."""
    if text is None:
        return None
    from hefting.shapes import parse_pose

    return parse_pose(text)


def in_object_frame(
    estimate: "Estimate", pose: str | None = None, pose_std: str | None = None
) -> "Estimate":
    """The estimate in the frame of the object's shape: by its given pose in the sensor
    frame, else that with which it was identified. `InputError` where neither is known."""
    from hefting.identification.frames import in_frame

    std = quantities(
        pose_std or "0m,0rad", ("length", "angle"), "--pose-std", "5mm,5deg"
    )
    return in_frame(estimate, pose_of(pose), pose_std=std)


ABOUT_SHAPES = (
    *("unit", "object_pose", "pose_std", "shape_std", "points", "points_per_cm3"),
)
"""Options that say something of a shape that others give."""


def require_shape(a: Any) -> None:
    """`InputError` where options of a shape are given without a shape."""
    if a.shape is None and getattr(a, "box", None) is None:
        fix = "give --shape FILE or --box X,Y,Z, or leave it out"
        refuse_given(a, ABOUT_SHAPES, "there is no shape", fix)


def refuse_given(a: Any, names: "Iterable[str]", what: str, fix: str) -> None:
    """`InputError` of the first of the named options that is given."""
    for name in names:
        if getattr(a, name, None) is not None:
            raise InputError(what, "--" + name.replace("_", "-"), fix)


def _box(a: Any, pose: "Array | None") -> "Shape":
    """The box of the given sides, centred at the origin of a pose."""
    from hefting.shapes import Shape

    for option, given in (("--shape", a.shape), ("--unit", a.unit)):
        if given is not None:
            what, fix = "is given beside --box", "leave one of them out"
            raise InputError(what, option, fix)
    in_metres = re.sub(r"(?<=[\d.])\s*(?=,|$)", "m", a.box)
    try:
        sides = quantities(in_metres, ("length",) * 3, "--box", "")
    except InputError:
        sides = (0.0,)
    if not min(sides) > 0.0:
        what, fix = f"'{a.box}' is not three lengths", "as in 0.1,0.2,0.3 in metres"
        raise InputError(what, "--box", fix)
    low_to_high = [sign * side / 2 for side in sides for sign in (-1, 1)]
    return Shape.from_box(
        *low_to_high, points=a.points, points_per_cm3=a.points_per_cm3, pose=pose
    )


def recording_of(a: Any, path: str, wrench_needed: bool = True) -> "Recording":
    """The recording at `path`, with the poses of the sensor (`placed`). `InputError` as
    `hefting.read_log`."""
    return placed(a, logged(a, path, wrench_needed), path)


def placed(a: Any, recording: "Recording", path: str) -> "Recording":
    """A recording as logged at `path`, with poses by a URDF's kinematics where one is
    given, and moved from the logged frame to the sensor where that is elsewhere."""
    if a.urdf:
        from hefting.robots import with_poses

        recording = with_poses(recording, robot_of(a))
    elif a.sensor_frame and "sensor_frame" not in _own_options(path):
        raise InputError("--sensor-frame is for bags and for --urdf", where=path)
    pose = sensor_pose_of(a)
    if pose is None:
        return recording
    from hefting.logs.orientations import with_given_sensor_pose

    return with_given_sensor_pose(recording, pose)


def sensor_pose_of(a: Any) -> "Array | None":
    """The given pose (4, 4) of the sensor in the logged frame [m], or None."""
    from hefting.identification.front import sensor_pose_of

    return sensor_pose_of(a.sensor_pose_in_log, a.sensor_turned)


def logged(a: Any, path: str, wrench_needed: bool) -> "Recording":
    """The recording as logged."""
    from hefting.logs import read_log
    from hefting.logs.registry import all_options

    own = _own_options(path)
    options = {name: getattr(a, name) for name in all_options()}
    if "sensor_frame" not in own:
        del options["sensor_frame"]  # it names a link of the URDF
    if a.urdf and "pose_topic" in own:
        # the URDF gives the poses
        options["pose_topic"] = options["pose_topic"] or "none"
    options["poses"] = getattr(a, "poses", None)
    return read_log(path, column_map=a.map, wrench_needed=wrench_needed, **options)


def _own_options(path: str) -> "Mapping[str, tuple[str, str]]":
    """Options of a log's format."""
    from hefting.logs.registry import find_format

    found = find_format(path)
    return found.options if found else {}


def robot_of(a: Any) -> "Robot":
    """The robot of the given URDF, up to the sensor's link."""
    from hefting.robots import Robot

    if not a.sensor_frame:
        raise InputError(
            "which link holds the sensor?", a.urdf, "give --sensor-frame NAME"
        )
    return Robot.from_urdf(a.urdf, a.sensor_frame)

"""Front: `hefting.identify` takes a recording, a shape and a method in the forms that
users have."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from inspect import signature
from pathlib import Path
from typing import Any, Literal, cast, overload

from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.estimate import Answered, Estimate
from hefting.core.gravity import ON_EARTH, GravityLike
from hefting.core.quantity import turned_about
from hefting.core.spatial import Array
from hefting.estimators import METHODS
from hefting.identification.compare import Comparison, compare
from hefting.identification.estimator import Method, accuracy_of, shape_of
from hefting.identification.identify import Identification, identify_understood
from hefting.identification.run import understand
from hefting.ingest.tool import load_tool
from hefting.logs.given import as_recording
from hefting.logs.orientations import with_given_sensor_pose
from hefting.motion.measure import Source
from hefting.shapes import as_pose, as_shape

Sign = Literal["auto", "on-object", "on-sensor"]
INSTEAD = {
    "compare with it by hefting.errors_between(found.estimate.parameters, ...)": "truth",
    "give `gravity`=hefting.Gravity.at(latitude, altitude)": "latitude altitude",
    'give `shape`="box:X0,X1,Y0,Y1,Z0,Z1" [m]': "box",
    "give `shape`=hefting.load_shape(file, {}=...)": "hull points points_per_cm3",
    "give `recording`=hefting.read_log(log, {}=...)": "poses sensor_frame world_frame "
    "wrench_topic pose_topic twist_topic joint_topic imu_topic",
    "give `recording`=hefting.as_recording(log, column_map=...)": "column_map map",
    "give `recording`=hefting.with_poses(hefting.read_log(log), "
    "hefting.Robot.from_urdf(urdf, sensor_frame))": "urdf",
    "use hefting.identification.by_torques.ByTorques": "torques torque_gains empty arm",
    "give it to hefting.export.export(found, ...)": "accept fill_inertia output "
    "sensor_pose_in_flange",
}
"""Replacements of the command's options that `identify` does not have."""


@overload
def identify(
    recording: Any = None,
    shape: Any = None,
    *,
    method: Literal["all"] | Sequence[Method],
    **options: Any,
) -> Comparison:
    """By several methods."""
    ...


@overload
def identify(
    recording: Any = None,
    shape: Any = None,
    *,
    method: Method | None = None,
    **options: Any,
) -> Identification:
    """By one method."""
    ...


def identify(
    recording: Any = None,
    shape: Any = None,
    *,
    time: ArrayLike | None = None,
    position: ArrayLike | None = None,
    orientation: Any = None,
    pose: ArrayLike | None = None,
    wrench: ArrayLike | Sign | None = None,
    wrench_time: ArrayLike | None = None,
    force: ArrayLike | None = None,
    torque: ArrayLike | None = None,
    sign: Sign = "auto",
    unit: str | None = None,
    object_pose: ArrayLike | str | Path | None = None,
    method: Method | Sequence[Method] | None = None,
    gravity: GravityLike = ON_EARTH,
    bias: str | Path | ArrayLike = "auto",
    motion: Source = "auto",
    start: float = 0.0,
    duration: float | None = None,
    tool: Estimate | Answered | str | Path | None = None,
    sensor_pose_in_log: ArrayLike | str | Path | None = None,
    sensor_turned: str | None = None,
    **hyperparameters: Any,
) -> Identification | Comparison:
    """Identify the object that a recording shows, or several recordings of it.

    Parameters
    ----------
    recording : path, mapping, data frame, structured array or Recording, optional
        A log's path, or a table in memory with its columns; see `hefting.as_recording`.
        A list of these are several recordings of the same object, in one grasp and one
        sensor frame: each has a wrench bias, a clock and a sign of its own.
    shape : path, str, mesh, points or Shape, optional
        Where the object may have mass, in the sensor frame: a mesh or point cloud file,
        ``"box:X0,X1,Y0,Y1,Z0,Z1"`` [m], a ``trimesh.Trimesh``, points (n, 3) that fill
        it. Without it Bayes allows any object near the sensor.
    time, position, orientation, pose, wrench, wrench_time, force, torque : optional
        In place of `recording`: times (K,) [s]; positions (K, 3) [m] and orientations
        of the sensor in the world, (K, 4) quaternions x, y, z, w, (K, 3, 3) matrices or
        a scipy ``Rotation``, or both as poses (K, 4, 4); wrenches (N, 6) [N, N m] in
        sensor axes, or forces and torques (N, 3), and their times (N,) [s] if these
        differ from `time`. Without `time` each sample is a static pose.
    sign : {"auto", "on-object", "on-sensor"}
        Body that the recorded wrench acts on; ``"auto"`` determines it from gravity.
        `wrench` accepts these words too.
    unit : str, optional
        Length unit of the shape's file, mesh or points: m, cm, mm or in.
    object_pose : (4, 4) or seven numbers, optional
        Pose of its frame in the sensor frame: a matrix, or x, y, z [m], qx, qy, qz, qw.
    method : str, Estimator, its class, or a list of these, optional
        Of an estimator or a variant (`hefting methods` lists them), or of your own; a
        list, ``"OLS,LMI"`` and ``"all"`` are compared. By default Bayes.
    gravity : (3,), Gravity or "estimate"
        In world axes [m/s²], exactly known; `Gravity.at` a latitude; ``"estimate"``
        finds its direction, for a robot on a tilted base. By default standard gravity,
        with the uncertainty of its size on the Earth.
    bias : {"auto", "estimate", "none"}, (6,), path or (n, 6)
        ``"estimate"`` finds a constant bias with the object, ``"none"`` assumes there
        is none, ``"auto"`` keeps one that exceeds three standard deviations; or six
        numbers [N, N m], as recorded, to subtract, or a JSON file of them, or
        ``"tare:START,END"`` [s] for the mean of that time; (n, 6) are one for each of n
        recordings.
    motion : {"auto", "columns", "smooth", "filter"}
        Source of velocities and accelerations, see `hefting.measure`.
    start, duration : float, optional
        Part of the recording, or of each, to use [s].
    tool : Estimate, what `calibrate` or `identify` returns, or path, optional
        What the sensor holds in addition to the object, to subtract; see
        `hefting.calibrate`.
    sensor_pose_in_log : (4, 4), seven numbers or text, optional
        Pose of the sensor in the frame whose poses are logged, if that is another one:
        a matrix, or x, y, z [m], qx, qy, qz, qw.
    sensor_turned : str, optional
        The same for a rotation about one axis only, as in ``"z:45"`` [deg].
    **hyperparameters
        Fields of the estimator. Of Bayes: ``pose_std`` and ``shape_std`` if pose or
        shape are not exact, ``until`` to use only as much of the recording as an
        accuracy requires. Of all methods: ``sensor_accuracy``; and ``mass``, a scale's
        reading of the object without the tool, as in ``"0.512kg±1g"``, see
        `hefting.MassReading`.

    Returns
    -------
    Identification, or Comparison of several methods
        Both have ``mass``, ``center_of_mass``, ``inertia``, ``interval(name)``,
        ``warnings``, ``verdict`` and the full ``estimate``.

    Raises
    ------
    InputError
        For invalid input, with what is wrong, where, and what to do in one line.
    NotIdentifiableError
        If the recording determines nothing.

    Examples
    --------
    >>> found = hefting.identify("demo/log.csv", "box:-0.1,0.1,-0.3,0.3,0,0.3")
    >>> low, high = found.interval("mass")
    >>> bool(low < found.mass < high)
    True
    """
    if isinstance(wrench, str):
        sign, wrench = cast("Sign", wrench), None
    _check_names(hyperparameters)
    arrays = {
        "time": time,
        "position": position,
        "orientation": orientation,
        "pose": pose,
        "wrench": wrench,
        "wrench_time": wrench_time,
        "force": force,
        "torque": torque,
    }
    if recording is None or any(array is not None for array in arrays.values()):
        recording = as_recording(recording, **arrays)
    posed = sensor_pose_of(sensor_pose_in_log, sensor_turned)
    if posed is not None:
        several = recording if isinstance(recording, list | tuple) else [recording]
        placed = [with_given_sensor_pose(as_recording(one), posed) for one in several]
        recording = placed if isinstance(recording, list | tuple) else placed[0]
    options = {
        "gravity": gravity,
        "wrench": sign,
        "bias": bias,
        "motion": motion,
        "start": start,
        "duration": duration,
        "tool": None if tool is None else load_tool(tool),
    }
    known = as_shape(shape, unit, object_pose)
    if isinstance(method, str) and ("," in method or method.lower() == "all"):
        method = method.split(",")
    if isinstance(method, Iterable) and not isinstance(method, str):
        return compare(
            recording, known, list(method), hyperparameters=hyperparameters, **options
        )
    known = shape_of(method, known, hyperparameters)
    accuracy = accuracy_of(method, hyperparameters)
    found = understand(recording, accuracy, **options)
    return identify_understood(found, known, method, hyperparameters)


def _check_names(hyperparameters: dict[str, Any]) -> None:
    """`InputError` for an unknown hyperparameter that resembles an argument of
    `identify`, or is an option of the command."""
    own = set(signature(identify).parameters) - {"hyperparameters"}
    of_methods = {name for kind in METHODS.values() for name in kind.hyperparameters()}
    for name in hyperparameters:
        if name in of_methods:
            continue
        what = f"there is no argument '{name}'"
        for fix, names in INSTEAD.items():
            if name in names.split():
                raise InputError(what, fix=fix.format(name))
        meant = nearest(name, sorted(own | of_methods))
        if any(f"'{argument}'" in meant for argument in own):
            raise InputError(what + meant)


def sensor_pose_of(pose: Any, turned: str | None) -> Array | None:
    """Pose (4, 4) of the sensor in the logged frame; None if none is given."""
    if turned is None:
        return None if pose is None else as_pose(pose)
    if pose is not None:
        what = "both `sensor_pose_in_log` and `sensor_turned` are given"
        raise InputError(what, fix="give one of them")
    return turned_about(turned)

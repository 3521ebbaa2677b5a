"""What can be said to be wrong of a request before any recording is read."""

from types import SimpleNamespace
from typing import Any

from hefting.core.errors import InputError
from hefting.request.settings import bias_said, gravity_of, hyperparameters_of
from hefting.request.shape import shape_of


def check_request(request: SimpleNamespace) -> None:
    """`InputError` for what is wrong whatever the recording: words that mean nothing,
    numbers that cannot be, and files that are not there or are not what they should.

    What is only wrong without something else, as a hull without a shape, is not.
    """
    a = request
    gravity_of(a)
    hyperparameters_of(a)
    bias_said(a.bias)
    _check_words(a)
    _check_part(a)
    _check_files(a)
    shape_of(SimpleNamespace(**{**vars(a), "hull": a.hull and a.shape is not None}))


def _check_words(a: Any) -> None:
    """Those of the method, the wrench and the motion."""
    from hefting.estimators import method_named
    from hefting.ingest.ingest import check_convention
    from hefting.motion.measure import check_source

    if a.method is not None:
        method_named(a.method)
    check_convention(a.wrench)
    check_source(a.motion)


def _check_part(a: Any) -> None:
    """The part of a recording that is used."""
    if not a.start >= 0.0:
        raise InputError(f"{a.start:g} s is before a recording", "--start")
    if a.duration is not None and not a.duration > 0.0:
        raise InputError(f"{a.duration:g} s is no time", "--duration")


def _check_files(a: Any) -> None:
    """Those that say how a recording is read, and what is subtracted; and the pose of
    the sensor, a file or numbers."""
    from hefting.ingest.tool import load_tool
    from hefting.logs.column_map import load_map
    from hefting.logs.sensor_pose import sensor_turned
    from hefting.shapes import parse_pose

    if a.tool is not None:
        load_tool(a.tool)
    if a.map is not None:
        load_map(a.map)
    if a.sensor_pose_in_log is not None:
        parse_pose(a.sensor_pose_in_log)
    if a.sensor_turned is not None:
        sensor_turned(a.sensor_turned)
    if a.urdf is not None and a.sensor_frame is not None:
        from hefting.robots import Robot

        Robot.from_urdf(a.urdf, a.sensor_frame)

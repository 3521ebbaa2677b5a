"""Smoothing: curves through the poses of a recording, with the inertial sensors it has."""

from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.messages import Message
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, frozen
from hefting.motion.bspline import FEWEST_SEGMENT_SAMPLES
from hefting.motion.inertial import fuse
from hefting.motion.spline import SmoothedPoses, fit_poses


@immutable
class Curves:
    """Smooth curves through the poses of a recording."""

    poses: SmoothedPoses
    alone: SmoothedPoses
    """Curves from the poses without inertial sensors, whose clocks and axes may differ"""
    source: str
    """``"smooth"``, or ``"inertial"`` if a gyroscope or an accelerometer was used"""
    notes: tuple[Message, ...]
    """Notes on those sensors."""
    warnings: tuple[Message, ...]


def smooth_poses(
    recording: Recording,
    gravity: ArrayLike = STANDARD_GRAVITY,
    alone: SmoothedPoses | None = None,
) -> Curves:
    """Fit smooth curves to the poses of a recording, and to its gyroscope and
    accelerometer if it has them.

    `gravity` (3,) is in world axes [m/s²]; `alone` are the curves without those sensors,
    if already fitted. Raises `InputError` for fewer than `FEWEST_SEGMENT_SAMPLES` poses.
    """
    poses = _fit_recorded_poses(recording) if alone is None else alone
    streams = recording.streams
    accelerometer = streams.get("accelerometer") or streams.get("linear_accelerometer")
    if accelerometer is None and "gyroscope" not in streams:
        return Curves(poses, poses, "smooth", (), ())
    gravity_removed = not recording.has("accelerometer")
    fused, notes, warnings = fuse(
        poses, frozen(gravity), streams.get("gyroscope"), accelerometer, gravity_removed
    )
    return Curves(fused, poses, "inertial" if notes else "smooth", notes, warnings)


def _fit_recorded_poses(recording: Recording) -> SmoothedPoses:
    """Smooth curves through the orientation and the position, if there is one;
    `InputError` for too few poses to differentiate."""
    orientation, position = recording["orientation"], None
    poses = len(orientation)
    if recording.has("position"):
        position = recording["position"]
        # an empty position stream is left to the fit
        poses = min(poses, len(position) or poses)
    if poses < FEWEST_SEGMENT_SAMPLES:
        raise InputError(
            f"{poses} poses are too few to find velocities from",
            where=recording.source,
            fix="give a longer recording, or static poses without the time column",
        )
    if position is None:
        return fit_poses(orientation.time, None, orientation.values)
    return fit_poses(
        orientation.time, position.values, orientation.values, position.time
    )

"""Motion: poses, gyroscope and accelerometer -> velocities and accelerations of the
sensor, with their errors."""

from hefting.motion.inertial import Curves, smooth_poses
from hefting.motion.measure import Measured, measure
from hefting.motion.spline import SmoothedPoses, fit_poses, smooth
from hefting.motion.state import Motion, sample_weights

__all__ = [
    "Curves",
    "Measured",
    "Motion",
    "SmoothedPoses",
    "fit_poses",
    "measure",
    "sample_weights",
    "smooth",
    "smooth_poses",
]

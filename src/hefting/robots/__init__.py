"""Robots: poses of the sensor frame from recorded joint positions by a URDF, and a check
of its inertials."""

from hefting.robots.arm import Arm
from hefting.robots.inertia_check import LinkCheck, check_inertias
from hefting.robots.inertia_repair import Repaired, repair_inertias
from hefting.robots.joint_motion import with_poses
from hefting.robots.robot import Robot

__all__ = [
    "Arm",
    "LinkCheck",
    "Repaired",
    "Robot",
    "check_inertias",
    "repair_inertias",
    "with_poses",
]

"""Robots: a robot's URDF turns recorded joint positions into poses of the sensor
frame, and is checked for inertials that no body can have."""

from hefting.robots.arm import Arm
from hefting.robots.inertia_check import LinkCheck, check_inertias
from hefting.robots.inertia_repair import Repaired, repair_inertias
from hefting.robots.joint_log import with_poses
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

"""Robots: a robot's URDF turns recorded joint positions into poses of the sensor
frame."""

from hefting.robots.joint_log import with_poses
from hefting.robots.robot import Robot

__all__ = ["Robot", "with_poses"]

"""Speed of the fastest corner of the object along a planned motion."""

import numpy as np

from hefting.core.spatial import Array
from hefting.planning.result import Plan
from hefting.robots.joint_motion import sensor_motion
from hefting.robots.robot import Robot


def corner_speeds(plan: Plan) -> Array:
    """(K,) [m/s] of the fastest of the plan's corners at each instant of its motion.

    The robot is read from `Plan.source`; `InputError` where that is gone.
    """
    robot = Robot.from_urdf(plan.source, plan.tip)
    sensor = sensor_motion(robot, plan.motion)
    return np.max([sensor.linear_speed(corner) for corner in plan.corners], axis=0)

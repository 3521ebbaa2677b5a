"""Arms for tests."""

from dataclasses import replace

from hefting.core.spatial import frozen, rotation_matrices
from hefting.simulation import Arm


def mounted(arm: Arm, height: float) -> Arm:
    """The same arm with its sensor frame `height` [m] further along its own z axis."""
    robot = arm.robot
    up = rotation_matrices(robot.home_orientation)[:, 2]
    return replace(
        arm,
        robot=replace(robot, home_position=frozen(robot.home_position + height * up)),
    )

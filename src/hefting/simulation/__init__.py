"""Simulation: an arm wields a rigid body and writes the log a robot would, with the truth beside it."""

from hefting.simulation.arm import UR5, Arm, JointMotion, SensorMotion
from hefting.simulation.joints import random_smooth, sinusoids, stop_and_go
from hefting.simulation.objects import Assembly, Part, hammer
from hefting.simulation.wield import simulate, truth, wield

__all__ = [
    "UR5",
    "Arm",
    "Assembly",
    "JointMotion",
    "Part",
    "SensorMotion",
    "hammer",
    "random_smooth",
    "simulate",
    "sinusoids",
    "stop_and_go",
    "truth",
    "wield",
]

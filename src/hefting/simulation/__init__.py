"""Simulation: an arm wields a rigid body; the log that a robot would write, and the
truth."""

from hefting.simulation.arm import UR5, XARM7, Arm, JointMotion, SensorMotion
from hefting.simulation.faults import (
    WRENCH_NOISE,
    Faults,
    Rates,
    record,
    tilted_gravity,
)
from hefting.simulation.joints import random_smooth, sinusoids, stop_and_go, trapezoids
from hefting.simulation.modular import MODULAR, held_modular, modular, paper_points
from hefting.simulation.objects import Assembly, HeldObject, Part, hammer
from hefting.simulation.wield import (
    Wielding,
    simulate,
    truth,
    wield,
    wield_analytically,
    wield_in_mujoco,
)

__all__ = [
    "MODULAR",
    "UR5",
    "WRENCH_NOISE",
    "XARM7",
    "Arm",
    "Assembly",
    "Faults",
    "HeldObject",
    "JointMotion",
    "Part",
    "Rates",
    "SensorMotion",
    "Wielding",
    "hammer",
    "held_modular",
    "modular",
    "paper_points",
    "random_smooth",
    "record",
    "simulate",
    "sinusoids",
    "stop_and_go",
    "tilted_gravity",
    "trapezoids",
    "truth",
    "wield",
    "wield_analytically",
    "wield_in_mujoco",
]

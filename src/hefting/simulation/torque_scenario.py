"""A simulated recording of joint torques: the arm with an object, and the same arm
without one; with the URDF that says of the arm what its maker does."""

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.simulation.arm_links import TORQUE_ARMS
from hefting.simulation.held import HeldObject
from hefting.simulation.joints import wide_smooth
from hefting.simulation.physics import mujoco_version
from hefting.simulation.torques import TorqueFaults, TorqueRobot

BETWEEN = 60.0
"""[s] From the start of the empty run to that of the loaded one, at least; gears warm
up meanwhile."""


@dataclass(frozen=True, eq=False)
class TorquesSimulated:
    """What came of a scenario."""

    loaded: Recording
    """angles and torques of the joints with the object"""
    empty: Recording
    """of another motion, without it, before"""
    urdf: str
    """the arm as published; its flange is the link ``flange``"""
    facts: dict[str, Any]
    """the truth, as of `hefting.simulation.scenario.Simulated`"""


@dataclass(frozen=True, eq=False)
class TorqueScenario:
    """What is simulated; `run` does it. The same for the same `seed`."""

    held: HeldObject
    arm: str = "ur5e"
    """one of `hefting.simulation.arm_links.TORQUE_ARMS`"""
    duration: float = 30.0
    """of either run [s]"""
    rate: float = 100.0
    """[Hz]"""
    gravity: ArrayLike = STANDARD_GRAVITY
    """(3,) in the axes of the arm's base [m/s²]"""
    faults: TorqueFaults = field(default_factory=TorqueFaults)
    seed: int = 0

    def run(self) -> TorquesSimulated:
        """Move the arm in MuJoCo, empty and loaded.

        Raises `MissingDependencyError` without MuJoCo, and `InputError` for another arm
        and for numbers out of range.
        """
        if self.arm not in TORQUE_ARMS:
            what = f"there is no arm '{self.arm}' with torques"
            fix = f"choose one of {', '.join(TORQUE_ARMS)}"
            raise InputError(what + nearest(self.arm, TORQUE_ARMS), fix=fix)
        massive = TORQUE_ARMS[self.arm]
        robot = TorqueRobot(massive, self.faults, self.seed)
        motions = [
            wide_smooth(self.duration, self.rate, 2 * self.seed + k, massive.arm)
            for k in (0, 1)
        ]
        later = max(BETWEEN, 2.0 * self.duration)
        body, gravity = self.held.parameters, self.gravity
        empty = robot.record(motions[0], None, 0.0, gravity, seed=0)
        loaded = robot.record(motions[1], body, later, gravity, seed=1)
        facts = self.held.truth(np.asarray(gravity), False)
        facts["simulation"] = {
            "engine": f"MuJoCo {mujoco_version()}",
            "arm": self.arm,
            "sensor_frame": "flange",
            "duration": self.duration,
            "rate": self.rate,
            "faults": asdict(self.faults),
            "seed": self.seed,
        }
        return TorquesSimulated(loaded, empty, massive.urdf, facts)

"""Simulated runs of joint torques, empty and loaded, that several files share."""

import sys
from functools import cache
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))

from benchmarks import torques_simulated
from hefting.core.inertia import InertialParameters
from hefting.torques.dynamics import JointDynamics
from hefting.torques.noise import TorqueFit
from hefting.torques.runs import LoadedRuns

BODY = InertialParameters.from_com(
    0.8, [0.01, 0.02, 0.08], np.diag([2e-3, 2.2e-3, 1e-3])
)


@cache
def dynamics(name: str) -> JointDynamics:
    """Of the published arm."""
    return torques_simulated.dynamics_of(name)


@cache
def runs(name: str, seed: int = 3) -> LoadedRuns:
    """An empty run and, of another motion, one with `BODY`, of one of four robots."""
    return torques_simulated.runs(name, dynamics(name), BODY, seed)


@cache
def fitted(name: str, seed: int = 3) -> TorqueFit:
    """What is found from `runs`."""
    return runs(name, seed).fit()

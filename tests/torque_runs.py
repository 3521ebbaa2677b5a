"""Simulated runs of joint torques, empty and loaded, that several files share."""

import sys
from functools import cache
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1]))

from benchmarks import torques_simulated
from hefting.core.inertia import InertialParameters
from hefting.simulation.arm import Arm, JointMotion
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
def runs(name: str, seed: int = 3, rate: float = 50.0) -> LoadedRuns:
    """An empty run and, of another motion, one with `BODY`, of one of four robots. Those
    at 50 Hz tell most of what the benchmark's at 100 Hz do."""
    return torques_simulated.runs(name, dynamics(name), BODY, seed, rate)


@cache
def fitted(name: str, seed: int = 3, rate: float = 50.0) -> TorqueFit:
    """What is found from `runs`."""
    return runs(name, seed, rate).fit()


def one_at_a_time(arm: Arm, seconds: float, moves: int, seed: int) -> JointMotion:
    """Joints that move one after another, of constant speed for most of the `seconds` of
    each move, at 100 Hz."""
    rng = np.random.default_rng(seed)
    many = round(100.0 * seconds)
    share = np.clip(np.linspace(-0.2, 1.2, many), 0.0, 1.0)[:, None]
    turn = np.arange(moves)[:, None] % arm.n == np.arange(arm.n)
    change = rng.uniform(-0.8, 0.8, (moves, arm.n)) * turn
    before = arm.start + np.cumsum(change, axis=0) - change
    q = np.concatenate([b + share * by for b, by in zip(before, change, strict=True)])
    # a controller rounds the corners
    window = np.hanning(9) / np.hanning(9).sum()
    padded = np.pad(q, ((4, 4), (0, 0)), mode="edge")
    q = np.column_stack([np.convolve(own, window, "valid") for own in padded.T])
    dq = np.gradient(q, 0.01, axis=0)
    return JointMotion(0.01 * np.arange(len(q)), q, dq, np.gradient(dq, 0.01, axis=0))

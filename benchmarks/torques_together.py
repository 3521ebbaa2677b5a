"""A wrench and joint torques of the same recording: errors of each alone and of both."""

import numpy as np

from benchmarks.bodies import KINDS
from benchmarks.torques_simulated import (
    BETWEEN,
    DURATION,
    RATE,
    dynamics_of,
    weighed,
)
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.estimators import Bayes
from hefting.estimators.joint_state import WhitenedState
from hefting.identification.by_torques import wrench_equations
from hefting.robots import with_poses
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torque_scenario import TORQUE_ARMS, TorqueFaults, TorqueRobot
from hefting.simulation.wield import wield
from hefting.torques.runs import LoadedRuns
from hefting.torques.samples import samples_of

NAME = "ur5e"
POOR = np.repeat((2.0, 0.1), 3)
"""[N, N m] Standard deviations of a poor wrist sensor's noise, so that torques have
something to add."""
BIAS = np.array((12.0, -7.0, 14.0, 0.3, -0.2, 0.1))
"""[N, N m] of the wrench."""


def compare(objects: int, seed: int) -> dict[str, float]:
    """Median errors of mass [%], COM [mm] and, in the metric of the posterior of both,
    of all parameters: by wrench, by torques, by both."""
    dynamics = dynamics_of(NAME)
    rows = []
    for k in range(objects):
        number = 1000 * seed + k
        body = weighed(KINDS[k % len(KINDS)], number).parameters
        loaded, empty = _recordings(body, number)
        runs = LoadedRuns(
            dynamics, (samples_of(loaded, dynamics),), (samples_of(empty, dynamics),)
        )
        torques = runs.fit().state
        wrench = wrench_equations(
            with_poses(loaded, dynamics.robot), wrench="on-object"
        )
        both = torques.stacked(wrench)
        rows.append([_errors(state, body) for state in (wrench, torques, both)])
    median = np.median(np.array(rows), axis=0)
    return {
        f"{what} {by}": float(median[i, j])
        for i, by in enumerate(("wrench", "torques", "both"))
        for j, what in enumerate(("mass [%]", "COM [mm]"))
    }


def _recordings(body: InertialParameters, seed: int) -> tuple[Recording, Recording]:
    massive = TORQUE_ARMS[NAME]
    robot = TorqueRobot(massive, TorqueFaults(), seed % 4)
    joints = wide_smooth(DURATION, RATE, 10_000 + seed, massive.arm)
    log = robot.record(joints, body, BETWEEN, seed=10_000 + seed)
    rng = np.random.default_rng([seed, 45])
    exact = wield(massive.arm.motion(joints), body).wrench
    shown = exact + BIAS + POOR * rng.standard_normal(exact.shape)
    time = log["joint_positions"].time
    streams = {**log.streams, "wrench": Stream(time, shown)}
    bare = wide_smooth(DURATION, RATE, 20_000 + seed, massive.arm)
    return (
        Recording(streams, source="loaded", joint_names=log.joint_names),
        robot.record(bare, None, 0.0, seed=20_000 + seed),
    )


def _errors(state: WhitenedState, truth: InertialParameters) -> tuple[float, float]:
    found = Bayes().estimate(state)
    return (
        100.0 * abs(found.mass - truth.mass) / truth.mass,
        1e3 * float(np.linalg.norm(found.center_of_mass - truth.center_of_mass)),
    )

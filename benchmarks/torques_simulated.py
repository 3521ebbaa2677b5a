"""Simulated joint torques of three arms with friction, rotors, offsets and warm-up, and
an empty run of another motion: errors and intervals."""

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.bodies import KINDS, Body, random_body
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array
from hefting.estimators import Bayes
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torque_scenario import TORQUE_ARMS, TorqueFaults, TorqueRobot
from hefting.torques.dynamics import JointDynamics
from hefting.torques.runs import LoadedRuns
from hefting.torques.samples import TorqueSamples

LIGHTEST, HEAVIEST = 0.3, 2.0
"""[kg] Range of the objects, evenly spread over their logarithm."""
DURATION, RATE = 30.0, 100.0
"""[s], [Hz] of each run."""
BETWEEN = 60.0
"""[s] from the start of the empty run to that of the loaded one."""


@dataclass(frozen=True, eq=False)
class Case:
    """An object, and what was found of it."""

    body: Body
    alone: Estimate
    """without a shape"""
    shaped: Estimate


def dynamics_of(name: str) -> JointDynamics:
    """Of the published arm."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.urdf"
        path.write_text(TORQUE_ARMS[name].urdf, encoding="utf-8")
        return JointDynamics.from_urdf(path, "flange")


def weighed(kind: str, seed: int) -> Body:
    """A random body of `LIGHTEST` to `HEAVIEST` kg."""
    body = random_body(kind, seed)
    rng = np.random.default_rng([seed, 44])
    mass = np.exp(rng.uniform(np.log(LIGHTEST), np.log(HEAVIEST)))
    vector = body.parameters.vector * (mass / body.parameters.mass)
    return replace(body, parameters=InertialParameters(vector))


def runs(
    name: str,
    dynamics: JointDynamics,
    body: InertialParameters,
    seed: int,
    rate: float = RATE,
) -> LoadedRuns:
    """An empty run and, of another motion, one with the body, of one of four robots of
    the kind."""
    massive = TORQUE_ARMS[name]
    robot = TorqueRobot(massive, TorqueFaults(), seed % 4)

    def samples(held: InertialParameters | None, start: float, own: int):
        joints = wide_smooth(DURATION, rate, own, massive.arm)
        log = robot.record(joints, held, start, seed=own)
        q, tau = log["joint_positions"], log["joint_torques"]
        return TorqueSamples.smoothed(q.time, q.values, tau.time, tau.values)

    empty = samples(None, 0.0, 20_000 + seed)
    return LoadedRuns(dynamics, (samples(body, BETWEEN, 10_000 + seed),), (empty,))


def cases(name: str, objects: int, seed: int) -> list[Case]:
    """Identified by Bayes without and with the shape."""
    dynamics, found = dynamics_of(name), []
    for k in range(objects):
        body = weighed(KINDS[k % len(KINDS)], 1000 * seed + k)
        state = runs(name, dynamics, body.parameters, 1000 * seed + k).fit().state
        alone = Bayes().estimate(state)
        found.append(Case(body, alone, Bayes(body.shape).estimate(state)))
    return found


def summary(found: list[Case]) -> dict[str, float]:
    """Errors without a shape, of the inertia with one too, and how often the intervals
    hold."""
    truth = [case.body.parameters for case in found]
    alone = [_errors(c.alone, t) for c, t in zip(found, truth, strict=True)]
    shaped = [_errors(c.shaped, t) for c, t in zip(found, truth, strict=True)]
    mass, com, inertia = np.array(alone).T
    held = np.array([_held(c.alone, t) for c, t in zip(found, truth, strict=True)])
    held_shaped = [_held(c.shaped, t) for c, t in zip(found, truth, strict=True)]
    return {
        "mass [%] median": 100 * float(np.median(mass)),
        "mass [%] 90th": 100 * float(np.quantile(mass, 0.9)),
        "COM [mm] median": 1e3 * float(np.median(com)),
        "COM [mm] 90th": 1e3 * float(np.quantile(com, 0.9)),
        "inertia [%] alone": 100 * float(np.median(inertia)),
        "inertia [%] shape": 100 * float(np.median(np.array(shaped)[:, 2])),
        "hold": float(held.mean()),
        "hold shape": float(np.mean(held_shaped)),
    }


def _errors(found: Estimate, truth: InertialParameters) -> tuple[float, float, float]:
    J, own = truth.inertia_at_com, found.parameters.inertia_at_com
    return (
        abs(found.mass - truth.mass) / truth.mass,
        float(np.linalg.norm(found.center_of_mass - truth.center_of_mass)),
        float(np.linalg.norm(own - J) / np.linalg.norm(J)),
    )


def _held(found: Estimate, truth: InertialParameters) -> Array:
    """(4,) whether the intervals of mass and COM hold the truth."""
    assert found.intervals is not None
    (low, high), (lows, highs) = (
        found.intervals[name] for name in ("mass", "center_of_mass")
    )
    c = truth.center_of_mass
    return np.array([low <= truth.mass <= high, *((lows <= c) & (c <= highs))])

"""Planned and random motions, played in MuJoCo and identified; see
`benchmarks.planning`."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.bodies import KINDS, Body, random_body
from hefting import identify
from hefting.core.estimate import Estimate
from hefting.core.measurements import MotionNoise, Noise
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.planning import Plan, plan
from hefting.planning.held import Held
from hefting.planning.information import Information, noise_covariance
from hefting.planning.kinematics import Chain, Trajectory
from hefting.planning.limits import Constraints, Limits
from hefting.planning.optimise import filled, fitted, largest_share, random_ways
from hefting.planning.problem import GRID, Basis, Objective, Problem, pieces_of
from hefting.robots.robot import Robot
from hefting.shapes import Shape
from hefting.simulation.faults import WRENCH_NOISE, Faults, Rates, record
from hefting.simulation.joints import FREQUENCIES
from hefting.simulation.torque_scenario import TORQUE_ARMS, MassiveArm
from hefting.simulation.wield import wield_in_mujoco

FOURIER_TERMS = 4
"""Of a random motion, one turn of the first over the whole of it: what peers take."""
BIAS = (3.0, -2.0, 5.0, 0.2, -0.1, 0.15)
"""Of the wrench [N, N m]."""
QUANTITIES = ("mass", "COM", "inertia")
UNITS = ("%", "mm", "%")
NOISE = Noise(0.1, 0.005)


class Run(NamedTuple):
    """What came of one motion."""

    errors: Array
    """(3,) mass [%], COM [mm], inertia about the COM [%] by Frobenius norms"""
    estimate: Estimate
    recording: Recording


@dataclass(frozen=True, eq=False)
class Bench:
    """An arm, with its URDF in a folder."""

    name: str
    folder: Path

    @cached_property
    def massive(self) -> MassiveArm:
        """The arm."""
        return TORQUE_ARMS[self.name]

    @cached_property
    def urdf(self) -> Path:
        """Path of its URDF."""
        path = self.folder / f"{self.name}.urdf"
        path.write_text(self.massive.urdf)
        return path

    def problem(self, duration: float, shape: Shape | None) -> Problem:
        """The limits that a plan without further arguments keeps, for random motions
        to keep them too."""
        robot = Robot.from_urdf(self.urdf, "flange")
        held = Held.of(None, shape)
        vector = held.body.vector
        S = noise_covariance(NOISE, MotionNoise(0.0, 0.0), vector, 100.0)
        corners = np.vstack((np.zeros(3), held.corners))
        limits = Limits.from_urdf(self.urdf, robot)
        return Problem(
            Chain.of(robot, np.array(STANDARD_GRAVITY)),
            Basis.of(duration, pieces_of(duration), GRID),
            np.array(self.massive.arm.start),
            held.information,
            Information.of(S, 100.0),
            Objective.of(held.body, None),
            Constraints.of(limits, corners, vector),
        )

    def random(
        self, duration: float, number: int, shape: Shape | None = None, seed: int = 0
    ) -> Iterator[Trajectory]:
        """Random Fourier series that just keep the limits."""
        problem = self.problem(duration, shape)
        rng = np.random.default_rng([seed, 31])
        time = np.linspace(0.0, duration, problem.basis.values.shape[1])
        for _ in range(number):
            ways = random_ways(rng, time, len(problem.start), FOURIER_TERMS, 0.0)
            x = filled(problem, fitted(problem.basis, ways))
            yield problem.basis.trajectory(problem.start, x)

    def wrist(self, duration: float, shape: Shape | None = None) -> Trajectory:
        """The paper's sinusoids of the last three joints, their clock as fast as the
        limits allow, from rest to rest."""
        problem = self.problem(duration, shape)
        at = np.linspace(0.0, duration, problem.basis.values.shape[1])
        ramp = np.clip(np.minimum(at, duration - at), 0.0, 1.0)
        rate = ramp**3 * (10.0 - 15.0 * ramp + 6.0 * ramp**2)
        clock = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))))
        clock *= at[1]
        ways = np.zeros((len(at), len(problem.start)))

        def motion(scale: float) -> Array:
            for joint, f in zip((-3, -2, -1), FREQUENCIES, strict=True):
                room = self.massive.arm.room[joint]
                size = min(np.radians(45.0), 0.98 * room)
                ways[:, joint] = size * np.sin(2.0 * np.pi * f * scale * clock)
            return fitted(problem.basis, ways)

        low, high = 0.0, 12.0
        for _ in range(25):
            scale = 0.5 * (low + high)
            kept = largest_share(problem, motion(scale)) <= 1.0
            low, high = (scale, high) if kept else (low, scale)
        return problem.basis.trajectory(problem.start, motion(low))

    def plan(self, **arguments) -> tuple[Plan, float]:
        """A plan from the arm's usual place to start, and the seconds of one core it took."""
        start = self.massive.arm.start
        begun = time.process_time()
        found = plan(self.urdf, "flange", start=start, **arguments)
        return found, time.process_time() - begun

    def play(
        self, motion: Trajectory, body: Body, seed: int, shape: Shape | None = None
    ) -> Run:
        """What is identified, with or without a shape, of its recording."""
        recording = self.recording(motion, body, seed)
        found = identify(recording, shape).estimate
        return Run(errors(found, body), found, recording)

    def recording(self, motion: Trajectory, body: Body, seed: int) -> Recording:
        """A recording of MuJoCo's wrench, with noise, bias and pose noise."""
        wielding = wield_in_mujoco(
            self.massive.arm, motion.sampled(100.0), body.parameters
        )
        faults = Faults(wrench_noise=WRENCH_NOISE["moderate"], bias=BIAS)
        return record(wielding, faults, Rates(100.0, 100.0), seed)


def errors(found: Estimate, body: Body) -> Array:
    """(3,) as in `Run`."""
    true = body.parameters
    off = np.linalg.norm(found.inertia - true.inertia_at_com)
    return np.array(
        (
            100.0 * abs(found.mass / true.mass - 1.0),
            1e3 * np.linalg.norm(found.center_of_mass - true.center_of_mass),
            100.0 * off / np.linalg.norm(true.inertia_at_com),
        )
    )


def bodies(number: int) -> list[Body]:
    """Random bodies of every kind in turn."""
    return [random_body(KINDS[i % len(KINDS)], 500 + i) for i in range(number)]


def width_ratios(promised: Plan, found: Estimate) -> Array:
    """(10,) half-widths that a recording gave over those its plan promised."""
    widths, last = found.half_widths, promised.forecast
    upper = np.triu_indices(3)
    given = np.concatenate(
        (
            [widths["mass"]],
            widths["center_of_mass"],
            widths["inertia_at_com"][upper],
        )
    )
    expected = np.concatenate(
        ([last.mass[-1]], last.center_of_mass[-1], last.inertia[-1][upper])
    )
    return given / expected

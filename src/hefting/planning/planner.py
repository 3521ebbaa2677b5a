"""From what is known to a motion and its forecast, for any duration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.planning.constraints import Constraints
from hefting.planning.forecast import INSTANTS
from hefting.planning.held import Held
from hefting.planning.kinematics import Chain
from hefting.planning.limits import Limits
from hefting.planning.objective import Objective
from hefting.planning.problem import GRID, Basis, Problem, pieces_of
from hefting.planning.result import Forecast
from hefting.planning.search import Found, Searcher, effort_named
from hefting.planning.sensors import Sensor
from hefting.planning.space import Space
from hefting.planning.tours import asked_of_tour, planned_tour
from hefting.robots.robot import Robot

RANDOM_STARTS = 12
"""Places to start from that are tried where none is given."""


@dataclass(frozen=True, eq=False)
class Planner:
    """All that a motion is planned with, but its duration."""

    robot: Robot
    limits: Limits
    held: Held
    space: Space
    sensor: Sensor
    gravity: Array
    """(3,) [m/s²]"""
    start: ArrayLike | None
    """(n,) [rad]"""
    asked: Accuracy | None
    stop_and_go: bool
    seed: int

    def planned(self, duration: float, effort: str) -> tuple[Found, Forecast]:
        """The motion of `duration` [s], and what is expected of it; errors as of
        `plan`."""
        rng = np.random.default_rng([self.seed, 7])
        searcher = Searcher(self.robot.joints, self.space, effort_named(effort), rng)
        problem = self.problem(duration)
        starts = self._starts(problem, searcher)
        best = (
            planned_tour(searcher, problem, starts[0])
            if self.stop_and_go
            else searcher.best(problem, starts)
        )
        forecaster = self.sensor.forecaster(
            self.robot, problem.chain, self.held, self.seed
        )
        return best, forecaster.forecast(best.trajectory, INSTANTS[effort])

    def problem(self, duration: float) -> Problem:
        """The problem, with all joints at zero at the start."""
        vector = self.held.body.vector
        asked = asked_of_tour(self.asked) if self.stop_and_go else self.asked
        corners = np.vstack((np.zeros(3), self.held.corners))
        return Problem(
            Chain.of(self.robot, self.gravity),
            Basis.of(duration, pieces_of(duration), GRID),
            np.zeros(len(self.limits.speed)),
            self.held.information,
            self.sensor.information(vector),
            Objective.of(self.held.body, asked, self.sensor.gain),
            Constraints.of(self.limits, corners, vector, self.space.half_spaces),
        )

    def _starts(self, problem: Problem, searcher: Searcher) -> Array:
        """(s, n) places to start from."""
        if self.start is None:
            return searcher.free_starts(problem, RANDOM_STARTS)
        try:
            own = np.asarray(self.start, dtype=float)
        except (TypeError, ValueError):
            raise InputError("the start is not made of numbers") from None
        n = len(problem.start)
        if own.shape != (n,) or not np.isfinite(own).all():
            what = f"the start is not {n} finite joint positions [rad]"
            raise InputError(what, fix=f"give `start` as {', '.join(searcher.joints)}")
        searcher.require_free(problem, own)
        return own[None]

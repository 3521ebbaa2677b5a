"""Planning of the motion to make, within limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError, check_number
from hefting.core.estimate import Answered, Estimate, estimate_given
from hefting.core.measurements import Noise
from hefting.core.messages import Message, note
from hefting.core.spatial import (
    SPEED_LIMIT,
    STANDARD_GRAVITY,
    Array,
    check_gravity,
    immutable,
)
from hefting.planning.held import Held
from hefting.planning.kinematics import Chain
from hefting.planning.limits import ACCELERATION, JERK, Constraints, Limits
from hefting.planning.problem import GRID, Basis, Objective, Problem, pieces_of
from hefting.planning.result import (
    INSTANTS,
    LONGEST,
    Forecast,
    Plan,
    accuracy_by,
    out_of_reach,
    share_of,
    time_needed,
)
from hefting.planning.search import Found, Searcher, effort_named
from hefting.planning.sensors import (
    JointTorques,
    Sensor,
    WristSensor,
    refuse_of_torques,
)
from hefting.planning.space import HalfSpace, Space
from hefting.planning.tours import asked_of_tour, planned_tour
from hefting.robots.robot import Robot
from hefting.shapes import Shape

SEARCHED = 15.0
"""[s] Approximate duration of a motion that is optimised; a longer one repeats it forwards
and backwards, which takes half the time, and seldom ends in a slow local optimum."""
SEARCHED_AGAIN = 6.0
"""[s] The same for a second search, if the accuracy is not reached: shorter motions are
not as good, but seldom end in local optima."""
MOST_SHORT = 3.0
"""Ratio of reached to asked deviations from which on there is no second search: seeds
differ by up to twice."""
RANDOM_STARTS = 12
"""Number of random starts if none is given."""


@immutable
class Planner:
    """Everything that determines a plan, except its duration and effort."""

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

    def reaching(self, duration: float, effort: str) -> tuple[Found, Forecast]:
        """As `planned`, with a second search if the asked accuracy is not expected after
        the first. Raises `InputError` if it is not expected then."""
        planned = self.planned(duration, effort)
        asked, body = self.asked, self.held.body
        if asked is None or asked.met_by(planned[1].accuracy[-1]):
            return planned
        kept = accuracy_by(self.sensor.kept(self.held), body)
        share = share_of(asked, planned[1].accuracy[-1])
        if asked.met_by(kept) and share < MOST_SHORT:
            other = replace(self, seed=self.seed + 1)
            again = other.planned(duration, effort, SEARCHED_AGAIN)
            planned = min(
                planned, again, key=lambda each: share_of(asked, each[1].accuracy[-1])
            )
        best, forecast = planned
        if not asked.met_by(forecast.accuracy[-1]):
            raise out_of_reach(asked, forecast, kept, self._longer(best))
        return planned

    def _longer(self, found: Found) -> Iterator[Forecast]:
        """Forecasts after the motion repeated 2, 4, 8 ... times, up to `LONGEST`."""
        copies, most = 1, int(LONGEST / found.trajectory.duration)
        while copies < most:
            copies = min(2 * copies, most)
            longer = found.trajectory.repeated(copies)
            yield self.sensor.forecast(longer, 1, self.held, self.seed)

    def planned(
        self, duration: float, effort: str, searched: float = SEARCHED
    ) -> tuple[Found, Forecast]:
        """The motion of `duration` [s], repeated from one of about `searched` [s], and its
        forecast; errors as of `plan`, except for the accuracy."""
        rng = np.random.default_rng([self.seed, 7])
        searcher = Searcher(self.robot.joints, self.space, effort_named(effort), rng)
        copies = 1 if self.stop_and_go else max(round(duration / searched), 1)
        problem = self.problem(duration, copies)
        starts = self._starts(problem, searcher)
        best = (
            planned_tour(searcher, problem, starts[0])
            if self.stop_and_go
            else searcher.best(problem, starts)
        )
        motion, instants = best.trajectory.repeated(copies), INSTANTS[effort]
        forecast = self.sensor.forecast(motion, instants, self.held, self.seed)
        return best._replace(trajectory=motion), forecast

    def problem(self, duration: float, copies: int) -> Problem:
        """The problem of one of `copies` motions that last `duration` [s] in all, with
        all joints at zero at the start."""
        vector, tool = self.held.body.vector, self.held.tool
        information = self.sensor.information(vector)
        once = duration / copies
        asked = asked_of_tour(self.asked) if self.stop_and_go else self.asked
        # an error of the gain also applies to the tool
        gain = self.sensor.gain * (1.0 + tool[0] / vector[0])
        corners = np.vstack((np.zeros(3), self.held.corners))
        return Problem(
            Chain.of(self.robot, self.gravity),
            Basis.of(once, pieces_of(once), GRID),
            np.zeros(len(self.limits.speed)),
            self.held.information,
            replace(information, rate=copies * information.rate),
            Objective.of(self.held.body, asked, gain),
            Constraints.of(self.limits, corners, vector + tool, self.space.half_spaces),
        )

    def _starts(self, problem: Problem, searcher: Searcher) -> Array:
        """(s, n) joint positions to start from [rad]."""
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


DURATION = 10.0
"""[s] Default duration of a plan."""
SHORTEST = 1.0
"""[s] Shortest duration of a plan."""
FASTEST = 20.0
"""[m/s] Largest limit of the corners' speed: no arm moves an object as fast."""


def plan(
    urdf: str | Path,
    tip: str,
    *,
    estimate: Estimate | Answered | str | Path | None = None,
    shape: Shape | None = None,
    until: Accuracy | str | None = None,
    duration: float = DURATION,
    speed: float = SPEED_LIMIT,
    start: ArrayLike | None = None,
    noise: Noise | None = None,
    acceleration: ArrayLike | None = None,
    jerk: ArrayLike | None = None,
    force: float | None = None,
    torque: float | None = None,
    keep: Sequence[str | HalfSpace] = (),
    srdf: str | Path | None = None,
    gravity: ArrayLike = STANDARD_GRAVITY,
    rate: float = 100.0,
    torques: bool | ArrayLike = False,
    effort: str = "full",
    stop_and_go: bool = False,
    seed: int = 0,
) -> Plan:
    """The joint motion, at rest at both ends, that leaves the least uncertainty about a
    held object.

    Parameters
    ----------
    urdf : path of the robot's URDF, which has limits of position and speed.
    tip : link whose frame is the sensor's.
    estimate : an earlier `Estimate` of the object, with covariance, or its JSON file, or
        what `hefting.identify` returns.
    shape : shape of the object, in the sensor frame.
    until : accuracy to reach, as in ``mass=1%,com=2mm,inertia=20%``; without it the
        volume of the ellipsoid of uncertainty is minimised.
    duration : of the motion [s].
    speed : limit of every corner of the object's box, and of the sensor's origin [m/s].
    start : (n,) joint positions at the start [rad]; chosen by default.
    noise : standard deviations of the sensor's noise; by default those of the estimate's
        recording, else moderate ones.
    acceleration, jerk : limits of all joints, or of each (n,) [rad/s²], [rad/s³].
    force, torque : range of the sensor along each axis [N], [N m] for the expected
        wrench of the object and of a tool that the estimate excludes.
    keep : half-spaces that links and object stay in, in the axes of the robot's root,
        as in ``["z>=0.05", "x<=0.6"]``.
    srdf : file of the pairs of links that are not checked for collisions.
    gravity : (3,) in the axes of the robot's root [m/s²].
    rate : of the samples that will be recorded [Hz].
    torques : for an arm with measured joint torques and no wrench sensor: True, or
        standard deviations of their noise, of all joints or (n,) of each [N m]. Needs
        a shape, as torques hardly determine an inertia.
    effort : ``"full"``, which with an estimate is ``"next"`` and takes half as long; or
        ``"quick"`` for a plan within some two seconds.
    stop_and_go : rests in a few poses with moves between, for mass and COM alone
        (`hefting.planning.tours`).
    seed : the same seed gives the same plan.

    Raises `InputError` for an unknown tip, missing limits, a start that is out of range
    or in collision, no feasible motion, an accuracy out of reach within `duration`, and
    with `torques` for arguments of a wrench sensor.

    Examples
    --------
    >>> found = hefting.plan("arm.urdf", "tool", duration=2.0, effort="quick")
    >>> found.joints, found.motion.position.shape
    (('turn',), (201, 1))
    """
    _check_numbers(duration, speed, rate, seed)
    if effort == "full" and estimate is not None:
        effort = "next"
    if torques is not False:
        refuse_of_torques(shape, noise, force, torque, stop_and_go)
    asked = Accuracy.parse(until) if isinstance(until, str) else until
    robot = Robot.from_urdf(urdf, tip)
    limits = Limits.from_urdf(urdf, robot, acceleration, jerk, speed, force, torque)
    if estimate is not None:
        estimate = estimate_given(estimate)
    g = check_gravity(gravity)
    sensor: Sensor = (
        WristSensor.of(robot, g, noise, estimate, rate)
        if torques is False
        else JointTorques.of(torques, estimate, rate, urdf, tip, g)
    )
    held = Held.of(estimate, shape)
    space = Space.of(urdf, tip, keep, held.corners, srdf=srdf)
    planner = Planner(
        robot, limits, held, space, sensor, g, start, asked, stop_and_go, seed
    )
    best, forecast = planner.reaching(duration, effort)
    assumed = _assumed(acceleration, jerk)
    messages = (*held.notes, *sensor.notes, *assumed, *space.messages)
    return Plan(
        joints=robot.joints,
        tip=tip,
        source=str(urdf),
        trajectory=best.trajectory,
        limits=limits,
        corners=best.problem.constraints.corners,
        forecast=forecast,
        asked=asked,
        time_needed=None if asked is None else time_needed(forecast, asked),
        usage=best.usage.shares,
        clearance=best.usage.clearance,
        binding=best.usage.binding,
        notes=tuple(each for each in messages if each.severity == "note"),
        warnings=tuple(each for each in messages if each.severity != "note"),
        settings={
            "noise": sensor.levels,
            "gravity": g.tolist(),
            "body": held.body.vector.tolist(),
            "rate": rate,
            "effort": effort,
            "seed": seed,
            "objective": best.value,
        },
    )


def _check_numbers(duration: float, speed: float, rate: float, seed: int) -> None:
    check_number("`duration`", duration, "seconds")
    check_number("`speed`", speed, "m/s")
    check_number("`rate`", rate, "Hz")
    check_number("`seed`", seed, "")
    if not SHORTEST <= duration <= LONGEST:
        what = f"a plan of {duration:g} s is not of {SHORTEST:g} to {LONGEST:g} s"
        raise InputError(what, fix="give another `duration`")
    if not 0.0 < speed < np.inf:
        raise InputError(f"a speed of {speed:g} m/s is not positive", "`speed`")
    if speed > FASTEST:
        what = f"no arm moves what it holds at {speed:g} m/s"
        raise InputError(what, "`speed`", "give m/s, as in 0.25")
    if not 10.0 <= rate <= 10_000.0:
        raise InputError(f"{rate:g} Hz is not of 10 to 10,000 Hz", "`rate`")
    if seed < 0:
        raise InputError(f"{seed} is negative", "`seed`", "give 0 or more")


def _assumed(acceleration: object, jerk: object) -> tuple[Message, ...]:
    """A note of the limits that are not given, which no URDF has."""
    limits = (
        {"acceleration": f"{ACCELERATION:g} rad/s²"} if acceleration is None else {}
    )
    limits |= {"jerk": f"{JERK:g} rad/s³"} if jerk is None else {}
    if not limits:
        return ()
    what = f"a URDF has no such limit: every joint keeps to {' and '.join(limits.values())}"
    return (note("plan-acceleration-assumed", what, next(iter(limits))),)

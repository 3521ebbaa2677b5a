"""The motion to make: planned for what is still uncertain, within limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.immutable import immutable
from hefting.core.measurements import Noise
from hefting.core.messages import Message, note
from hefting.core.spatial import SPEED_LIMIT, STANDARD_GRAVITY, Array, check_gravity
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
"""[s] of a motion that is searched, about: a longer one is such a motion there and back.
Of 30 and 39 s they are found in half the time and leave as little; many that were
searched as a whole were caught in slow turns."""
SEARCHED_AGAIN = 6.0
"""[s] the same where what is asked is not reached so: shorter ones are not as good, but
seldom caught."""
MOST_SHORT = 3.0
"""Times what is asked from which on another search is not tried: plans of 10 s by other
seeds leave an inertia twice as uncertain."""
RANDOM_STARTS = 12
"""Places to start from that are tried where none is given."""


@immutable
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

    def reaching(self, duration: float, effort: str) -> tuple[Found, Forecast]:
        """As `planned`, searched twice where what is asked is not expected at first.
        Raises `InputError` where it is not then."""
        found = self.planned(duration, effort)
        asked, body = self.asked, self.held.body
        if asked is None or asked.met_by(found[1].accuracy[-1]):
            return found
        kept = accuracy_by(self.sensor.kept(self.held), body)
        short = share_of(asked, found[1].accuracy[-1])
        if asked.met_by(kept) and short < MOST_SHORT:
            other = replace(self, seed=self.seed + 1)
            again = other.planned(duration, effort, SEARCHED_AGAIN)
            found = min(
                found, again, key=lambda own: share_of(asked, own[1].accuracy[-1])
            )
        best, forecast = found
        if not asked.met_by(forecast.accuracy[-1]):
            raise out_of_reach(asked, forecast, kept, self._longer(best))
        return found

    def _longer(self, found: Found) -> Iterator[Forecast]:
        """Of the ends of the motion again and again, each time twice as often."""
        copies, most = 1, int(LONGEST / found.trajectory.duration)
        while copies < most:
            copies = min(2 * copies, most)
            longer = found.trajectory.repeated(copies)
            yield self.sensor.forecast(longer, 1, self.held, self.seed)

    def planned(
        self, duration: float, effort: str, searched: float = SEARCHED
    ) -> tuple[Found, Forecast]:
        """The motion of `duration` [s], made of ones of about `searched` [s], and what
        is expected of it; errors as of `plan`, but that of what is asked."""
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
        """The problem of one of so many motions that last `duration` [s] in all, with
        all joints at zero at the start."""
        vector, tool = self.held.body.vector, self.held.tool
        information = self.sensor.information(vector)
        once = duration / copies
        asked = asked_of_tour(self.asked) if self.stop_and_go else self.asked
        # the gain acts on the tool, too
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


DURATION = 10.0
"""[s] of a plan, where nothing is said."""
SHORTEST = 1.0
"""[s] of a plan."""
FASTEST = 20.0
"""[m/s] of a corner: no arm moves what it holds as fast."""


def plan(
    urdf: str | Path,
    tip: str,
    *,
    estimate: Estimate | str | Path | None = None,
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
    """The joint motion, at rest at both ends, that leaves the least of what is still
    uncertain of a held object.

    Parameters
    ----------
    urdf : path of the robot's URDF, which has limits of position and speed.
    tip : link whose frame is the sensor's.
    estimate : what is known now: an `Estimate` with covariance, or its JSON file.
    shape : what is known of the object's shape, in the sensor frame.
    until : what is to be reached, as in ``mass=1%,com=2mm,inertia=20%``; without, the
        volume of the ellipsoid of uncertainty is made least.
    duration : of the motion [s].
    speed : limit of every corner of the object's box, and of the sensor's origin [m/s].
    start : (n,) joint positions from which it starts [rad]; by default it chooses.
    noise : standard deviations of the sensor's noise; by default those of the estimate's
        recording, else moderate ones.
    acceleration, jerk : limits of all joints, or of each (n,) [rad/s²], [rad/s³].
    force, torque : range of the sensor along each axis [N], [N m], which the expected
        wrench of the object keeps, with that of the tool beside which the estimate was
        made.
    keep : half-spaces that links and object stay in, in the axes of the robot's root,
        as in ``["z>=0.05", "x<=0.6"]``.
    srdf : file that says which links not to check against each other.
    gravity : (3,) in the axes of the robot's root [m/s²].
    rate : of the samples that will be recorded [Hz].
    torques : of an arm without a wrench sensor, whose joint torques are measured: True,
        or standard deviations of their noise, of all joints or (n,) of each [N m].
        Needs a shape, as torques hardly tell the inertia.
    effort : ``"full"``; from an estimate ``"next"`` stands for it, which takes half as
        long; or ``"quick"`` for a plan within some two seconds.
    stop_and_go : rests in a few poses with moves between, for mass and COM alone
        (`hefting.planning.tours`).
    seed : the same seed gives the same plan.

    Raises `InputError` for an unknown tip, missing limits, a start that is out of range
    or touches something, no feasible motion, an accuracy out of reach within
    `duration`, and with `torques` for what is of a wrench sensor.

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
    if estimate is not None and not isinstance(estimate, Estimate):
        estimate = Estimate.load(estimate)
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
    told = (*held.notes, *sensor.notes, *assumed, *space.messages)
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
        notes=tuple(own for own in told if own.severity == "note"),
        warnings=tuple(own for own in told if own.severity != "note"),
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
    """What no URDF has."""
    open_ = {"acceleration": f"{ACCELERATION:g} rad/s²"} if acceleration is None else {}
    open_ |= {"jerk": f"{JERK:g} rad/s³"} if jerk is None else {}
    if not open_:
        return ()
    what = f"no URDF limits it: every joint keeps {' and '.join(open_.values())}"
    return (note("plan-acceleration-assumed", what, next(iter(open_))),)

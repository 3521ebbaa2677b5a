"""Plan: a motion to make, and what will be known after it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, astuple, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from hefting.core.accuracy import NAMES, Accuracy
from hefting.core.errors import InputError
from hefting.core.estimate import NORMAL_95, com_jacobian
from hefting.core.estimate_json import json_ready
from hefting.core.immutable import immutable
from hefting.core.inertia import InertialParameters
from hefting.core.messages import Message
from hefting.core.spatial import SPEED_LIMIT, Array, frozen, vector_to_tensor
from hefting.estimators import Bayes
from hefting.planning.held import Held
from hefting.planning.kinematics import Trajectory
from hefting.planning.limits import Limits
from hefting.robots.joint_motion import JointMotion, sensor_motion
from hefting.robots.robot import Robot

SCHEMA = "hefting.plan/1"
"""Name and version of the JSON form, under the key ``schema``."""
RATE = 100.0
"""[Hz] of the samples in `Plan.motion`."""


@immutable
class Forecast:
    """How sure one is expected to be at T instants of the motion, as half-widths of 95 %
    intervals; the first is before it, the last at its end."""

    time: Array
    """(T,) [s]"""
    mass: Array
    """(T,) [kg]"""
    center_of_mass: Array
    """(T, 3) along the sensor's axes [m]"""
    inertia: Array
    """(T, 3, 3) of the inertia about the COM [kg m²]; infinite where it is open"""
    accuracy: tuple[Accuracy, ...]
    """T, as `Accuracy` has it: mass and inertia as shares, the COM in m"""

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "time": self.time,
            "mass": self.mass,
            "center_of_mass": self.center_of_mass,
            "inertia_at_com": self.inertia,
            "accuracy": [asdict(each) for each in self.accuracy],
        }


@dataclass(frozen=True, eq=False)
class Plan:
    """A joint motion, at rest at both ends, and what is expected of it.

    Examples
    --------
    >>> found = hefting.plan("arm.urdf", "tool", duration=2.0, effort="quick")
    >>> max(found.usage.values()) <= 1.0
    True
    >>> found.at([0.0, 2.0]).velocity.round(6).tolist()
    [[0.0], [0.0]]
    """

    joints: tuple[str, ...]
    """n names, in the order of the columns"""
    tip: str
    """link whose frame is the sensor's"""
    source: str
    """path of the URDF"""
    trajectory: Trajectory
    """the motion at any instant"""
    limits: Limits
    """kept at every instant of a 1 kHz grid"""
    corners: Array
    """(c, 3) [m] points in the sensor frame that keep the speed limit: the corners of
    the object's box and the origin"""
    forecast: Forecast
    """how sure one is expected to be"""
    asked: Accuracy | None = None
    """what was to be reached"""
    time_needed: float | None = None
    """[s] after which it is expected to be reached; None where nothing was asked"""
    usage: dict[str, float] = field(default_factory=dict[str, float])
    """largest share of each limit that is used, by its name: ``position``, ``speed``,
    ``acceleration``, ``jerk``, ``corner_speed``, ``force``, ``torque``"""
    clearance: float | None = None
    """[m] least of links and object from each other and from the bounds of half-spaces;
    None where nothing is checked"""
    binding: tuple[Message, ...] = ()
    """which limits bind, and where"""
    notes: tuple[Message, ...] = ()
    """what was assumed"""
    warnings: tuple[Message, ...] = ()
    """what the user should know before moving"""
    settings: dict[str, Any] = field(default_factory=dict[str, Any])
    """noise, gravity, nominal body, seed and other numbers the plan was made with,
    JSON-ready"""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.trajectory.duration

    @property
    def reached(self) -> bool | None:
        """Whether what was asked is expected at the end; None where nothing was."""
        if self.asked is None:
            return None
        return self.asked.met_by(self.forecast.accuracy[-1])

    @cached_property
    def motion(self) -> JointMotion:
        """Sampled at `RATE`, start and end among the samples."""
        return self.trajectory.sampled(RATE)

    def at(self, time: Any) -> JointMotion:
        """The motion at instants (K,) [s]."""
        return self.trajectory.at(time)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready: what was planned, why, and what is expected of it."""
        motion = self.motion
        asked = None if self.asked is None else str(self.asked)
        messages = (*self.warnings, *self.binding, *self.notes)
        return json_ready(
            {
                "schema": SCHEMA,
                "joints": list(self.joints),
                "tip": self.tip,
                "urdf": self.source,
                "duration": self.duration,
                "time": motion.time,
                "position": motion.position,
                "velocity": motion.velocity,
                "acceleration": motion.acceleration,
                "knots": self.trajectory.knots,
                "control_points": self.trajectory.points,
                "forecast": self.forecast.to_dict(),
                "asked": asked,
                "reached": self.reached,
                "time_needed": self.time_needed,
                "usage": self.usage,
                "clearance": self.clearance,
                "messages": [message.to_dict() for message in messages],
                "settings": self.settings,
            }
        )


def corner_speeds(plan: Plan) -> Array:
    """(K,) [m/s] of the fastest of the plan's corners at each instant of its motion.

    The robot is read from `Plan.source`; `InputError` where that is gone.
    """
    robot = Robot.from_urdf(plan.source, plan.tip)
    sensor = sensor_motion(robot, plan.motion)
    return np.max([sensor.linear_speed(corner) for corner in plan.corners], axis=0)


def reduced_speed_told(plan: Plan) -> str:
    """Whether the plan's corners keep reduced speed (ISO 10218-1), as a predicate."""
    fastest = plan.usage.get("corner_speed", 1.0) * plan.limits.corner_speed
    if fastest <= SPEED_LIMIT:
        return "keeps reduced speed"
    return f"is above reduced speed ({speed_told(SPEED_LIMIT)})"


def speed_told(speed: float) -> str:
    """A speed [m/s] as a person reads it."""
    value = 1e3 * speed
    return f"{value:.3g} mm/s" if value < 1e2 else f"{value:.0f} mm/s"


INSTANTS = {"full": 10, "next": 6, "quick": 6}
"""At which is told how sure one is expected to be, besides before the motion."""
SHORTEST = 1.0
"""[s] of a recording from which something is expected."""
DRAWS = 1000
"""Draws from a covariance for an accuracy."""
LEVEL = 0.95


def forecast_by(
    after: Callable[[float, Array | None], Array | None],
    held: Held,
    duration: float,
    instants: int,
) -> Forecast:
    """Before a motion of `duration` [s], and at so many instants of it.

    `after` gives the covariance (10, 10) after so long a part of the motion [s], from
    that before it; None stands for next to nothing. A single instant is the end.
    """
    first = min(SHORTEST, 0.5 * duration) if instants > 1 else duration
    times = np.linspace(first, duration, instants)
    before = _before(held)
    known = [before, *(after(t, before) for t in times)]
    accuracies = [accuracy_by(C, held.body) for C in known]
    widths = [NORMAL_95 * _deviations(C, held.body) for C in known]
    return Forecast(
        frozen([0.0, *times]),
        frozen([own[0] for own in widths]),
        frozen([own[1:4] for own in widths]),
        frozen([vector_to_tensor(own[4:]) for own in widths]),
        tuple(accuracies),
    )


def _before(held: Held) -> Array | None:
    """(10, 10) covariance of what is known now; None where next to nothing is."""
    if held.estimate is not None:
        return np.asarray(held.estimate.covariance)
    if held.shape is None:
        return None
    return Bayes(held.shape).prior_covariance(held.body.mass)


def _deviations(C: Array | None, body: InertialParameters) -> Array:
    """(10,) standard deviations of mass, COM and inertia about it; infinite where
    nothing is known."""
    if C is None:
        return np.full(10, np.inf)
    finite = np.where(np.isfinite(C), C, 0.0)
    J = com_jacobian(body)
    variances = np.einsum("ip,pq,iq->i", J, finite, J)
    open_ones = (J**2) @ np.where(np.isfinite(C.diagonal()), 0.0, 1.0) > 0.0
    return np.where(open_ones, np.inf, np.sqrt(np.maximum(variances, 0.0)))


def accuracy_by(C: Array | None, body: InertialParameters) -> Accuracy:
    """What errors do not exceed with probability `LEVEL`; infinite where open."""
    if C is None:
        return Accuracy(np.inf, np.inf, np.inf)
    values, vectors = np.linalg.eigh(np.where(np.isfinite(C), C, 0.0))
    half = vectors * np.sqrt(np.maximum(values, 0.0))
    normal = np.random.default_rng(0).standard_normal((DRAWS, 10))
    known = Accuracy.of_draws(body.vector + normal @ half.T, body, LEVEL)
    each = zip(astuple(known), np.split(_deviations(C, body), (1, 4)), strict=True)
    return Accuracy(*(own if np.isfinite(std).all() else np.inf for own, std in each))


LONGEST = 120.0
"""[s] of a plan."""
SLACK = 2.0
"""Times the duration by which it may be missed, as motions differ: by six seeds each, a
motion 1.6 times as long still left up to a tenth too much."""


def time_needed(forecast: Forecast, asked: Accuracy) -> float | None:
    """[s] after which what is asked is expected to be reached, linear between the
    instants of the forecast; None where it is not."""
    shares = [share_of(asked, each) for each in forecast.accuracy]
    if shares[0] <= 1.0:
        return 0.0
    for i in range(1, len(shares)):
        if shares[i] <= 1.0:
            before, after = (min(shares[k], 1e3) for k in (i - 1, i))
            part = (before - 1.0) / max(before - after, 1e-12)
            low, high = forecast.time[i - 1 : i + 1]
            return float(low + part * (high - low))
    return None


def out_of_reach(
    asked: Accuracy, forecast: Forecast, kept: Accuracy, longer: Iterable[Forecast]
) -> InputError:
    """The error of an accuracy that is not expected by the end, which says how long it
    would take: as far as `longer` reaches, forecasts of longer and longer motions.

    No motion is better than `kept`. Between two forecasts variances are taken to fall
    as n / T + f.
    """
    lacking = asked.shortfall(forecast.accuracy[-1])
    what = f"out of reach within {forecast.time[-1]:g} s: {lacking}"
    if not asked.met_by(kept):
        what += ", nor by any longer motion: by a sensor's usual accuracy alone "
        return InputError(what + asked.shortfall(kept), fix="ask for less")
    before = forecast
    for after in longer:
        if asked.met_by(after.accuracy[-1]):
            needed = _time_between(before, after, asked)
            first, last = np.ceil((needed - 1e-6, min(SLACK * needed, LONGEST) - 1e-6))
            much = f"{first:.0f} to {last:.0f} s"
            return InputError(what, fix=f"plan for about {much}, or ask for less")
        before = after
    if before is not forecast:
        what += f", nor by this motion again and again for {before.time[-1]:g} s"
    return InputError(what, fix="ask for less, or try a longer one or another `seed`")


def _time_between(before: Forecast, after: Forecast, asked: Accuracy) -> float:
    """[s] at which what is asked is reached between the ends of two forecasts."""
    rates = [1.0 / own.time[-1] for own in (before, after)]
    shares = [share_of(asked, own.accuracy[-1]) for own in (before, after)]
    high, low = np.minimum(shares, 1e3) ** 2
    part = (high - 1.0) / (high - low)
    return float(1.0 / (rates[0] + part * (rates[1] - rates[0])))


def share_of(asked: Accuracy, got: Accuracy) -> float:
    """Largest of what is known over what is asked."""
    shares = [0.0]
    for name in NAMES.values():
        limit, own = getattr(asked, name), getattr(got, name)
        if limit is not None and np.isfinite(limit):
            shares.append(np.inf if own is None else own / limit)
    return float(max(shares))

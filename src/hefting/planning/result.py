"""Plan: a motion to make, and the accuracy that is expected after it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, astuple, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from hefting.core.accuracy import NAMES, Accuracy
from hefting.core.errors import InputError
from hefting.core.estimate import NORMAL_95
from hefting.core.estimate_json import json_ready
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.messages import Message
from hefting.core.spatial import SPEED_LIMIT, Array, frozen, immutable, vector_to_tensor
from hefting.core.undetermined import mapped
from hefting.estimators import Bayes
from hefting.planning.held import BOX_ASSUMED, Held
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
    """Expected half-widths of 95 % intervals at T instants: before the motion, during it,
    and at its end."""

    time: Array
    """(T,) [s]"""
    mass: Array
    """(T,) [kg]"""
    center_of_mass: Array
    """(T, 3) along the sensor's axes [m]"""
    inertia: Array
    """(T, 3, 3) of the inertia about the COM [kg m²]; infinite if undetermined"""
    accuracy: tuple[Accuracy, ...]
    """T of them: relative for mass and inertia, in m for the COM"""

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
    """A joint motion, at rest at both ends, and the accuracy that is expected of it.

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
    """expected accuracy"""
    asked: Accuracy | None = None
    """accuracy to reach, if any"""
    time_needed: float | None = None
    """[s] after which `asked` is expected to be reached"""
    usage: dict[str, float] = field(default_factory=dict[str, float])
    """largest share of each limit that is used, by its name: ``position``, ``speed``,
    ``acceleration``, ``jerk``, ``corner_speed``, ``force``, ``torque``"""
    clearance: float | None = None
    """[m] least distance between links and object, and from the boundaries of half-spaces:
    0.1 stands for 0.1 or more. Not all pairs are checked: see `Space.of`, and `notes`.
    None if none is"""
    binding: tuple[Message, ...] = ()
    """limits that bind, and where"""
    notes: tuple[Message, ...] = ()
    """assumptions"""
    warnings: tuple[Message, ...] = ()
    """to read before moving"""
    settings: dict[str, Any] = field(default_factory=dict[str, Any])
    """noise, gravity, nominal body, seed and other inputs, JSON-ready"""

    @property
    def duration(self) -> float:
        """[s]"""
        return self.trajectory.duration

    @property
    def reached(self) -> bool | None:
        """Whether `asked` is expected to be reached at the end; None without it."""
        if self.asked is None:
            return None
        return self.asked.met_by(self.forecast.accuracy[-1])

    @property
    def box_is_assumed(self) -> bool:
        """Whether `corners` are those of a box that stands for an unknown shape."""
        return any(each.code == BOX_ASSUMED for each in self.notes)

    @cached_property
    def motion(self) -> JointMotion:
        """The motion sampled at `RATE`, including start and end."""
        return self.trajectory.sampled(RATE)

    def at(self, time: Any) -> JointMotion:
        """The motion at instants (K,) [s]."""
        return self.trajectory.at(time)

    def to_dict(self) -> dict[str, Any]:
        """The plan, JSON-ready."""
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
    """(K,) speed [m/s] of the plan's fastest corner at each instant of its motion, with
    the robot of `Plan.source`; `InputError` if that is gone."""
    robot = Robot.from_urdf(plan.source, plan.tip)
    sensor = sensor_motion(robot, plan.motion)
    return np.max([sensor.linear_speed(corner) for corner in plan.corners], axis=0)


def reduced_speed_text(plan: Plan) -> str:
    """Whether the plan's corners keep reduced speed (ISO 10218-1), as a predicate."""
    fastest = plan.usage.get("corner_speed", 1.0) * plan.limits.corner_speed
    if fastest <= SPEED_LIMIT:
        within = " within the assumed box" if plan.box_is_assumed else ""
        return f"keeps reduced speed{within}"
    return f"is above reduced speed ({speed_text(SPEED_LIMIT)})"


def speed_text(speed: float) -> str:
    """A speed [m/s] in mm/s, as text."""
    value = 1e3 * speed
    return f"{value:.3g} mm/s" if value < 1e2 else f"{value:.0f} mm/s"


INSTANTS = {"full": 10, "next": 6, "quick": 6}
"""Number of instants of a forecast after the start, by effort."""
SHORTEST = 1.0
"""[s] Shortest recording for which an accuracy is forecast."""
DRAWS = 1000
"""Number of draws from a covariance for an accuracy."""
LEVEL = 0.95
"""Probability of an accuracy."""


def forecast_by(
    after: Callable[[float, Array | None], Array | None],
    held: Held,
    duration: float,
    instants: int,
) -> Forecast:
    """Forecast before a motion of `duration` [s], and at a number of `instants` of it; a
    single one is the end.

    `after` gives the covariance (10, 10) after a time [s] of the motion, from that
    before it; None stands for an infinite one.
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
    """(10, 10) covariance before the motion; None without estimate and shape."""
    if held.estimate is not None:
        return np.asarray(held.estimate.covariance)
    if held.shape is None:
        return None
    return Bayes(held.shape).prior_covariance(held.body.mass)


def _deviations(C: Array | None, body: InertialParameters) -> Array:
    """(10,) standard deviations of mass, COM and inertia about the COM; infinite where
    they depend on a parameter of infinite variance."""
    if C is None:
        return np.full(10, np.inf)
    return np.sqrt(np.maximum(mapped(C, com_jacobian(body)).diagonal(), 0.0))


def accuracy_by(C: Array | None, body: InertialParameters) -> Accuracy:
    """Bounds that errors of covariance C keep with probability `LEVEL`; infinite ones if
    C is None or infinite."""
    if C is None:
        return Accuracy(np.inf, np.inf, np.inf)
    values, vectors = np.linalg.eigh(np.where(np.isfinite(C), C, 0.0))
    half = vectors * np.sqrt(np.maximum(values, 0.0))
    normal = np.random.default_rng(0).standard_normal((DRAWS, 10))
    known = Accuracy.of_draws(body.vector + normal @ half.T, body, LEVEL)
    each = zip(astuple(known), np.split(_deviations(C, body), (1, 4)), strict=True)
    return Accuracy(*(own if np.isfinite(std).all() else np.inf for own, std in each))


LONGEST = 120.0
"""[s] Longest duration of a plan."""
SLACK = 2.0
"""Upper end of the advised duration over the lower: with six seeds each, motions 1.6
times as long left up to a tenth too much uncertainty."""


def time_needed(forecast: Forecast, asked: Accuracy) -> float | None:
    """[s] after which the accuracy is expected to be reached, by linear interpolation of
    the forecast; None if it is not."""
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
    """The error of an accuracy that is not expected at the end of a plan.

    It advises a duration by forecasts of ever `longer` motions, between which variances
    are assumed to fall as n / T + f with the duration T. No motion is better than
    `kept`.
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
    """[s] at which the accuracy is reached between the ends of two forecasts."""
    rates = [1.0 / each.time[-1] for each in (before, after)]
    shares = [share_of(asked, each.accuracy[-1]) for each in (before, after)]
    high, low = np.minimum(shares, 1e3) ** 2
    part = (high - 1.0) / (high - low)
    return float(1.0 / (rates[0] + part * (rates[1] - rates[0])))


def share_of(asked: Accuracy, got: Accuracy) -> float:
    """Largest ratio of the error bound of a quantity to the asked one."""
    shares = [0.0]
    for name in NAMES.values():
        limit, bound = getattr(asked, name), getattr(got, name)
        if limit is not None and np.isfinite(limit):
            shares.append(np.inf if bound is None else bound / limit)
    return float(max(shares))

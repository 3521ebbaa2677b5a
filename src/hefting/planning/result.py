"""Plan: a motion to make, and what will be known after it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.estimate_json import json_ready
from hefting.core.messages import Message
from hefting.core.spatial import Array
from hefting.planning.limits import Limits
from hefting.planning.trajectory import Trajectory
from hefting.robots.joint_motion import JointMotion, sensor_motion
from hefting.robots.robot import Robot

SCHEMA = "hefting.plan/1"
"""Name and version of the JSON form, under the key ``schema``."""
RATE = 100.0
"""[Hz] of the samples in `Plan.motion`."""


@dataclass(frozen=True, eq=False)
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
            "accuracy": [
                {
                    "mass": each.mass,
                    "center_of_mass": each.center_of_mass,
                    "inertia": each.inertia,
                }
                for each in self.accuracy
            ],
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

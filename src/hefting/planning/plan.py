"""The motion to make: planned for what is still uncertain, within limits."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hefting.core.accuracy import Accuracy
from hefting.core.estimate import Estimate
from hefting.core.measurements import Noise
from hefting.core.spatial import SPEED_LIMIT, STANDARD_GRAVITY
from hefting.planning.half_spaces import HalfSpace
from hefting.planning.result import Plan
from hefting.shapes import Shape

DURATION = 10.0
"""[s] of a plan, where nothing is said."""


def plan(
    urdf: str | Path,
    tip: str,
    *,
    estimate: Estimate | str | Path | None = None,
    shape: Shape | str | Path | None = None,
    until: Accuracy | str | None = None,
    duration: float = DURATION,
    speed: float = SPEED_LIMIT,
    start: Any = None,
    noise: Noise | None = None,
    acceleration: Any = None,
    jerk: Any = None,
    force: float | None = None,
    torque: float | None = None,
    keep: Sequence[str | HalfSpace] = (),
    srdf: str | Path | None = None,
    gravity: Any = STANDARD_GRAVITY,
    rate: float = 100.0,
    effort: str = "full",
    stop_and_go: bool = False,
    seed: int = 0,
) -> Plan:
    """The joint motion, at rest at both ends, that leaves the least of what is still
    uncertain of a held object.

    Parameters
    ----------
    urdf : path of the robot's URDF.
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
    force, torque : range of the sensor along each axis [N], [N m].
    keep : half-spaces that links and object stay in, in the axes of the robot's root,
        as in ``["z>=0.05", "x<=0.6"]``.
    srdf : file that says which links not to check against each other.
    gravity : (3,) in the axes of the robot's root [m/s²].
    rate : of the samples that will be recorded [Hz].
    effort : ``"full"``, or ``"quick"`` for a plan within two seconds.
    stop_and_go : rests in a few poses with moves between, for mass and COM alone
        (`hefting.planning.poses`).
    seed : the same seed gives the same plan.

    Raises `InputError` for an unknown tip, missing limits, a start that is out of range
    or touches something, no feasible motion, and an accuracy out of reach within
    `duration`.
    """
    raise NotImplementedError

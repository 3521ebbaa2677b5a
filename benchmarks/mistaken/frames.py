"""Mistakes with axes: of the sensor, of poses and their form, and of the wrench."""

import numpy as np

from benchmarks.mistaken.catalogue import Add, named
from benchmarks.mistaken_poses import (
    along_y,
    angles,
    composed,
    inverse_pose,
    quaternions,
)
from benchmarks.mistaken_wrenches import about_base, in_base_axes, mapped, signs, turned

TURNED = named("axes-turned")


def add_frames(add: Add) -> None:
    """Axes that are turned, swapped or mirrored, and other forms of a pose."""
    z, diagonal = np.array((0, 0, 1.0)), np.array((1, 1, 1)) / np.sqrt(3.0)
    x = np.array((1.0, 0, 0))
    turns = (5.0, 30.0, 90.0, 180.0)
    add("turned about z", TURNED, {f"{a:.0f}°": turned(z, a) for a in turns})
    turns = (3.0, 45.0, 120.0)
    add(
        "turned about a diagonal",
        TURNED,
        {f"{a:.0f}°": turned(diagonal, a) for a in turns},
    )
    add("turned about x", TURNED, {f"{a:.0f}°": turned(x, a) for a in (10.0, 180.0)})
    add(
        "quaternion order",
        named("quaternion-order"),
        {
            "w first": quaternions(lambda q: np.roll(q, 1, axis=1)),
        },
    )
    add(
        "form of angles",
        named("orientation-form"),
        {
            "roll, pitch, yaw": angles("xyz", "rotation-vector"),
            "ZYZ": angles("ZYZ", "euler", "ZYX"),
            "about turning axes": composed("xyz", "XYZ"),
        },
    )
    add(
        "inverse pose",
        named("pose-inverse"),
        {
            "whole": inverse_pose,
            "orientation": quaternions(lambda q: q * np.array((-1, -1, -1, 1))),
        },
    )
    add(
        "axis flipped",
        named("axis-flipped", "axes-turned", "force-unit"),
        {
            "fx": signs(-1, 1, 1, 1, 1, 1),
            "fz": signs(1, 1, -1, 1, 1, 1),
            "ty": signs(1, 1, 1, 1, -1, 1),
            "tz": signs(1, 1, 1, 1, 1, -1),
            "all torques": signs(1, 1, 1, -1, -1, -1),
            "mirrored": signs(1, -1, 1, 1, -1, 1),
        },
    )
    swap = np.kron(np.array(((0, 1), (1, 0))), np.eye(3))
    xy = np.kron(np.eye(2), np.array(((0, 1, 0), (1, 0, 0), (0, 0, 1))))
    add(
        "columns swapped",
        named("axis-flipped", "axes-turned", "wrong-unit"),
        {
            "x and y": mapped(xy),
            "force and torque": mapped(swap),
        },
    )
    add(
        "force swapped, torque not",
        named("axis-flipped"),
        {"x and y": mapped(np.eye(6)[[1, 0, 2, 3, 4, 5]])},
    )
    apart = named("axes-turned-apart")
    add("force turned alone", apart, {"30°": turned(z, 30.0, 0)})
    add(
        "torque turned alone",
        apart,
        {f"{a:.0f}°": turned(x, a, 1) for a in (15.0, 45.0)},
    )
    add(
        "wrench in base axes",
        named("wrench-in-base-axes"),
        {"": in_base_axes, "about the base": about_base},
    )
    tracked = {"y up": along_y(turned(diagonal, 30.0))}
    add("marker turned, in a world", TURNED, tracked)

"""The mistakes that are tried, each in its strengths."""

from collections.abc import Mapping

import numpy as np

from benchmarks.given import Change, Mistake
from benchmarks.mistaken_loads import (
    elastic_mount,
    gain_by_load,
    hanging,
    sliding,
)
from benchmarks.mistaken_poses import (
    along_y,
    angles,
    another_shape,
    composed,
    frozen,
    gravity,
    imu,
    inverse_pose,
    late,
    lever,
    moved_shape,
    pose_clock,
    position_axes,
    position_glitches,
    positions,
    quaternions,
    rows_lost,
    scaled_shape,
    starts_with_identity,
    tilted,
    time_scaled,
    turned_shape,
)
from benchmarks.mistaken_wrenches import (
    about_base,
    anothers_bias,
    blank,
    cable,
    changing_gradually,
    compensated,
    contact,
    cross_talk,
    dead,
    dropped_while_moving,
    gains,
    gripper,
    in_base_axes,
    local_gravity,
    low_passed,
    mapped,
    play,
    quantised,
    saturated,
    signs,
    sloshing,
    tcp,
    turned,
    unbiased_options,
    units,
    vibrating,
    yielding,
)


def named(*codes: str) -> frozenset[str]:
    return frozenset(codes)


UNSEEN: frozenset[str] = frozenset()
"""Codes of what no data can tell."""
TURNED = named("axes-turned")


def mistakes() -> list[Mistake]:
    """All mistakes, each strength by itself."""
    z, diagonal = np.array((0, 0, 1.0)), np.array((1, 1, 1)) / np.sqrt(3.0)
    x = np.array((1.0, 0, 0))
    found: list[Mistake] = []

    def add(
        name: str,
        codes: frozenset[str],
        strengths: Mapping[str, Change],
        needs_shape: bool = False,
        imu: bool = False,
    ) -> None:
        for strength, make in strengths.items():
            found.append(Mistake(name, strength, make, codes, needs_shape, imu))

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
    add(
        "wrench in base axes",
        named("wrench-in-base-axes"),
        {"": in_base_axes, "about the base": about_base},
    )
    tracked = {"y up": along_y(turned(diagonal, 30.0))}
    add("marker turned, in a world", TURNED, tracked)
    add(
        "bias none",
        named("bias-wrong"),
        {f"{b:g} N": unbiased_options(b) for b in (1.0, 5.0, 20.0)},
    )
    add(
        "another run's bias",
        named("bias-wrong"),
        {f"{b:g} N": anothers_bias(b) for b in (1.0, 3.0, 8.0)},
    )
    add(
        "unit of position",
        named("position-unit"),
        {
            "mm": positions(1e3),
            "cm": positions(1e2),
            "in": positions(1 / 0.0254),
        },
    )
    add(
        "axes of position",
        named("position-axes"),
        {
            "swapped": position_axes((0, 1, 0), (1, 0, 0), (0, 0, 1)),
            "mirrored": position_axes((1, 0, 0), (0, -1, 0), (0, 0, 1)),
            "y up": position_axes((1, 0, 0), (0, 0, 1), (0, -1, 0)),
        },
    )
    wrong_unit = named(
        "force-unit",
        "torque-unit",
        "wrong-unit",
        "com-outside-shape",
        "com-implausible",
    )
    add(
        "unit of force",
        wrong_unit,
        {
            "kgf": units(1 / 9.80665, 1.0),
            "lbf": units(1 / 4.4482, 1.0),
            "g": units(101.97, 1.0),
        },
    )
    add(
        "unit of torque",
        wrong_unit,
        {
            "N mm": units(1.0, 1e3),
            "N cm": units(1.0, 100.0),
            "lbf in": units(1.0, 8.85),
        },
    )
    add(
        "compensated wrench",
        named("wrench-compensated"),
        {f"{s:.0%} of the payload": compensated(s) for s in (0.3, 0.6, 1.0)},
    )
    add(
        "in contact",
        named("contact", "many-outliers", "change-point", "change-touched"),
        {f"{s:.0%}": contact(s) for s in (0.15, 0.35, 0.55)},
    )
    add(
        "gain of all channels",
        UNSEEN,
        {"0.5%": units(1.005, 1.005), "1%": units(1.01, 1.01)},
    )
    add(
        "gain of one axis",
        named("gain-uneven"),
        {f"{g:.0%}": signs(1, 1, 1 + g, 1, 1, 1) for g in (0.03, 0.05, 0.10)},
    )
    add(
        "channel times",
        named("channel-wrong"),
        {"fx, 0.5": signs(0.5, 1, 1, 1, 1, 1), "ty, 2": signs(1, 1, 1, 1, 2, 1)},
    )
    add(
        "dead channel",
        named("channel-wrong"),
        {"fy": dead(1), "tz": dead(5)},
    )
    add(
        "gains of all axes",
        named("gain-uneven", "cross-talk"),
        {f"{s:.1%}": gains(s) for s in (0.004, 0.01, 0.03)},
    )
    add(
        "cross-talk",
        named("cross-talk", "gain-uneven", "axes-turned", "unexplained"),
        {f"{s:.0%}": cross_talk(s) for s in (0.01, 0.03, 0.10)},
    )
    add(
        "play",
        named("hysteresis", "unexplained"),
        {f"{s:.0%}": play(s) for s in (0.01, 0.03, 0.10)},
    )
    add(
        "local gravity",
        UNSEEN,
        {"9.780": local_gravity(9.780), "9.832": local_gravity(9.832)},
    )
    add(
        "low-passed",
        named("wrench-filtered"),
        {f"{f:g} Hz": low_passed(f) for f in (5.0, 2.0, 0.7)},
    )
    levers = named("lever-arm")
    add(
        "flange behind sensor",
        levers,
        {f"{1e3 * d:.0f} mm": lever(d) for d in (0.02, 0.05, 0.15)},
    )
    add(
        "torque about the TCP",
        levers,
        {f"{1e3 * d:.0f} mm": tcp(d) for d in (0.02, 0.05, 0.15)},
    )
    add(
        "position glitches",
        named("pose-glitches", "poses-implausible"),
        {f"{s:g} m": position_glitches(s) for s in (0.1, 10.0, 1e3)},
    )
    add(
        "starts with the identity",
        named("poses-held-at-ends", "pose-glitches", "poses-jump"),
        {f"{n}": starts_with_identity(n) for n in (1, 10, 100)},
    )
    add(
        "frozen poses",
        named("poses-frozen", "contact"),
        {f"{s:g} s": frozen(s) for s in (0.2, 0.5, 1.0)},
    )
    add(
        "pose clock fast",
        named("clock-rate"),
        {f"{r:.1%}": pose_clock(r) for r in (0.003, 0.01, 0.03)},
    )
    add(
        "time",
        named("time-unit"),
        {
            "twice as fast": time_scaled(2.0),
            "half as fast": time_scaled(0.5),
            "in milliseconds": time_scaled(1e3),
        },
    )
    add(
        "rows lost",
        named("rows-lost"),
        {f"{s:.0%}": rows_lost(s) for s in (0.01, 0.05)},
    )
    add(
        "late clock",
        named("clock-offset"),
        {f"{1e3 * s:.0f} ms": late(s) for s in (0.03, 0.1, 0.3)},
    )
    add(
        "base tilted",
        named("base-tilted"),
        {f"{a:.0f}°": tilted(a) for a in (2.0, 5.0, 15.0)},
    )
    add(
        "gravity",
        named("gravity-reversed", "base-tilted", "wrench-sign"),
        {"upwards": gravity(0, 0, 9.80665), "along y": gravity(0, -9.80665, 0)},
    )
    add(
        "quantised",
        named("wrench-quantised"),
        {f"{s:g} N": quantised(s) for s in (0.5, 2.0)},
    )
    add(
        "saturated",
        named("saturation"),
        {f"{s:.0%}": saturated(s) for s in (0.9, 0.6)},
    )
    add("blank", named("wrench-blank"), {f"{s:.0%}": blank(s) for s in (0.03, 0.1)})
    add(
        "cable",
        named("cable-force", "unexplained"),
        {f"{k:g} N/m": cable(k) for k in (1.0, 5.0, 20.0)},
    )
    add(
        "hanging cable",
        named("cable-force"),
        {f"{k:g} kg/m": hanging(k) for k in (0.1, 0.4)},
    )
    by_load = named("gain-by-load")
    add(
        "gain by load",
        by_load,
        {
            f"{k:.1%} per N": gain_by_load(lambda f, k=k: f + k * f * np.abs(f))
            for k in (0.002, 0.006)
        },
    )
    add(
        "soft end of range",
        by_load,
        {
            f"{end:g} N": gain_by_load(lambda f, end=end: end * np.tanh(f / end))
            for end in (20.0, 60.0)
        },
    )
    add(
        "soft mount",
        named("mount-elastic"),
        {f"{d:g}° per N m": elastic_mount(d) for d in (1.5, 4.0)},
    )
    add(
        "vibration",
        named("vibration"),
        {f"{f:g} Hz": vibrating(f, 1.0) for f in (5.0, 12.0)},
    )
    add(
        "sloshing",
        named("sloshing"),
        {f"{s:.0%}": sloshing(s) for s in (0.1, 0.3)},
    )
    events = named(
        "change-point",
        "change-touched",
    )
    add("picked up", events, {"": dropped_while_moving("picked-up", 0.0)})
    add("put down", events, {"": dropped_while_moving("put-down", 0.0)})
    add(
        "swapped",
        events,
        {
            "1.5": dropped_while_moving("swapped", 1.5),
            "0.7": dropped_while_moving("swapped", 0.7),
        },
    )
    add(
        "slipped",
        events,
        {
            "20 mm": dropped_while_moving("slipped", 0.02),
            "60 mm": dropped_while_moving("slipped", 0.06),
        },
    )
    gradual = named("object-changing")
    add(
        "leaks",
        gradual | events,
        {f"{s:.0%}": changing_gradually("leaks", s) for s in (0.1, 0.4, 0.8)},
    )
    add(
        "creeps in the gripper",
        gradual | events,
        {f"{1e3 * d:.0f} mm": changing_gradually("creeps", d) for d in (0.02, 0.06)},
    )
    add(
        "soft grip",
        named("grip-elastic"),
        {f"{1e3 * d:.0f} mm": yielding(d) for d in (0.005, 0.02)},
    )
    add(
        "slides between stops",
        named("grip-elastic", "change-point", "sloshing"),
        {f"{1e3 * d:.0f} mm": yielding(d, sliding) for d in (0.005, 0.02)},
    )
    add(
        "gripper not mentioned",
        UNSEEN,
        {"0.8 kg": gripper(0.8)},
    )
    wrong_shape = named(
        "com-outside-shape",
        "mass-moved-by-shape",
        "misfit",
        "shape-contradicts-wrench",
    )
    add(
        "mesh moved",
        wrong_shape,
        {f"{1e3 * d:.0f} mm": moved_shape(d) for d in (0.02, 0.05, 0.15)},
        needs_shape=True,
    )
    add(
        "mesh turned",
        wrong_shape,
        {f"{a:.0f}°": turned_shape(a) for a in (30.0, 90.0)},
        needs_shape=True,
    )
    add(
        "mesh scaled",
        wrong_shape,
        {f"{f:g}": scaled_shape(f) for f in (0.5, 2.0)},
        needs_shape=True,
    )
    add("another mesh", wrong_shape, {"": another_shape}, needs_shape=True)
    add(
        "accelerometer in g",
        named("accelerometer-contradicts-poses"),
        {"": imu("accelerometer", 1 / 9.80665)},
        imu=True,
    )
    add(
        "gyroscope in °/s",
        named("gyroscope-contradicts-poses"),
        {"": imu("gyroscope", 180 / np.pi)},
        imu=True,
    )
    return found

"""Mistakes with poses and clocks: other points, glitches, times that are late or
scaled, and gravity."""

from benchmarks.mistaken.catalogue import Add, named
from benchmarks.mistaken_poses import (
    frozen,
    gravity,
    late,
    lever,
    pose_clock,
    position_glitches,
    rows_lost,
    starts_with_identity,
    tilted,
    time_scaled,
)
from benchmarks.mistaken_wrenches import tcp


def add_poses(add: Add) -> None:
    """Points, poses, clocks and the direction of gravity."""
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

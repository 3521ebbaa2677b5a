"""Mistakes with readings that are cut off or left out, and with forces that are not
the object's."""

import numpy as np

from benchmarks.mistaken.catalogue import Add, named
from benchmarks.mistaken_loads import elastic_mount, gain_by_load, hanging
from benchmarks.mistaken_wrenches import (
    blank,
    cable,
    quantised,
    saturated,
    sloshing,
    vibrating,
)


def add_forces(add: Add) -> None:
    """Readings that are cut off, cables, gains by load, mounts and vibration."""
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

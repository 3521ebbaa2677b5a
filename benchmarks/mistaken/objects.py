"""Objects that change, move in the gripper, or are not alone."""

from benchmarks.mistaken.catalogue import UNSEEN, Add, named
from benchmarks.mistaken_loads import sliding
from benchmarks.mistaken_wrenches import (
    changing_gradually,
    dropped_while_moving,
    gripper,
    yielding,
)


def add_objects(add: Add) -> None:
    """Objects that are not the same, or not firmly held, from beginning to end."""
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

"""Mistakes of a sensor and its controller: a wrench with less, or more, than the
object's weight, channels with wrong gains, and filters."""

from benchmarks.mistaken.catalogue import UNSEEN, Add, named
from benchmarks.mistaken_wrenches import (
    compensated,
    contact,
    cross_talk,
    dead,
    gains,
    local_gravity,
    low_passed,
    play,
    signs,
    units,
)


def add_sensor(add: Add) -> None:
    """Payloads that are subtracted, contacts, gains, dead channels and filters."""
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

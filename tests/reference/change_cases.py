"""Cases of `hefting.ingest.changes`: one and several changes, small and large, at any
time, beside clock offsets and other faults."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from disturbances import body
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from reference.ingest_cases import understood
from reference.recorded import (
    FAULTS,
    OBJECT,
    changed,
    changing,
    medium,
    recorded,
    stamped_late,
    static_poses,
    wielding,
)

Held = Sequence[tuple[float, InertialParameters]]
"""Times [s] from which on other bodies are held."""
HEAVIER = InertialParameters(1.25 * OBJECT.vector)
"""Evenly heavier."""
BARE = InertialParameters(0.03 * OBJECT.vector)
"""What is left of the object where it was put down."""
MOVED = InertialParameters.from_com(1.2, (0.02, 0.05, 0.03), OBJECT.inertia_at_com)
"""It slipped."""
PUSH = np.array((3.0, -2.0, 4.0, 0.1, 0.15, -0.1))
"""A push [N, N m]."""


def holding(*held: tuple[float, InertialParameters], settles: float = 0.1) -> Recording:
    """9 s of a body, and of others from their times on, each within `settles` [s]."""
    whole = recorded(medium)
    time = np.array(whole["wrench"].time)
    wrench, before = np.zeros((len(time), 6)), OBJECT
    for since, after in held:
        share = np.clip((time - since) / settles, 0.0, 1.0)[:, None]
        change = [
            wielding(medium, each).measurements.wrench for each in (after, before)
        ]
        wrench, before = wrench + share * (change[0] - change[1]), after
    return changed(whole, "wrench", lambda _, w: w + wrench)


def pushed(*spans: tuple[float, float], held: Held = ()) -> Recording:
    """The same with a push from time to time [s] that varies."""

    def push(time: Array, wrench: Array) -> Array:
        inside = sum((time > first) & (time < last) for first, last in spans)
        return wrench + np.outer(inside * (1.0 + 0.4 * np.sin(4.0 * time)), PUSH)

    return changed(holding(*held), "wrench", push)


def loose_poses() -> Recording:
    """Static poses with a wrench that nothing explains."""
    errors = np.random.default_rng(80).normal(size=(24, 6)) * np.repeat((1.5, 0.08), 3)
    return changed(static_poses(), "wrench", lambda _, w: w + errors)


RECORDINGS: dict[str, Callable[[], Recording]] = {
    "heavier": partial(holding, (5.2, HEAVIER)),
    "moved": partial(holding, (3.1, MOVED)),
    "moved slowly": partial(holding, (3.1, MOVED), settles=1.5),
    "put down early": partial(holding, (2.0, BARE)),
    "put down late": partial(holding, (7.6, BARE)),
    "put down and up": partial(holding, (2.6, BARE), (5.9, OBJECT)),
    "away and back": partial(holding, (2.6, HEAVIER), (5.9, OBJECT)),
    "three bodies": partial(
        holding, (2.8, HEAVIER), (5.8, InertialParameters(0.6 * MOVED.vector))
    ),
    "just after the start": partial(holding, (0.6, HEAVIER)),
    "touched twice": partial(pushed, (1.5, 3.0), (5.5, 6.4)),
    "touched at the end": partial(pushed, (7.0, 9.5)),
    "touched for long": partial(pushed, (2.0, 7.5)),
    "touched and slipped": partial(pushed, (4.0, 5.0), held=((4.5, MOVED),)),
    "swapped, late": lambda: stamped_late(changing("swapped"), 0.12),
    "slipped, early": lambda: stamped_late(changing("slipped"), -0.07),
    "touched, late": lambda: stamped_late(changing("touched"), 0.2),
    "swapped, spikes": lambda: changed(
        recorded(medium, replace(FAULTS, spikes=0.02)),
        "wrench",
        lambda t, w: w * np.where(t > 4.0, 1.3, 1.0)[:, None],
    ),
    "another in drift": lambda: changed(
        holding((4.4, body(0.7))), "wrench", lambda t, w: w + np.outer(t, 0.1 * PUSH)
    ),
    "loose poses": loose_poses,
}
"""By what happens."""

CASES: dict[str, Callable[[], Any]] = {
    name: partial(understood, recording) for name, recording in RECORDINGS.items()
}
"""By name."""

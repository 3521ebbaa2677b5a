"""Mistakes with what is given beside poses and wrench: a shape, a gyroscope and an
accelerometer."""

import numpy as np

from benchmarks.mistaken.catalogue import Add, named
from benchmarks.mistaken_poses import (
    another_shape,
    imu,
    moved_shape,
    scaled_shape,
    turned_shape,
)


def add_givens(add: Add) -> None:
    """Shapes of another object, place or size, and units of an IMU."""
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

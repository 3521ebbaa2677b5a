"""Passing on: samples of one stream joined, and joint positions as poses."""

from collections.abc import Sequence

import numpy as np

from hefting.core.recording import Recording, Stream
from hefting.online.samples import Samples
from hefting.robots import Robot, with_poses


def joined(parts: Sequence[Samples]) -> list[Samples]:
    """Samples of one stream, in order of arrival, in as few parts as their widths
    allow; those that are no arrays of (n,) and (n, d) are left as they are."""
    found: list[Samples] = []
    held: list[Samples] = []
    for part in parts:
        if held and _width(part) != _width(held[0]):
            found.append(_one(held))
            held = []
        held.append(part)
    return [*found, _one(held)] if held else found


def poses_of(samples: Samples, robot: Robot) -> list[Samples]:
    """Position and orientation of the sensor by joint positions.

    Raises `InputError` where these are not the robot's.
    """
    # stamps may repeat here: the poses are checked as others are
    order = np.arange(len(samples.time), dtype=float)
    log = Recording({"joint_positions": Stream(order, samples.values)}, source="live")
    posed = with_poses(log, robot)
    return [
        Samples(name, samples.time, posed[name].values)
        for name in ("position", "orientation")
    ]


def _width(samples: Samples) -> int | None:
    values, time = samples.values, samples.time
    fits = values.ndim == 2 and time.ndim == 1 and len(time) == len(values)
    return values.shape[1] if fits else None


def _one(parts: Sequence[Samples]) -> Samples:
    if len(parts) == 1 or _width(parts[0]) is None:
        return parts[0]
    time = np.concatenate([part.time for part in parts])
    return Samples(parts[0].stream, time, np.concatenate([p.values for p in parts]))

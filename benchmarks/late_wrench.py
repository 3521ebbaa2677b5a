"""`python -m benchmarks.late_wrench [--seeds N]`: masses from a wrench that is late by a
delay, or through a low-pass filter.

A simulated UR5 holds a hammer in smooth motion, in quick and in slow moves with rests
between; each recording is identified in parts of 6, 9 and 20 s. A few minutes for eight
seeds.
"""

import argparse
import os
from dataclasses import replace
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from scipy.signal import lsim  # noqa: E402

if TYPE_CHECKING:
    from hefting.core.recording import Recording
    from hefting.core.spatial import Array
    from hefting.simulation import HeldObject, JointMotion

DURATION, RATE = 40.0, 100.0
"""[s, Hz] of a recording."""
PARTS = (6.0, 9.0, 20.0)
"""[s] Lengths of what is identified."""
NOISE = (0.05, 0.05, 0.05, 0.003, 0.003, 0.003)
"""[N (3), N m (3)] Standard deviations of the wrench's noise."""
GRAVITY = (0.0, 0.0, -9.81)
MOTIONS = ("smooth", "quick moves", "slow moves")
LAGS = (
    ("none", 0.0),
    ("delay", 0.4),
    ("filter", 0.1),
    ("filter", 0.2),
    ("filter", 0.4),
)
"""How the wrench is late, and by how much [s]: a filter by its time constant."""


def main() -> None:
    """Print errors and intervals of the mass for each kind of motion and lag."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.late_wrench", description=main.__doc__
    )
    parser.add_argument("--seeds", type=int, default=8, help="of each kind")
    seeds = parser.parse_args().seeds
    print("Mass: median error and half-width of the 95 % interval [%]")
    print(
        f"{'motion':14}{'wrench':14}{'error':>7}{'half':>7}{'95 % hold':>11}{'of':>5}"
    )
    for kind in MOTIONS:
        for lag, size in LAGS:
            found = [
                each for seed in range(seeds) for each in masses(kind, lag, size, seed)
            ]
            errors, halves, held = np.array(found).T
            print(
                f"{kind:14}{f'{lag} {size:g} s':14}{100 * np.median(errors):7.2f}"
                f"{100 * np.median(halves):7.2f}{100 * held.mean():10.0f} %{len(held):5}",
                flush=True,
            )


def masses(
    kind: str, lag: str, size: float, seed: int
) -> list[tuple[float, float, bool]]:
    """Of each part: error and half-width of the mass over the mass, and whether the
    interval holds it; without parts that do not determine it."""
    from hefting import identify
    from hefting.core.errors import HeftingError
    from hefting.core.messages import codes

    held, recording = late(motion(kind, DURATION, seed), lag, size, seed)
    rng, rows = np.random.default_rng(seed), []
    mass, shape = held.parameters.mass, held.points()
    for length in PARTS:
        start = float(rng.uniform(3.0, 18.0))
        part = recording.slice(start, length)
        try:
            found = identify(part, shape=shape, gravity=GRAVITY).estimate
        except HeftingError:
            continue
        if "mass-undetermined" in codes(found.warnings):
            continue
        intervals = found.intervals
        assert intervals is not None
        low, high = intervals["mass"]
        error = abs(found.parameters.mass - mass)
        rows.append((error / mass, 0.5 * (high - low) / mass, low <= mass <= high))
    return rows


def motion(kind: str, duration: float, seed: int) -> "JointMotion":
    """Motion of the joints."""
    from hefting.simulation import random_smooth, trapezoids

    if kind == "smooth":
        return random_smooth(duration, RATE, 0.5, seed=500 + seed)
    moves = (0.8, 2.0) if kind == "quick moves" else (0.2, 0.4)
    return trapezoids(duration, RATE, *moves, seed=500 + seed)


def late(
    joints: "JointMotion", lag: str, size: float, seed: int
) -> "tuple[HeldObject, Recording]":
    """What is held, and its recording with a wrench that is late by a delay or through
    a filter of first order."""
    from hefting.core.recording import Stream
    from hefting.simulation import (
        UR5,
        Faults,
        HeldObject,
        Rates,
        hammer,
        record,
        wield_analytically,
    )
    from hefting.simulation.demo import POSE

    held = HeldObject.of(hammer(), POSE)
    wielding = wield_analytically(UR5, joints, held.parameters)
    recording = record(wielding, Faults(wrench_noise=NOISE), Rates(), seed)
    wrench = recording["wrench"]
    time, values = wrench.time, wrench.values
    if lag == "filter":
        noise = np.random.default_rng(seed).normal(0.0, NOISE, values.shape)
        values = filtered(time, values, size) + noise
    elif lag == "delay":
        time = time + size
    streams = {**recording.streams, "wrench": Stream(time, values, wrench.rows)}
    return held, replace(recording, streams=streams)


def filtered(time: "Array", values: "Array", constant: float) -> "Array":
    """(K, n) through a filter of first order with the time constant `constant` [s], at
    rest before."""
    even = np.linspace(time[0], time[-1], 4 * len(time))
    rest = [np.interp(even, time, column) for column in (values - values[0]).T]
    system = ([1.0], [constant, 1.0])
    smooth = [lsim(system, column, even - even[0])[1] for column in rest]
    return values[0] + np.array([np.interp(time, even, column) for column in smooth]).T


if __name__ == "__main__":
    main()

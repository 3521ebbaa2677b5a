"""`python -m benchmarks.live [FILE ...] [--until ...]`: a recording replayed as a robot would stream it.

Poses and wrenches go in as they were recorded, some milliseconds at a time: poses through a `PoseFilter`, tuned on the
first second, its motion with the wrench of the same instants into `Bayes`. Nothing is known beforehand but gravity, the
wrench's sign and a coarse box; the bias is found with the object. Prints how estimate and interval develop.
"""

import argparse
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np

from hefting.estimate import Estimate
from hefting.estimators import Bayes
from hefting.logs import read_log
from hefting.motion import PoseFilter
from hefting.recording import Recording
from hefting.shapes import PointMasses
from hefting.spatial import Array

TUNING = 1.0
"""Time at the start, in which the filter is tuned [s]; it then sees those samples again."""
PIECE = 50
"""Samples that come at once."""
GRAVITY = (0.0, 0.0, -9.81)
BOX = (-0.15, 0.15, -0.15, 0.15, -0.05, 0.3)
"""What is known of the object: a box [m] in sensor axes."""


@dataclass(frozen=True)
class Stream:
    """Raw samples: time (K,) [s], position (K, 3) [m], orientation (K, 4) xyzw, wrench (K, 6) on the object."""

    time: Array
    position: Array
    orientation: Array
    wrench: Array

    @classmethod
    def of(cls, recording: Recording, sign: float = 1.0) -> "Stream":
        """Of a recording whose poses and wrenches were sampled together."""
        position, orientation, wrench = (recording[name] for name in ("position", "orientation", "wrench"))
        return cls(wrench.time, position.values, orientation.values, sign * wrench.values)


def replayed(stream: Stream, estimator: Bayes, every: float = 0.5) -> Iterator[tuple[float, Estimate]]:
    """Time [s] since the start and the estimate, `every` so many seconds; the last one of all samples."""
    time = stream.time - stream.time[0]
    first = int(np.searchsorted(time, TUNING))
    tuned = PoseFilter.tuned(stream.time[:first], stream.position[:first], stream.orientation[:first])
    state, poses, estimate, due = estimator.start(), tuned.start(), None, every
    for begin in range(0, len(time), PIECE):
        new = slice(begin, begin + PIECE)
        poses, motion = tuned.update(poses, stream.time[new], stream.position[new], stream.orientation[new])
        near = slice(max(begin - 10 * PIECE, 0), begin + PIECE)
        samples = motion.measurements(stream.time[near], stream.wrench[near], GRAVITY)
        state = estimator.update(state, samples)
        now = float(time[min(new.stop, len(time)) - 1])
        if state.samples and (now >= due or new.stop >= len(time)):
            estimate = estimator.estimate(state, start=estimate)
            due += every
            yield now, estimate


def main() -> None:
    """Print one history for each recording."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.live", description=main.__doc__)
    folder = Path(os.environ.get("HEFTING_DATA", "."))
    default = [folder / "panda-optoforce" / f"{run}.csv" for run in ("run1", "run3")]
    parser.add_argument("files", nargs="*", type=Path, default=default)
    parser.add_argument("--until", default="mass=1%,com=2mm,inertia=20%")
    parser.add_argument("--every", type=float, default=0.5, help="s between estimates")
    arguments = parser.parse_args()
    for file in arguments.files:
        stream = Stream.of(read_log(file))
        estimator = Bayes(PointMasses.from_box(*BOX), bias="estimate", until=arguments.until)
        print(f"\n{file.name} until {arguments.until}\n   time    mass   95 % interval      sure to (95 %)")
        stopped = None
        for now, estimate in replayed(stream, estimator, arguments.every):
            assert estimate.intervals is not None
            low, high = estimate.intervals["mass"]
            stopped = now if estimate.sufficient and stopped is None else stopped
            print(f"{now:6.1f} s  {estimate.parameters.mass:6.3f}  {low:6.3f} to {high:6.3f}    {estimate.accuracy}"
                  f"{'   sufficient' if estimate.sufficient else ''}", flush=True)  # fmt: skip
        print("never sufficient" if stopped is None else f"first sufficient after {stopped:.1f} s")


if __name__ == "__main__":
    main()

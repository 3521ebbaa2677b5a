"""A recording as raw samples, replayed in small pieces through a pose filter into an
estimator."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from hefting.estimators import Bayes
from hefting.motion.kalman import PoseFilter

TUNING = 1.0
"""Time at the start, in which the filter is tuned [s]; it then sees those samples
again."""
PIECE = 50
"""Samples that come at once."""
GRAVITY = (0.0, 0.0, -9.81)
BOX = (-0.15, 0.15, -0.15, 0.15, -0.05, 0.3)
"""What is known of the object: a box [m] in sensor axes."""


@dataclass(frozen=True)
class Stream:
    """Raw samples: time (K,) [s], position (K, 3) [m], orientation (K, 4) xyzw, wrench
    (K, 6) on the object."""

    time: Array
    position: Array
    orientation: Array
    wrench: Array

    @classmethod
    def of(cls, recording: Recording, sign: float = 1.0) -> "Stream":
        """Of a recording whose poses and wrenches were sampled together."""
        position, orientation, wrench = (
            recording[name] for name in ("position", "orientation", "wrench")
        )
        return cls(
            wrench.time, position.values, orientation.values, sign * wrench.values
        )


def replayed(
    stream: Stream, estimator: Bayes, every: float = 0.5
) -> Iterator[tuple[float, Estimate]]:
    """Time [s] since the start and the estimate, `every` so many seconds; the last one
    of all samples."""
    time = stream.time - stream.time[0]
    first = int(np.searchsorted(time, TUNING))
    tuned = PoseFilter.tuned(
        stream.time[:first], stream.position[:first], stream.orientation[:first]
    )
    state, poses, estimate, due = estimator.start(), tuned.start(), None, every
    for begin in range(0, len(time), PIECE):
        new = slice(begin, begin + PIECE)
        poses, motion = tuned.update(
            poses, stream.time[new], stream.position[new], stream.orientation[new]
        )
        near = slice(max(begin - 10 * PIECE, 0), begin + PIECE)
        samples = motion.measurements(stream.time[near], stream.wrench[near], GRAVITY)
        state = estimator.update(state, samples)
        now = float(time[min(new.stop, len(time)) - 1])
        if state.samples and (now >= due or new.stop >= len(time)):
            estimate = estimator.estimate(state, start=estimate)
            due += every
            yield now, estimate

"""Playback: where the sensor is, and the wrench, at each instant of a recording."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array, Indices
from hefting.ingest.ingested import Ingested

MOST_FRAMES = 1_200
"""Instants that are drawn at most, evenly chosen: a minute of 20 a second."""
RATE = 20.0
"""Instants a second that are drawn at most."""


@dataclass(frozen=True, eq=False)
class Frame:
    """An instant of a recording."""

    sample: int
    """Index of the sample of the measurements"""
    time: float
    """[s] since the first sample; of static poses their number, from 1"""
    position: Array
    """(3,) of the sensor in the world [m]; zero where the log does not tell it"""
    orientation: Array
    """(4,) x, y, z, w, of the sensor in the world"""
    measured: Array
    """(6,) wrench on the object in sensor axes [N, N m], with the bias"""


class Playback:
    """A recording as it is played: `len` frames, the last one at the last sample.

    Parameters
    ----------
    recording : Recording
        As read, with the sensor's poses.
    found : Ingested
        The same as conditioned; its samples are those that are played.
    """

    def __init__(self, recording: Recording, found: Ingested):
        self.recording, self.found = recording, found
        self.static = found.static
        self.samples = _chosen(found)

    def __len__(self) -> int:
        return len(self.samples)

    @cached_property
    def instants(self) -> Array:
        """(N,) times of the frames on the clock of the measurements [s]."""
        return self.found.measurements.time[self.samples]

    @cached_property
    def times(self) -> Array:
        """(N,) the same since the first sample [s]; of static poses their number, from
        1."""
        if self.static:
            return self.instants + 1.0
        return self.instants - self.found.measurements.time[0]

    def __getitem__(self, index: int) -> Frame:
        sample = int(self.samples[index])
        position, orientation = self.poses
        return Frame(
            sample,
            float(self.times[index]),
            position[index],
            orientation[index],
            self.found.measurements.wrench[sample],
        )

    def instant(self, time: float) -> float:
        """A time as those of `times` on the clock of the measurements [s]."""
        start = -1.0 if self.static else float(self.found.measurements.time[0])
        return start + time

    def nearest(self, time: float) -> int:
        """Index of the frame nearest to a time of `times`."""
        return int(np.argmin(np.abs(self.times - time)))

    @cached_property
    def poses(self) -> tuple[Array, Array]:
        """Position (N, 3) [m] and orientation (N, 4) of the sensor at each frame, those
        that were logged nearest to it."""
        turned = self.at("orientation")
        place = self.at("position")
        return np.zeros((len(self), 3)) if place is None else place, turned  # type: ignore[return-value]

    def at(self, name: str) -> Array | None:
        """Values (N, d) of a stream logged nearest to each frame; None where there is
        no such stream."""
        if not self.recording.has(name):
            return None
        stream = self.recording[name]
        return stream.values[_nearest(stream, self.instants)]

    def bias(self, estimate: Estimate | None) -> Array:
        """(6,) bias of the wrench that an estimate found [N, N m]; zero where it found
        none."""
        known = None if estimate is None else estimate.common_bias
        return np.zeros(6) if known is None else known

    def predicted(self, estimate: Estimate, sample: int) -> Array:
        """(6,) wrench [N, N m] that the object needs at a sample, without bias."""
        z = self.found.measurements[sample : sample + 1]
        return predict_wrench(z, estimate.sensed_vector)[0]

    @cached_property
    def largest(self) -> Array:
        """(2,) largest force [N] and torque [N m] of the measured wrench less a
        constant bias that least squares found."""
        bias = self.found.fit.bias
        wrench = self.found.measurements.wrench - (0.0 if bias is None else bias)
        sizes = np.linalg.norm(wrench.reshape(-1, 2, 3), axis=2).max(axis=0)
        return np.maximum(sizes, 1e-9)


def _chosen(found: Ingested) -> Indices:
    """Samples that are drawn, evenly chosen, with the first and the last."""
    count = len(found.measurements)
    most = MOST_FRAMES
    if not found.static:
        most = min(most, 2 + int(RATE * float(np.ptp(found.measurements.time))))
    chosen = np.linspace(0, count - 1, max(1, min(count, most)))
    return np.unique(chosen.round().astype(np.intp))


def _nearest(stream: Stream, instants: Array) -> Indices:
    """Index of the sample of a stream nearest to each instant."""
    time = stream.time
    after = np.clip(np.searchsorted(time, instants), 1, max(len(time) - 1, 1))
    after = np.minimum(after, len(time) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(instants - time[before] <= time[after] - instants, before, after)

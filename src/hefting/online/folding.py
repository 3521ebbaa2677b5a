"""Folding: samples since a stream was last understood, corrected by that understanding
and added one by one."""

from dataclasses import replace
from typing import Any, Self

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.recording import Stream
from hefting.core.spatial import Array, immutable, interpolated
from hefting.identification.waiting import LONGEST_WRENCH_GAP
from hefting.ingest.drift import Drift
from hefting.ingest.tool import without_tool
from hefting.ingest.weights import weights_by_motion
from hefting.motion import Motion
from hefting.motion.kalman import PoseFilter, State
from hefting.motion.state import motion_from_pieces
from hefting.online.understanding import Understanding

KEPT = 6.0
"""[s] Duration of the motion that is kept."""
FASTER = 1.1
"""Ratio of bandwidths above which a filter is replaced by one that was tuned later."""
OUTLYING = 6.0
"""Residual in standard deviations above which a sample is a spike."""


@immutable
class Follower:
    """Motion of the sensor by a fixed-lag filter."""

    pose_filter: PoseFilter
    state: State
    motion: Motion | None = None
    """Of the last `KEPT` seconds."""

    @classmethod
    def of(cls, pose_filter: PoseFilter) -> Self:
        """Without poses yet."""
        return cls(pose_filter, pose_filter.start())

    def is_too_slow(self, tuned: PoseFilter) -> bool:
        """Whether a later tuned filter is notably faster, as this one was tuned at rest
        or at the beginning of motion."""
        before = self.pose_filter
        return (
            tuned.rotation_bandwidth > FASTER * before.rotation_bandwidth
            or tuned.position_bandwidth > FASTER * before.position_bandwidth
        )

    def with_poses(self, position: Stream | None, orientation: Stream) -> Self:
        """With poses that are later than all before."""
        time = orientation.time
        latest = self.state.latest
        begin = float(time[-1]) - KEPT if latest is None else latest
        end = time[-1] if position is None else position.time[-1]
        new = (time > begin) & (time <= end)
        if position is not None:
            new &= time >= position.time[0]
        if not new.any():
            return self
        place = None
        if position is not None:
            place = interpolated(time[new], position.time, position.values)
        state, motion = self.pose_filter.update(
            self.state, time[new], place, orientation.values[new]
        )
        if not len(motion.time):
            return replace(self, state=state)
        oldest = motion.time[-1] - KEPT
        if self.motion is not None:
            kept = _since(self.motion, oldest)
            time = np.concatenate((kept.time, motion.time))
            motion = motion_from_pieces(time, (kept, motion))
        return replace(self, state=state, motion=motion)

    def samples(
        self, known: Understanding, wrench: Stream, begin: float
    ) -> Measurements | None:
        """Samples after `begin` [s] as the estimator takes them, with the wrench
        corrected; None for none."""
        if self.motion is None or not self.motion.time[-1] > begin:
            return None
        new = _since(self.motion, begin)
        z = _measured(new, *_corrected(known, wrench), known)
        return z if len(z) else None


@immutable
class Folded:
    """An estimate with new samples."""

    estimate: Estimate | None
    state: Any = None
    """of the estimator; None without new samples"""
    last: Any = None
    """start of the next estimate, see `Estimator.prepared`"""


def folded(
    known: Understanding, z: Measurements | None, last: Any, *, prompt: bool
) -> Folded:
    """The estimate with new samples, or unchanged. `last` is the start that the
    previous one left; with `prompt` it is of the same understanding and somewhat fewer
    samples, whose noise is used."""
    before, estimator = known.estimate, known.estimator
    if z is None or not len(z) or before is None:
        return Folded(before, None, last)
    if estimator is None or known.recent is None:
        return Folded(before, None, last)
    z = without_spikes(known, z)
    if not len(z):
        return Folded(before, None, last)
    seen = estimator.update(known.recent, z)  # type: ignore[arg-type]
    try:
        state = estimator.merge_all([*known.others, seen])
        if prompt:
            estimate, last = estimator.of_more(state, last)
        else:
            estimate, last = estimator.continued(state, last or before)
    except (NotIdentifiableError, np.linalg.LinAlgError):
        return Folded(before)
    estimate = replace(
        estimate,
        warnings=before.warnings,
        provenance=before.provenance,
        residual=before.residual,
        undetermined=before.undetermined,
        samples=before.samples + len(z),
        duration=(before.duration or 0.0) + float(z.time[-1]) - known.end,
    )
    return Folded(estimate, state, last)


def without_spikes(known: Understanding, z: Measurements) -> Measurements:
    """The samples whose wrench is near the object's."""
    expected = known.expected
    if expected is None:
        return z
    residual = expected.residual(z)
    off = np.abs(residual - np.median(residual, axis=0)) / expected.noise
    near = np.asarray((off < OUTLYING).all(axis=1))
    return z if near.all() else z[near]


def _since(motion: Motion, begin: float) -> Motion:
    return motion[int(np.searchsorted(motion.time, begin, side="right")) :]


def _corrected(known: Understanding, wrench: Stream) -> tuple[Array, Array]:
    """Times of the motion (N,) and wrench (N, 6) on the object, without known bias."""
    found = known.found
    assert found is not None
    c = found.conditioned
    values = wrench.values
    if found.given_bias is not None:
        values = values - found.given_bias
    elif found.bias == "estimate" and c.bias.kind != "constant":
        values = values - _drifted(c.bias, wrench.time)
    sign = 1.0 if found.sign.on_object else -1.0
    return wrench.time - c.offset, sign * values


def _drifted(bias: Drift, time: Array) -> Array:
    """(N, 6) change of a drifting bias at times (N,) [s], also beyond its last knot."""
    ahead = np.maximum(time - bias.knots[-1], 0.0)[:, None]
    slope = np.diff(bias.values[-2:], axis=0) / np.diff(bias.knots[-2:])
    return bias.change(time) + ahead * slope


def _measured(
    motion: Motion, time: Array, wrench: Array, known: Understanding
) -> Measurements:
    """Samples of a motion, except in the wrench's gaps; weighted, without the tool."""
    found = known.found
    assert found is not None
    after = np.searchsorted(time, motion.time).clip(max=len(time) - 1)
    near = time[after] - time[np.maximum(after - 1, 0)] <= LONGEST_WRENCH_GAP
    inside = near & (motion.time >= time[0]) & (motion.time <= time[-1])
    if not inside.all():
        motion = motion[inside]
    z = motion.measurements(time, wrench, found.conditioned.gravity)
    if not len(z):
        return z
    if found.tool is not None:
        z = without_tool(z, found.tool)
    weights = np.ones(len(z))
    if found.source != "orientation" and len(z) > 1:
        weights = weights_by_motion(found.conditioned, motion) / known.weight
    own = found.motion_noise and z.motion_noise
    return replace(z, weights=weights, motion_noise=own)

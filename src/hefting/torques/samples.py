"""Samples of joint torques with the joints' motion, from a recording; and its rows that
no joint can have sent.

Spikes are single joint angles, torques or currents, of lost or damaged messages, that
differ from their neighbours by more than a joint can move, or load its motor, in that
time. Held rows are repeated by a logger to which no message came.
"""

from __future__ import annotations

import hashlib
from dataclasses import fields, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream, column_names
from hefting.core.spatial import (
    Array,
    Indices,
    Mask,
    immutable,
    interpolated,
    median,
    runs_of,
)
from hefting.motion.curve import Curve
from hefting.robots.joint_motion import named_columns
from hefting.torques.dynamics import JointDynamics

FEWEST = 20
"""Fewest samples of joint positions, and of torques, in a run."""
STICTION_SPEED = 0.05
"""[rad/s] Speed below which the friction of a joint follows no law."""
PRESLIDING = 0.005
"""[rad] Travel after that within which it follows none either: friction builds up over
some mrad, as teeth and bearings give way elastically."""
STREAMS = ("joint_positions", "joint_torques", "joint_currents")
"""Streams of the joints from which torques are identified."""
MOST_IN_A_ROW, LONGEST = 3, 0.06
"""Largest number of samples and duration [s] of a spike: a longer one may be a brief
acceleration."""
SPIKE = 12.0
"""Distance of a spike from the median of its neighbours, in standard deviations of the
noise, from which on it is one."""
HALF_WITHIN = 0.55
"""Median distance of normal noise from that median, in its standard deviations."""
STEP = 90.0, 5.0
"""Percentile of the steps between samples, and the multiple of it that is the least
distance of a spike, above that of motion and of a spike's neighbours."""
LEAST_LOAD = 0.1
"""Least distance of a spike of torque or current, over the standard deviation of the
joint's values."""
BESIDE = 0.1
"""[s] Time before and after a sample over which `moving` measures a joint's motion."""
LARGEST_SHARE = 0.1
"""Share of a joint's samples above which none of them is a spike, or of rows above which
none is held: the noise is then of another kind."""


@immutable
class TorqueSamples:
    """Motion and torques of n joints at K instants."""

    time: Array
    """(K,) [s], increasing"""
    position: Array
    """(K, n) [rad] or [m]"""
    velocity: Array
    """(K, n) [rad/s] or [m/s]"""
    acceleration: Array
    """(K, n) [rad/s²] or [m/s²]"""
    torque: Array
    """(K, n) [N m] or [N], exerted by the motors on the links"""

    @classmethod
    def smoothed(
        cls, joint_time: Array, position: Array, time: Array, torque: Array
    ) -> Self:
        """Samples from joint positions (L, n) at `joint_time` (L,) and torques (K, n) at
        `time` (K,) [s]: each joint's motion is a smoothing spline of its positions.

        Torques outside the time of the positions, or in their gaps, are left out.
        Raises `InputError` for fewer than `FEWEST` samples.
        """
        for kind, many in (("positions", len(joint_time)), ("torques", len(time))):
            if many < FEWEST:
                what = f"{many} samples of joint {kind} are too few"
                raise InputError(what, fix=f"record at least {FEWEST}, moving")
        motion = np.empty((3, *torque.shape))
        for j in range(position.shape[1]):
            own = position[:, j : j + 1]
            if not np.ptp(own):
                motion[:, :, j] = np.array((own[0, 0], 0.0, 0.0))[:, None]
                motion[:, (time < joint_time[0]) | (time > joint_time[-1]), j] = np.nan
                continue
            curve = Curve.fit(joint_time, own, f"position of joint {j + 1}")
            for k, values in enumerate(curve.evaluate(time, spread=False)[:3]):
                motion[k, :, j] = values[:, 0]
        kept = np.isfinite(motion).all(axis=(0, 2))
        if kept.sum() < FEWEST:
            raise InputError(
                "hardly any torque was measured while the joints' positions were"
            )
        position, velocity, acceleration = motion[:, kept]
        return cls(time[kept], position, velocity, acceleration, torque[kept])

    def __getitem__(self, part: slice) -> TorqueSamples:
        return TorqueSamples(*(getattr(self, x.name)[part] for x in fields(self)))

    def averaged(self, starts: Indices) -> TorqueSamples:
        """Averages from each start to the next."""
        each = (getattr(self, x.name) for x in fields(self))
        return TorqueSamples(*(averages(values, starts) for values in each))

    @property
    def sliding(self) -> Mask:
        """(K, n) whether a joint is neither slow nor just started or reversed."""
        q, v = self.position, self.velocity
        slow = np.abs(v) < STICTION_SPEED
        slow[1:] |= v[1:] * v[:-1] < 0.0
        last = np.maximum.accumulate(slow * np.arange(len(v))[:, None])
        return np.abs(q - np.take_along_axis(q, last, axis=0)) > PRESLIDING

    def delayed(self, by: float) -> TorqueSamples:
        """The samples with a delay of the torques removed: each torque belongs to the
        motion `by` seconds before it."""
        time = self.time - by
        kept = (time >= self.time[0]) & (time <= self.time[-1])
        position, velocity, acceleration = (
            interpolated(time[kept], self.time, each)
            for each in (self.position, self.velocity, self.acceleration)
        )
        return TorqueSamples(
            self.time[kept], position, velocity, acceleration, self.torque[kept]
        )

    @property
    def digest(self) -> str:
        """Hash of the torques, which identifies a run."""
        return hashlib.sha256(self.torque.tobytes()).hexdigest()[:16]

    @property
    def interval(self) -> float:
        """[s] Median time between samples."""
        return median(np.diff(self.time))

    def bins(self, rate: float) -> Indices:
        """Index of the first sample in each interval of 1 / `rate` [s] with samples; of
        every sample if they are not faster."""
        if self.interval * rate > 0.7:
            return np.arange(len(self.time))
        number = np.floor((self.time - self.time[0]) * rate + 1e-6)
        return np.flatnonzero(np.diff(number, prepend=-1.0))


def averages(values: Array, starts: Indices) -> Array:
    """Averages of values (L, ...) from each start to the next."""
    if len(starts) == len(values):
        return values
    counts = np.diff(np.append(starts, len(values)))
    return (np.add.reduceat(values, starts, axis=0).T / counts).T


UR_JOINT = "shoulder_pan_joint"
"""Name of a joint that identifies a Universal Robots driver, whose efforts are currents
by default."""
LEAST_TURN = 0.02
"""[rad] Range of positions below which a joint does not move."""


def samples_of(
    recording: Recording, dynamics: JointDynamics, gains: ArrayLike | None = None
) -> TorqueSamples:
    """Motion and torques of the joints of `dynamics` in a recording.

    With `gains` [N m/A], (n,) or one number for all, the recorded values are motor
    currents. Raises `InputError` if positions or torques are missing or of other joints,
    or currents have no gains.
    """
    names = named_columns(recording, dynamics.robot)
    stream = _torques(recording, gains)
    columns = [names[name] for name in dynamics.names]
    q = recording["joint_positions"]
    torque = recording[stream].values[:, columns]
    if gains is not None:
        torque = torque * _checked(gains, len(columns), recording.source)
    turns = [s.column for s in dynamics.robot.screws if not s.slides]
    position = q.values[:, columns]
    # recorded angles may be wrapped to half a turn
    position[:, turns] = np.unwrap(position[:, turns], axis=0)
    time = recording[stream].time
    return TorqueSamples.smoothed(q.time, position, time, torque)


def still_joints(
    samples: TorqueSamples, dynamics: JointDynamics, source: str
) -> tuple[Message, ...]:
    """A warning about joints that never move, if any."""
    ranges = np.ptp(samples.position, axis=0)
    names = [n for n, by in zip(dynamics.names, ranges, strict=True) if by < LEAST_TURN]
    if not names:
        return ()
    what = f"{source}: {', '.join(names)} never moves: its torque is not used, as its friction is not known"
    return (warning("joint-still", what),)


def _torques(recording: Recording, gains: ArrayLike | None) -> str:
    """Name of the stream of torques or of currents with gains; `InputError` without."""
    source = recording.source
    if recording.has("joint_torques"):
        if UR_JOINT in recording.joint_names and gains is None:
            raise InputError(
                "efforts of a UR driver are currents unless use_currents_as_efforts is "
                "false, and then without the gravity of the configured payload",
                source,
                "give `torque_gains` [N m/A], or 1 where they are torques and no "
                "payload is configured",
            )
        return "joint_torques"
    if recording.has("joint_currents"):
        if gains is None:
            fix = "give `torque_gains`, one for each joint [N m/A]"
            raise InputError("the motors' currents are in amperes", source, fix)
        return "joint_currents"
    raise InputError(
        "there are no joint torques",
        source,
        "record them in columns tau1..taun, as effort of JointState or as "
        "actual_current, or name their columns in a column map (`column_map`)",
    )


def _checked(gains: ArrayLike, joints: int, source: str) -> Array:
    """Gains (n,) or (1,); `InputError` for another number, a zero or no finite one."""
    values = np.atleast_1d(np.asarray(gains, dtype=float))
    if values.shape not in ((1,), (joints,)) or not np.isfinite(values).all():
        what = f"{len(values)} gains for {joints} joints"
        raise InputError(what, source, "give one for each")
    if not values.all():
        raise InputError("a gain is zero", source, "give N m/A of each joint")
    return values


def without_spikes(recording: Recording) -> Recording:
    """The recording with each spike of the joints' streams replaced by the median of its
    neighbours, and a note of their number."""
    streams, counted = dict(recording.streams), list[str]()
    for name in filter(recording.has, STREAMS):
        values, time = streams[name].values, streams[name].time
        interval = median(np.diff(time)) if len(time) > 1 else np.inf
        many = min(MOST_IN_A_ROW, int(LONGEST / interval + 1e-6))
        if not many:
            continue
        least = 0.0 if name == "joint_positions" else LEAST_LOAD * values.std(axis=0)
        medians, spiky = spikes(values, many, least)
        if name != "joint_positions" and "joint_positions" in streams:
            spiky &= moving(streams["joint_positions"], time)
        if spiky.any():
            labels = recording.joint_names or column_names(name, values.shape[1])
            counts = zip(spiky.sum(axis=0).tolist(), labels, strict=True)
            each = ", ".join(f"{count} of {label}" for count, label in counts if count)
            counted.append(f"{name.replace('_', ' ')} ({each})")
            values = np.where(spiky, medians, values)
            streams[name] = replace(streams[name], values=values)
    if not counted:
        return recording
    what = (
        f"{recording.source}: {' and '.join(counted)} stand out from those just before and "
        "after: replaced by the median of these"
    )
    messages = (*recording.warnings, note("joint-spikes", what))
    return replace(recording, streams=streams, warnings=messages)


def moving(position: Stream, time: Array) -> Mask:
    """(K, n) whether joints are on their way at `time` (K,) [s]. They are not at
    reversals, where friction changes at once, nor at rest, where torques are unused."""
    before, after = (
        interpolated(t, position.time, position.values)
        for t in (time - BESIDE, time + BESIDE)
    )
    return np.abs(after - before) > 2.0 * BESIDE * STICTION_SPEED


def spikes(values: Array, many: int, least: Array | float) -> tuple[Array, Mask]:
    """(K, n) running medians of `values` (K, n), and (K, n) whether a value is a spike:
    of up to `many` samples, and farther than `least` (n,) from its median."""
    # SciPy's filters take long to import
    from scipy.ndimage import median_filter

    medians = median_filter(values, (2 * many + 1, 1), mode="mirror")
    distance = np.abs(values - medians)
    noise = np.median(distance, axis=0) / HALF_WITHIN
    steps = np.percentile(np.abs(np.diff(values, axis=0)), STEP[0], axis=0)
    spiky = distance > np.maximum(SPIKE * noise, np.maximum(STEP[1] * steps, least))
    return medians, spiky & (spiky.mean(axis=0) <= LARGEST_SHARE)


def without_held(recording: Recording) -> Recording:
    """The recording without rows of the joints' streams that a logger repeated while no
    message came, and a note of their number."""
    streams, counted = dict(recording.streams), list[str]()
    for name in filter(recording.has, STREAMS):
        values, time = streams[name].values, streams[name].time
        repeated = held(values, time, name == "joint_positions")
        if repeated.any():
            counted.append(f"{repeated.sum()} of {len(time)} {name.replace('_', ' ')}")
            streams[name] = Stream(time[~repeated], values[~repeated])
    if not counted:
        return recording
    what = (
        f"{recording.source}: {' and '.join(counted)} repeat the row before: left out"
    )
    messages = (*recording.warnings, note("joint-held", what))
    return replace(recording, streams=streams, warnings=messages)


def held(values: Array, time: Array, may_rest: bool) -> Mask:
    """(K,) whether rows of `values` (K, n) repeat those before for longer than `LONGEST`.

    Values that `may_rest` must jump after it, or repeat at an end of the recording,
    where samples at rest are of no use.
    """
    steps = np.abs(np.diff(values, axis=0))
    same = (steps == 0.0).all(axis=1)
    repeated = np.zeros(len(values), dtype=bool)
    # if most rows repeat, the logger is faster than the messages
    if not 0.0 < same.sum() < 0.5 * len(same):
        return repeated
    jump = STEP[1] * np.percentile(steps[~same], STEP[0], axis=0)
    for begin, end in runs_of(same):
        at_end = begin == 0 or end == len(steps)
        is_held = not may_rest or at_end or bool((steps[end] > jump).any())
        if is_held and time[end] - time[begin] > LONGEST:
            repeated[begin : end + 1] = True
    return repeated & (repeated.mean() <= LARGEST_SHARE)

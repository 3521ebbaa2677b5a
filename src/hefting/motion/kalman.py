"""Live motion from poses: a fixed-lag Kalman filter.

Each component of the position, and of the orientation's quaternion, is four integrators
of white snap (order "snap") or three of white jerk (order "acceleration": the
constant-acceleration model of Farsoni et al. 2017).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.motion.bspline import Observation
from hefting.motion.fixed_lag import OUTPUT_STATES, Steady, Track, steady_filter
from hefting.motion.spline import aligned, check_poses
from hefting.motion.state import Motion, motion_from_channels
from hefting.motion.tuning import tune

NUMBER_OF_STATES = {"snap": 4, "acceleration": 3}
"""Number of integrators of a component, by `PoseFilter.order`."""
LARGEST_STD_RATIO = 3.0
"""Standard deviation of the acceleration over its steady value, below which samples are
returned."""
LONGEST_GAP = 20.0
"""[1/bandwidth] Gap between samples above which the filter is restarted."""
SMALLEST_BLOCK = 2
"""Smallest number of regular samples that are filtered together, which then is
faster."""
LARGEST_BLOCK = 50_000
"""Largest number of regular samples that are filtered together, to bound the memory."""
MOST_LAG = 100_000
"""Largest lag in samples: 0.1 s at 1 MHz. Each takes some 10 microseconds and 300 bytes
when the filter is made."""


@dataclass(frozen=True)
class State:
    """State of a `PoseFilter` between samples."""

    time: Array
    """(P,) [s] Times of the samples whose motion was not yet returned."""
    latest: float | None = None
    """[s] Time of the last sample."""
    quaternion: Array | None = None
    """(4,) Last measured orientation, xyzw."""
    tracks: tuple[Track, ...] = ()
    """Filter of the rotation, then that of the position if it is measured."""


@dataclass(frozen=True)
class PoseFilter:
    """Fixed-lag Kalman filter from poses to velocities and accelerations, for live use.

    state = filter.start()
    state, motion = filter.update(state, time, position, orientation)

    The motion returned is that of samples `lag` ago: pair each with the wrench measured
    at its time. The first motion is returned once the accelerations are accurate
    enough, 0.1 to 0.25 s after the start.

    Examples
    --------
    >>> log = hefting.read_log("demo/log.csv")
    >>> time, position = log["position"].time, log["position"].values
    >>> orientation = log["orientation"].values
    >>> live = hefting.PoseFilter.tuned(time[:100], position[:100], orientation[:100])
    >>> state, motion = live.update(live.start(), time, position, orientation)
    >>> bool(motion.time[-1] < time[-1] - 0.09)
    True
    """

    period: float = 0.01
    """[s] Nominal interval between samples. Other intervals are treated exactly too;
    samples within 0.1 % of it are processed together, which is much faster."""
    position_noise: float = 1e-4
    """[m] Standard deviation of the measured position along each axis."""
    rotation_noise: float = 3.5e-4
    """[rad] Standard deviation of the measured orientation about each axis."""
    position_bandwidth: float = 25.0
    """[rad/s] wc of the position: the driving noise has intensity r² period wc^(2n)."""
    rotation_bandwidth: float = 25.0
    """[rad/s] wc of the orientation."""
    lag: float = 0.1
    """[s] Delay of the motion returned. With 0 the filter is causal, and ten times less
    accurate."""
    order: Literal["snap", "acceleration"] = "snap"
    """Driving noise: white snap (four states), or white jerk (three states)."""
    cold_start: bool = False
    """Whether to start at rest with the gains of the settled filter and to return every
    sample, as a plain filter started inside a short recording does. The standard
    deviations are then far too small at first."""

    def __post_init__(self):
        positive = (
            "period",
            "position_noise",
            "rotation_noise",
            "position_bandwidth",
            "rotation_bandwidth",
        )
        for name in positive:
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise InputError(
                    f"is {getattr(self, name)}, not positive",
                    where=f"PoseFilter.{name}",
                )
        if not (np.isfinite(self.lag) and self.lag >= 0):
            raise InputError(
                f"is {self.lag}, not zero or more seconds", where="PoseFilter.lag"
            )
        if self.order not in NUMBER_OF_STATES:
            raise InputError(
                f"is {self.order!r}",
                where="PoseFilter.order",
                fix="choose 'snap' or 'acceleration'",
            )

    @classmethod
    def tuned(
        cls,
        time: ArrayLike,
        position: ArrayLike | None,
        orientation: ArrayLike,
        **options,
    ) -> PoseFilter:
        """The filter whose noise and bandwidth have the largest likelihood.

        Parameters
        ----------
        time : ArrayLike
            (K,) [s] of a part of the recording.
        position : ArrayLike or None
            (K, 3) [m].
        orientation : ArrayLike
            (K, 4) xyzw.
        **options
            Other fields of `PoseFilter`; they replace the values found.

        Raises
        ------
        InputError
            As `hefting.motion.spline.smooth` does.
        """
        time, position, orientation = check_poses(time, position, orientation)
        n = NUMBER_OF_STATES[options.get("order", "snap")]
        found: dict[str, float] = {}
        for name, values, scale in (
            ("rotation", aligned(orientation), 2.0),
            ("position", position, 1.0),
        ):
            if values is not None:
                smoothness, _, dt, _ = tune((Observation(time, values),), (n,), name)
                # one period for both: the noise's intensity r² period wc^(2n) is kept
                period = found.setdefault("period", dt)
                bandwidth = smoothness.bandwidth * (dt / period) ** (0.5 / n)
                found[f"{name}_noise"] = scale * float(np.sqrt(smoothness.variance))
                found[f"{name}_bandwidth"] = float(bandwidth)
        return cls(**{**found, **options})

    def start(self) -> State:
        """The state before the first sample."""
        return State(time=np.empty(0))

    def update(
        self,
        state: State,
        time: ArrayLike,
        position: ArrayLike | None,
        orientation: ArrayLike,
    ) -> tuple[State, Motion]:
        """Process one or more samples; return the motion of samples at least `lag` old.

        The result does not depend on the division of the samples into calls.

        Parameters
        ----------
        state : State
            From `start` or the last call.
        time : ArrayLike
            (K,) [s], later than all times before.
        position : ArrayLike or None
            (K, 3) [m], or None in every call.
        orientation : ArrayLike
            (K, 4) xyzw.

        Raises
        ------
        InputError
            If the shapes of the arrays disagree or the times do not increase.
        """
        time, position, orientation = check_poses(time, position, orientation)
        _check_continues(state, time, position)
        q = aligned(orientation, state.quaternion)
        groups = (q,) if position is None else (q, position)
        results: list[tuple[Array, list[tuple[Array, Array]]]] = []
        before = np.nan if state.latest is None else state.latest
        intervals = np.diff(time, prepend=before)
        is_regular = np.abs(intervals - self.period) <= 1e-3 * self.period
        irregular = np.flatnonzero(~is_regular)
        first = 0
        while first < len(time):
            following = irregular[np.searchsorted(irregular, first) :]
            end = int(following[0]) if len(following) else len(time)
            end = min(end, first + LARGEST_BLOCK)
            if end - first >= SMALLEST_BLOCK and self._is_steady(state):
                piece = slice(first, end)
                tracks = self._filter_block(state, [each[piece] for each in groups])
            else:
                piece = slice(first, first + 1)
                rows = [values[first] for values in groups]
                tracks = self._step(state, rows, float(intervals[first]))
                if tracks is None:  # restart; later samples cannot improve these
                    state = self._return_samples(state, len(state.time), results)
                    tracks = self._start_tracks(rows)
            latest = float(time[piece][-1])
            pending = np.append(state.time, time[piece])
            state = State(pending, latest, q[piece][-1], tracks)
            old_enough = latest - self.lag + 0.49 * self.period
            ready = int(np.searchsorted(state.time, old_enough, side="right"))
            state = self._return_samples(state, ready, results)
            first = piece.stop
        return state, self._motion(results, position is not None)

    def _filter_block(self, state: State, groups: list[Array]) -> tuple[Track, ...]:
        """The settled tracks after samples at regular times: orientations (n, 4), and
        positions (n, 3) [m] if there are any."""
        return tuple(
            track.block(values / noise, steady)
            for track, values, (noise, _, steady) in zip(
                state.tracks, groups, self._channels(), strict=False
            )
        )

    def _channels(self) -> tuple[tuple[float, float, Steady], ...]:
        """Noise of one component, bandwidth [rad/s] and settled filter of the rotation,
        then of the position."""
        lag = max(ceil(self.lag / self.period - 0.49), 0)
        if lag > MOST_LAG:
            what = f"the filter's lag of {self.lag:g} s is {lag:.3g} samples"
            raise InputError(what, fix="are times in seconds? or use `motion` smooth")
        n = NUMBER_OF_STATES[self.order]
        return tuple(
            (noise, wc, steady_filter(n, wc * self.period, lag))
            for noise, wc in (
                (0.5 * self.rotation_noise, self.rotation_bandwidth),
                (self.position_noise, self.position_bandwidth),
            )
        )

    def _is_steady(self, state: State) -> bool:
        channels = self._channels()
        return bool(state.tracks) and all(
            t.is_steady(c[2]) for t, c in zip(state.tracks, channels, strict=False)
        )

    def _start_tracks(self, rows: list[Array]) -> tuple[Track, ...]:
        n = NUMBER_OF_STATES[self.order]
        return tuple(
            Track.start(row / noise, n, steady if self.cold_start else None)
            for row, (noise, _, steady) in zip(rows, self._channels(), strict=False)
        )

    def _step(
        self, state: State, rows: list[Array], interval: float
    ) -> tuple[Track, ...] | None:
        """The tracks after one sample, `interval` [s] after the last one; None after too
        long a gap."""
        if not state.tracks:
            return self._start_tracks(rows)
        if (
            interval * min(self.rotation_bandwidth, self.position_bandwidth)
            > LONGEST_GAP
        ):
            return None
        return tuple(
            track.step(row / noise, interval * wc, self.period * wc)
            for track, row, (noise, wc, _) in zip(
                state.tracks, rows, self._channels(), strict=False
            )
        )

    def _return_samples(self, state: State, count: int, results: list) -> State:
        """Move the first `count` pending samples from the state to `results`, if they
        are accurate enough."""
        if count == 0:
            return state
        usable = np.ones(count, dtype=bool)
        if not self.cold_start:
            for track, (_, _, steady) in zip(
                state.tracks, self._channels(), strict=False
            ):
                usable &= (
                    track.variances[:count, 2]
                    <= LARGEST_STD_RATIO**2 * steady.variances[-1, 2]
                )
        pieces = [
            (track.past[:count][usable], track.variances[:count][usable])
            for track in state.tracks
        ]
        results.append((state.time[:count][usable], pieces))
        return replace(
            state,
            time=state.time[count:],
            tracks=tuple(t.drop(count) for t in state.tracks),
        )

    def _motion(self, results: list, with_position: bool) -> Motion:
        time = np.concatenate([np.empty(0)] + [piece[0] for piece in results])
        channels, widths = [], (4, 3) if with_position else (4,)
        for i, (d, (noise, wc, _)) in enumerate(
            zip(widths, self._channels(), strict=False)
        ):
            units = noise * wc ** np.arange(OUTPUT_STATES)
            none = np.empty((0, OUTPUT_STATES, d)), np.empty((0, OUTPUT_STATES))
            pieces = zip(none, *(piece[1][i] for piece in results), strict=True)
            past, variances = (np.concatenate(each) for each in pieces)
            past, std = past * units[:, None], np.sqrt(variances) * units
            channels.append((past[:, 0], past[:, 1], past[:, 2], std[:, 1], std[:, 2]))
        linear = (*channels[1][:3], channels[1][4]) if with_position else None
        bandwidth = self.rotation_bandwidth
        if with_position:
            bandwidth = np.sqrt(bandwidth * self.position_bandwidth)
        return motion_from_channels(time, linear, channels[0], bandwidth)


def _check_continues(state: State, time: Array, position: Array | None) -> None:
    """`InputError` for samples that are not later than those before, or that have
    positions where these had none, or none where these had."""
    if state.latest is not None and len(time) and time[0] <= state.latest:
        raise InputError(
            f"{time[0]:.6g} s is not later than the last sample's {state.latest:.6g} s",
            where="time",
        )
    if state.tracks and (position is None) != (len(state.tracks) == 1):
        raise InputError(
            "position was given at some times and not at others", where="position"
        )

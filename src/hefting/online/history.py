"""History: the recent samples, averaged and bounded, as a recording; and all samples as
they came, for the final answer, while they fit in memory."""

from collections import Counter

import numpy as np

from hefting.core.errors import InputError
from hefting.core.magnitudes import in_order
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask
from hefting.logs.growing import Growing
from hefting.logs.orientations import with_given_sensor_pose
from hefting.online.samples import Samples, arrays_of, joined, possible
from hefting.online.series import Series

MOST_ROWS = 6_000
"""Largest number of rows of a stream: 30 s at 200 Hz, which take some 0.7 s to
understand. Beyond, the older half is cut off and condensed."""
BACKWARD, FORWARD = 1.0, 60.0
"""[s] Largest steps of stamps back and ahead within one clock: messages out of order or
after an interruption make smaller ones."""
CONFIRMED = 10
"""Number of successive samples of another clock from which on it is accepted; fewer are
bad messages."""
STRAGGLERS, NEAR = 2.0, 0.5
"""[s] Distance from the last stamp before a clock jumped within which stamps are of the
earlier clock, unless they are within the second distance of the newest stamp since."""

LONGEST_AHEAD = 1.0
"""[s] Largest silence of other streams that one part of a stream counts as, since after
an interruption, or with long parts, the others are on their way."""

MOST_NUMBERS = 1_000_000
"""Most numbers that are kept: 8 MB, one minute of wrench and poses at 1 kHz."""


class History:
    """The recent samples of all streams."""

    def __init__(self, sensor_pose: Array | None = None):
        self.sensor_pose = sensor_pose
        self.series: dict[str, Series] = {}
        self.skipped: Counter[str] = Counter()
        """Samples that were left out, by reason."""
        self.kept = Kept()
        self.samples = 0
        """Number of all samples."""
        self.latest = -np.inf
        """[s] Newest stamp of any stream."""
        self.silence: dict[str, float] = {}
        """[s] Advance of other streams since the last sample of each stream."""
        self.set_back: Message | None = None
        """Warning of a clock that was set back by too little to count as another one."""
        self._recent: dict[str, Samples] = {}
        self._before_jump: dict[str, float] = {}
        self._begun = -np.inf
        """[s] First stamp of the clock accepted after a jump."""
        self._far = 0
        self._leaps: dict[str, tuple[float, int]] = {}
        """Last stamp of each stream, and number of the latest steps above `FORWARD`."""

    def checked(self, samples: Samples) -> Samples | None:
        """The samples with possible values, None if they are of no stream; others are
        counted.

        Raises `InputError` for a stream whose every sample would be of another clock.
        """
        name, arrays = samples.stream, arrays_of(samples)
        if arrays is None:
            self.skipped["of no stream"] += max(np.size(samples.time), 1)
            return None
        self._check_unit(name, arrays[0][np.isfinite(arrays[0])])
        good = possible(name, *arrays, self.skipped)
        return Samples(name, arrays[0][good], arrays[1][good])

    def add(self, samples: Samples) -> Message | None:
        """Add samples that were checked.

        Returns
        -------
        Message or None
            If the clock jumped. Nothing was added: first take the present samples
            (`take_all`), then add these again.
        """
        name, time, values = samples
        own = self._of_this_clock(name, time)
        near, jumped = self._jump(name, time[own])
        if jumped is not None:
            self._far = 0
            return jumped
        self._count("of the clock before", ~own)
        self._count("of another clock", ~near)
        time, values = time[own][near], values[own][near]
        if len(time):
            advances = self._advances(name, time, values)
            self._count("stamped again", ~advances)
            time, values = time[advances], values[advances]
        self.samples += len(time)
        if len(time):
            self._append(Samples(name, time, values))
        return None

    def _append(self, samples: Samples) -> None:
        """Add samples that come after those of their stream, and tell how long the other
        streams have been silent since."""
        series = self._series(samples.stream)
        series.add(samples.time, samples.values)
        ahead = min(max(series.latest - self.latest, 0.0), LONGEST_AHEAD)
        self.silence = {name: since + ahead for name, since in self.silence.items()}
        self.silence[samples.stream] = 0.0
        self.latest = max(self.latest, series.latest)
        self.kept.add(samples)

    def has(self, *streams: str) -> bool:
        """Whether there are samples of these streams."""
        return all(len(self.series.get(name, ())) > 0 for name in streams)

    def recording(
        self, begin: float = -np.inf, end: float = np.inf
    ) -> Recording | None:
        """The samples from `begin` to before `end` [s]; None for none."""
        found = {
            name: series.stream(begin, end) for name, series in self.series.items()
        }
        streams = {name: stream for name, stream in found.items() if stream is not None}
        return self.placed(streams) if streams else None

    def placed(self, streams: dict[str, Stream]) -> Recording:
        """Streams as a recording with the poses of the sensor."""
        whole = Recording(streams, source="live")
        if self.sensor_pose is None or "orientation" not in streams:
            return whole
        return with_given_sensor_pose(whole, self.sensor_pose)

    def cut(self, before: float) -> None:
        """Forget samples before `before` [s]."""
        for series in self.series.values():
            series.cut(before)

    def overflow(self) -> Recording | None:
        """The older half, cut off, if a stream has too many rows; else None."""
        longest = max(self.series.values(), key=len, default=None)
        if longest is None or len(longest) <= MOST_ROWS:
            return None
        middle = float(longest.time[len(longest) // 2])
        older = self.recording(end=middle)
        self.cut(middle)
        return older

    def take_all(self) -> Recording | None:
        """All samples, which are forgotten as those of another clock follow."""
        whole = self.recording()
        self._before_jump = {n: each.latest for n, each in self.series.items()}
        self.series, self._recent = {}, {}
        self.latest = -np.inf
        self.kept.begin_clock()
        return whole

    def _series(self, name: str) -> Series:
        if name not in self.series:
            self.series[name] = Series(name, self.skipped)
        return self.series[name]

    def _count(self, reason: str, which: Mask) -> None:
        if which.any():
            self.skipped[reason] += int(which.sum())

    def _check_unit(self, name: str, time: Array) -> None:
        """`InputError` once `CONFIRMED` samples of a stream in a row are each more than
        `FORWARD` after the one before: time is not in seconds."""
        for t in time.tolist():
            before, leaps = self._leaps.get(name, (t, 0))
            leaps = leaps + 1 if t - before > FORWARD else 0
            self._leaps[name] = t, leaps
            if leaps >= CONFIRMED:
                what = f"samples of {name} are more than {FORWARD:g} s apart"
                fix = "give time in seconds, not in micro- or nanoseconds"
                raise InputError(what, "live", fix)

    def _of_this_clock(self, name: str, time: Array) -> Mask:
        """Mask (n,) of the samples of a stream that were not sent before a jump."""
        own = np.ones(len(time), dtype=bool)
        before = self._before_jump.get(name)
        newest = max(self._series(name).latest, self._begun)
        if before is not None:
            for i, t in enumerate(time.tolist()):
                own[i] = abs(t - before) >= STRAGGLERS or abs(t - newest) < NEAR
                newest = max(newest, t) if own[i] else newest
        return own

    def _advances(self, name: str, time: Array, values: Array) -> Mask:
        """Mask (n,) of the samples of a stream that are not of a clock that was set back.

        These are `CONFIRMED` in a row or more, between earlier stamps and with other values;
        single ones are late or were sent again.
        """
        new = Samples(name, time, values)
        held = self._recent.get(name, Samples(name, time[:0], values[:0]))
        _, time, values = joined([held, new])[-1]
        good = np.ones(len(time), dtype=bool)
        newest = np.maximum.accumulate(time)
        begins = np.flatnonzero(time >= newest) + 1
        ends = np.append(begins[1:] - 1, len(time))
        for k in np.flatnonzero(np.minimum(ends - begins, begins) >= CONFIRMED):
            first, run = begins[k], slice(begins[k], ends[k])
            if _is_stamped_again(time, values, first, run):
                good[run] = False
                what = f"the clock of {name} went back by {newest[first] - time[first]:.1g} s"
                why = f"{what}: samples that it stamped again are left out"
                self.set_back = self.set_back or warning("clock-set-back", why)
        lately = time > newest[-1:] - BACKWARD
        self._recent[name] = Samples(name, time[lately], values[lately])
        return good[-len(new.time) :]

    def _jump(self, name: str, time: Array) -> tuple[Mask, Message | None]:
        """Mask (n,) of the samples of a stream that are of the present clock, and a
        message once `CONFIRMED` successive ones are of another."""
        near = np.ones(len(time), dtype=bool)
        latest = self._series(name).latest
        if not np.isfinite(latest):
            return near, None
        for i, t in enumerate(time.tolist()):
            apart = t - latest
            near[i] = not (apart < -BACKWARD or apart > FORWARD)
            self._far = 0 if near[i] else self._far + 1
            if near[i]:
                latest = max(latest, t)
            elif self._far >= CONFIRMED:
                self._begun = t
                what = f"the clock jumped by {apart:.6g} s: a new stretch begins"
                return near, warning("clock-jumped", what)
        return near, None


def _is_stamped_again(time: Array, values: Array, first: int, run: slice) -> bool:
    """Whether the samples of a run from `first` on are in order, between the stamps of
    samples before them, and have other values than these."""
    if (np.diff(time[run]) < 0.0).any():
        return False
    order = np.argsort(time[:first], kind="stable")
    before = time[order]
    at = np.searchsorted(before, time[run])
    mixed = before[at] - time[run] < 1.5 * np.median(np.diff(before))
    mixed &= (values[order[at]] != values[run]).any(axis=1)
    return bool(mixed.sum() >= CONFIRMED)


class Kept:
    """All samples of a stream, by clock, in order of arrival."""

    def __init__(self) -> None:
        self._clocks: list[dict[str, _Column]] = [{}]
        self._numbers = 0
        self.whole = True
        """Whether all samples are kept; otherwise none are."""

    def add(self, samples: Samples) -> None:
        """Keep samples, unless there are too many."""
        time, values = samples.time, samples.values
        if not self.whole:
            return
        self._numbers += values.size + time.size
        if self._numbers > MOST_NUMBERS:
            self.whole, self._clocks = False, []
            return
        columns = self._clocks[-1]
        if samples.stream not in columns:
            columns[samples.stream] = _Column(values.shape[1])
        columns[samples.stream].add(time, values)

    def begin_clock(self) -> None:
        """Begin another clock."""
        if self.whole:
            self._clocks.append({})

    def clocks(self) -> list[dict[str, Stream]]:
        """The streams of each clock with wrench and poses, after which nothing can be
        added; empty if samples were dropped."""
        found: list[dict[str, Stream]] = []
        for clock in self._clocks:
            streams = {name: column.stream() for name, column in clock.items()}
            there = {name: s for name, s in streams.items() if s is not None}
            if {"wrench", "orientation"} <= set(there):
                found.append(there)
        self._clocks = []
        return found


class _Column:
    """Samples of one stream."""

    def __init__(self, width: int):
        self._width = width
        self._time, self._values = Growing(), Growing(width)

    def add(self, time: Array, values: Array) -> None:
        """Add samples, if they have its width."""
        if values.shape[1] == self._width:
            self._time.append(time)
            self._values.append(values)

    def stream(self) -> Stream | None:
        """In order of time, each stamp once."""
        time, values = self._time.finish(), self._values.finish()
        kept = in_order(time)
        return Stream(time[kept], values[kept]) if len(kept) else None

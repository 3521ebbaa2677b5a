"""Kept: all samples of a stream as they came, for the final answer, while they fit in
memory."""

import numpy as np

from hefting.core.errors import InputError
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array
from hefting.logs.growing import Growing
from hefting.online.samples import Samples

MOST_NUMBERS = 1_000_000
"""Most numbers that are kept: 8 MB, one minute of wrench and poses at 1 kHz."""


class Kept:
    """The samples of a stream's whole clocks, in order of arrival."""

    def __init__(self) -> None:
        self._clocks: list[dict[str, _Column]] = [{}]
        self._numbers = 0
        self.whole = True
        """Whether all samples are there; if not, none are."""

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
        """What follows is of another clock."""
        if self.whole:
            self._clocks.append({})

    def recordings(self, source: str) -> list[Recording]:
        """A recording of each clock that has wrench and poses, after which nothing can
        be added; none where not all samples are there."""
        found: list[Recording] = []
        for clock in self._clocks:
            streams = {name: column.stream() for name, column in clock.items()}
            there = {name: s for name, s in streams.items() if s is not None}
            if not {"wrench", "orientation"} <= set(there):
                continue
            try:
                found.append(Recording(there, source=source))
            except InputError:
                continue
        self._clocks = []
        return found


class _Column:
    """Samples of one stream."""

    def __init__(self, width: int):
        self._width = width
        self._time, self._values = Growing(), Growing(width)

    def add(self, time: Array, values: Array) -> None:
        """Add samples, if they are of its width."""
        if values.shape[1] == self._width:
            self._time.append(time)
            self._values.append(values)

    def stream(self) -> Stream | None:
        """In order of time, each stamp once, as readers of logs take them."""
        time, values = self._time.finish(), self._values.finish()
        _, first = np.unique(time, return_index=True)
        return Stream(time[first], values[first]) if len(first) else None

"""Samples of a table that are left out and counted: incomplete ones, which are an error
where they are many, invalid poses, and samples at the time of the one before."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError
from hefting.core.magnitudes import ROUNDED_SHARE
from hefting.core.messages import Message, warning
from hefting.core.recording import Stream
from hefting.core.spatial import Mask, lengths

FEW = 0.2
"""Largest share of incomplete samples of a group of columns; more are an error."""


class Gaps:
    """Counts the incomplete samples of one group of columns, block by block."""

    def __init__(self, source: str, names: Sequence[str], most: float = FEW):
        self._source, self._names, self._most = source, names, most
        self._count, self._row, self._column, self._is_nan = 0, 0, 0, False

    def find(
        self,
        rows: NDArray[np.int64],
        blanks: Sequence[Mask | None],
        nans: Sequence[Mask | None],
    ) -> Mask | None:
        """Mask (R,) of rows in which the group has no sample, from row numbers and the
        masks of blank cells and NaN of each column; None for no such row. Rows that are
        blank as a whole do not count as gaps."""
        if all(mask is None for mask in (*blanks, *nans)):
            return None
        nowhere = np.zeros(len(rows), dtype=bool)
        blank, nan = (
            np.array([nowhere if mask is None else mask for mask in masks])
            for masks in (blanks, nans)
        )
        lacking: Mask = np.logical_or.reduce(blank | nan)
        if (gaps := lacking & ~blank.all(axis=0)).any():
            if not self._count:
                first = int(np.argmax(gaps))
                self._row = int(rows[first])
                self._column = int(np.argmax((blank | nan)[:, first]))
                self._is_nan = bool(nan[self._column, first])
            self._count += int(gaps.sum())
        return lacking

    def conclude(self, samples: int) -> tuple[Message, ...]:
        """A warning of the gaps, with the number of complete samples; `InputError` where
        the gaps are many."""
        if not self._count:
            return ()
        names = self._names
        those = " ".join(names) if len(names) < 8 else f"{names[0]}..{names[-1]}"
        if self._count <= self._most * (self._count + samples):
            what = (
                f"left out {self._count} of {self._count + samples} rows (the first: row "
                f"{self._row}) in which {those} do not all hold a number"
            )
            return (warning("rows-incomplete", what),)
        where = f"{self._source}, row {self._row}, column {names[self._column]}"
        more = f", here and in {self._count - 1} more rows" if self._count > 1 else ""
        if self._is_nan:
            fix = (
                "leave the cell blank where nothing was measured, or say "
                'nan = "blank" in a column map (hefting map does)'
            )
            raise InputError(f"the value is nan{more}", where, fix)
        fix = f"give all of {those} in a row or none"
        raise InputError(f"the cell is blank{more}", where, fix)


def without_invalid_poses(
    streams: Mapping[str, Stream],
) -> tuple[dict[str, Stream], tuple[Message, ...]]:
    """The streams without the poses whose quaternion is far from unit norm, as drivers
    write zeros or -9999 for no pose, if these are few; and a warning."""
    orientation = streams.get("orientation")
    if orientation is None or orientation.values.shape[1] != 4:
        return dict(streams), ()
    norms = lengths(orientation.values)
    wrong = ~((norms > 0.5) & (norms < 2.0))
    count = int(wrong.sum())
    if not 0 < count <= FEW * len(wrong):
        return dict(streams), ()
    rows = orientation.rows[wrong]
    kept = {
        name: stream[np.flatnonzero(~np.isin(stream.rows, rows))]
        if name in ("orientation", "position")
        else stream
        for name, stream in streams.items()
    }
    what = (
        f"left out {count} of {len(wrong)} poses (the first: row {rows[0]}) whose "
        "quaternion is none: its norm is not 1"
    )
    kept = {name: stream for name, stream in kept.items() if len(stream)}
    return kept, (warning("poses-invalid", what),)


def without_repeats(
    streams: Mapping[str, Stream],
) -> tuple[dict[str, Stream], tuple[Message, ...]]:
    """The streams without samples that repeat time and values of the one before, and
    without a few that have its time but other values, as of a clock of milliseconds at
    1 kHz; and warnings with their number.

    Many of the latter are kept, and refused by `hefting.core.recording.Recording`.
    """
    kept: dict[str, Stream] = {}
    dropped: set[int] = set()
    conflicting: set[int] = set()
    for name, stream in streams.items():
        again = 1 + np.flatnonzero(stream.time[1:] == stream.time[:-1])
        alike = (stream.values[again] == stream.values[again - 1]).all(axis=1)
        dropped.update(stream.rows[again[alike]].tolist())
        if (~alike).sum() <= ROUNDED_SHARE * len(stream):
            conflicting.update(stream.rows[again[~alike]].tolist())
        else:
            again = again[alike]
        kept[name] = (
            stream[np.delete(np.arange(len(stream)), again)] if len(again) else stream
        )
    found: list[Message] = []
    if dropped := dropped - conflicting:
        plural = "s" if len(dropped) > 1 else ""
        what = f"dropped {len(dropped)} repeated row{plural}, time and values alike (the first: row {min(dropped)})"
        found.append(warning("rows-repeated", what))
    if conflicting:
        count = f"{len(conflicting)} row{'s' * (len(conflicting) > 1)}"
        what = f"left out {count} with the time of the one before but other values (the first: row {min(conflicting)})"
        found.append(warning("rows-conflicting", what))
    return kept, tuple(found)

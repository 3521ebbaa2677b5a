"""Samples of one quantity in a bag, and repair of their stamps, order and repeats."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError
from hefting.core.messages import Message, note, warning
from hefting.core.spatial import Array, changed_rows

FAR_BACK = 1_000_000_000
"""[ns] Largest step back of stamps of messages out of order; a larger one means another
clock."""


@dataclass(frozen=True)
class Series:
    """N samples of one quantity."""

    time: NDArray[np.int64]
    """(N,) stamp [ns]; 0 where the message has none"""
    logged: NDArray[np.int64]
    """(N,) time when the message was logged [ns]"""
    rows: NDArray[np.int64]
    """(N,) number of the message within its topic, from 1"""
    values: Array
    """(N, d)"""

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, index: slice | NDArray) -> Self:
        """The samples chosen by a slice, a mask or an index array."""
        return type(self)(
            self.time[index], self.logged[index], self.rows[index], self.values[index]
        )

    def with_values(self, values: Array) -> Self:
        """The same samples with other values (N, any)."""
        return type(self)(self.time, self.logged, self.rows, values)

    def order(self) -> NDArray[np.intp]:
        """Indices that put the samples in the order in which they were logged."""
        return np.lexsort((self.rows, self.logged))

    @classmethod
    def joined(cls, parts: "list[Series]") -> "Series":
        """All samples of several series."""
        columns = (
            [getattr(part, name) for part in parts]
            for name in ("time", "logged", "rows", "values")
        )
        return cls(*(np.concatenate(column) for column in columns))


def tidy(
    series: Series,
    what: str,
    where: str,
    tell: Callable[[Message], None],
    warn: Callable[[Message], None],
) -> Series:
    """`series` with finite values and strictly increasing `time`; empty when no value
    is finite.

    Messages without a stamp get the time when they were logged. `tell` and `warn` are
    called with notes and warnings on the changes of `what`. Raises `InputError` when time
    goes back by more than a second.
    """
    finite = np.logical_and.reduce(np.isfinite(series.values), axis=1)
    if not finite.all():
        text = f"{(~finite).sum()} of {len(finite)} messages of {what} hold values that are not finite: left out"
        warn(warning("messages-not-finite", text))
        series = series[finite]
    unstamped = np.equal(series.time, 0)
    if unstamped.any():
        count = "" if unstamped.all() else f"{unstamped.sum()} of {len(unstamped)} "
        text = f"{count}messages of {what} have no stamp: the times they were logged at are used"
        warn(warning("messages-unstamped", text))
        series = Series(
            np.where(unstamped, series.logged, series.time),
            series.logged,
            series.rows,
            series.values,
        )
    series = series[series.order()]
    steps = np.diff(series.time)
    if len(steps) and steps.min() < -FAR_BACK:
        k = int(np.argmax(steps < -FAR_BACK))
        what = f"time goes back by {-steps[k] * 1e-9:.9g} s"
        fix = "cut the bag there, or record with one clock"
        raise InputError(what, where=f"{where}, message {series.rows[k + 1]}", fix=fix)
    if (backward := int((steps < 0).sum())) > 0:
        text = (
            f"{backward} messages of {what} came out of order: sorted by their stamps"
        )
        warn(warning("messages-unordered", text))
        series = series[np.argsort(series.time, kind="stable")]
    repeated = np.append(False, np.diff(series.time) == 0)[: len(series)]
    if repeated.any():
        equal = ~changed_rows(series.values)
        if exact := int((repeated & equal).sum()):
            tell(
                note(
                    "messages-repeated", f"{exact} repeated messages of {what} dropped"
                )
            )
        if other := int((repeated & ~equal).sum()):
            text = f"{other} messages of {what} have the stamp of the message before but other values: left out"
            warn(warning("messages-conflicting", text))
        series = series[~repeated]
    return series

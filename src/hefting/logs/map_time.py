"""A table's column with the time, by its name or as pandas' index, and its unit."""

import re
from collections.abc import Sequence

import numpy as np

from hefting.logs.map_groups import CAMEL, small_words
from hefting.logs.map_sample import MOST_ROWS, UNKNOWN, Sample
from hefting.logs.map_text import Guess, unit_entry
from hefting.logs.table import SINCE_1970
from hefting.logs.units import ALIASES, UNITS

TIMES = (
    *("t", "time", "timestamp", "stamp", "ts", "clock", "sec", "secs", "seconds"),
    *("times", "timestamps", "stamps"),
    *("robtime", "robottime", "systime", "zeit", "zeitstempel", "datetime"),
    *("temps", "tiempo", "tempo", "时间", "時間", "時刻"),
    *("elapsed", "epoch", "unix", "asctime", "duration", "ipoc", "tm", "tout"),
)
"""Names of the time, without its unit; `names_time` also knows LabVIEW's ``X_Value``."""

MILLISECONDS = ("ipoc", "duration", "tm")
"""Names that KUKA, libfranka and ABB give to whole milliseconds."""

SHORT = 3.0
"""[s] Duration in the unit that the steps suggest below which a larger unit is possible;
below one second that is taken."""

TIME_UNITS = {*UNITS["time"], *(a for a, n in ALIASES.items() if n in UNITS["time"])}
"""Units in names of the time."""

PANDAS_INDEX = "__index_level_0__"
"""Name that pandas gives an unnamed index in a Parquet file; in a selection of rows it
holds row numbers."""

NANOSECONDS = ("nsec", "nsecs", "nanosec", "nanosecs", "nanosecond", "nanoseconds")
"""Names of the nanoseconds beside the seconds of a stamp."""


def names_time(text: str) -> bool:
    """Whether a name is one of the time, apart from its unit, words before it, and a
    beginning (``since ...``)."""
    words = _small_words(text)
    if "since" in words[1:]:
        words = words[: words.index("since")]
    bare = [word for word in words if word not in TIME_UNITS | {"in"}]
    alone = bare in (["t"], ["x", "value"]) or text.endswith(".t")
    return bool(words) and (not bare or bare[-1] in TIMES[1:] or alone)


def _small_words(text: str) -> list[str]:
    """All words of a name, units included."""
    return small_words(re.sub(CAMEL, "_", text))


@np.errstate(over="ignore", invalid="ignore")  # as of values of 1e308
def time_of(sample: Sample) -> Guess | None:
    """The first column named as a time, if possible with increasing numbers, and not the
    nanoseconds of a stamp; else one that may be a time; else the index of a data frame."""
    every = range(len(sample.names))
    named = [j for j in every if names_time(sample.words(j))]
    named = named or [j for j in every if _may_be_time(sample, j)]
    numbers = [j for j in named if np.isfinite(sample.values[:, j]).any()]
    numbers.sort(key=lambda j: not _grows(sample.values[:, j]))
    for column in numbers or named:
        words = _small_words(sample.words(column)) or [""]
        if words[-1] in NANOSECONDS and np.nanmax(sample.values[:, column]) < 1e9:
            continue
        more = _nanoseconds(sample, words[:-1])
        if more not in (None, column):
            how = f"nanoseconds = {sample.toml_name(more)}"
            return Guess("time", (column, more), (how,))
        stated = sample.stated_unit((column,), "time") or next(
            (ALIASES.get(word, word) for word in words if word in TIME_UNITS), ""
        )
        stated = "s" if column in sample.dates else stated
        is_sure = words[-1] in MILLISECONDS
        unit, remark = _time_unit(sample.values[:, column], stated, is_sure)
        return Guess("time", (column,), (unit_entry(unit),), remark)
    return _index(sample)


def _may_be_time(sample: Sample, column: int) -> bool:
    """Whether a column increases, and holds dates less than 1 s apart, as those of static
    poses are not, or states a unit of time, or has a word of one and is no count."""
    values = sample.values[:, column]
    steps = np.diff(values)
    if column in sample.dates:
        return _grows(values) and bool(np.nanmedian(steps) < 1.0)
    if sample.has_unit(column, "time"):
        return _grows(values)
    words = {*_small_words(sample.words(column))} & {*TIMES}
    return bool(words) and bool((steps > 0.0).all() and (steps != 1.0).any())


def _grows(values: np.ndarray) -> bool:
    """Whether numbers never decrease, and increase at least once."""
    steps = np.diff(values[np.isfinite(values)])
    return bool((steps >= 0.0).all() and (steps > 0.0).any())


def _index(sample: Sample) -> Guess | None:
    """The index of a data frame (an unnamed first column, or `PANDAS_INDEX`) if it
    increases and does not count or number rows."""
    own = sample.names.count(PANDAS_INDEX)
    column = sample.names.index(PANDAS_INDEX) if own else 0
    values = sample.values[:, column]
    steps = np.diff(values)
    if (sample.names[0] and not own) or not len(steps) or not (steps > 0.0).all():
        return None
    counts = (values % 1 == 0.0).all() and values[0] < SINCE_1970
    if counts and (own or (steps == 1.0).all()):
        return None
    unit, remark = _time_unit(values, "s" if column in sample.dates else "")
    return Guess("time", (column,), (unit_entry(unit),), remark)


def _nanoseconds(sample: Sample, before: Sequence[str]) -> int | None:
    """The column of nanoseconds whose name begins with the words `before` those of the
    seconds."""
    for column in range(len(sample.names)):
        words = _small_words(sample.words(column))
        begins = words[: len(before)] == list(before)
        if begins and "".join(words[len(before) :]) in (*NANOSECONDS, "nanos"):
            return column
    return None


def _time_unit(
    values: np.ndarray, stated: str, is_sure: bool = False
) -> tuple[str, str]:
    """Unit of the time, as `stated` or by its steps, and a remark. `is_sure` says that
    the unit by the steps is not doubtful."""
    if stated:
        return stated, ""
    steps = np.diff(values[np.isfinite(values)])
    step = float(np.median(np.abs(steps))) if len(steps) else 0.0
    for unit, least, per, larger in (
        ("ns", 1e5, 1e9, "us"),
        ("us", 1e2, 1e6, "ms"),
        ("ms", 1.0, 1e3, "s"),
    ):
        if step >= least:
            why, lasts = f"by its steps of {step:.4g}", len(values) * step / per
            end = np.nanmax(values)
            sure = is_sure or end > SINCE_1970 * per or lasts >= SHORT
            if sure or len(values) >= MOST_ROWS:
                return unit, why
            if larger == "s" and 1e9 < end < 2.2e9:  # since 1970, from 2001 to 2039
                return larger, why
            why = f"its unit {UNKNOWN}: {why}, or 1000 times"
            return (larger, f"{why} smaller") if lasts < 1 else (unit, f"{why} larger")
    return "s", ""

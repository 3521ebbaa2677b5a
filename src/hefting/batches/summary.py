"""Summary of a batch: number of rows by verdict, reasons of failures, residuals, and
the recordings that are worth a look.

Rows are read some at a time, and only a few numbers and the name of each are kept.
"""

import json
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.batches.columns import SCHEMA, STAGES
from hefting.core.spatial import Array, immutable

if TYPE_CHECKING:
    import pyarrow as pa

MOST_EXAMPLES = 5
"""Largest number of recordings that are named for a reason."""
MOST_REASONS = 500
"""Largest number of reasons; further ones are counted as one (`OTHER`), which bounds
memory where every text differs."""
OTHER = "other reasons: see the table"


@dataclass
class Reason:
    """An error that recordings have in common."""

    error: str
    """Class of the error."""
    text: str
    """Its text; where recordings differ in numbers, with # for these."""
    count: int = 0
    examples: list[str] = field(default_factory=list)
    """Identities of some rows with this error."""
    paths: list[str | None] = field(default_factory=list)
    """Path of each example, None for one of several recordings."""


class Reasons:
    """Failures, counted."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], Reason] = {}

    def add(
        self,
        failure: Mapping[str, str],
        name: str,
        path: str | None,
        of: str | None = None,
    ) -> None:
        """Count a failure, with the class of its `error` and its `error_text`, of the
        row `name` at `path`, together with those of the same text but for paths and
        numbers. `of` is the path in the text where the row has none."""
        error, own = failure["error"], _without_path(failure["error_text"], path or of)
        general = re.sub(r"\d[\d.,:e+-]*", "#", own)
        key = error, general
        if key not in self._found and len(self._found) >= MOST_REASONS:
            key, own, general = ("", OTHER), OTHER, OTHER
        reason = self._found.setdefault(key, Reason(key[0], own))
        reason.count += 1
        if reason.count > 1 and reason.text != own:
            reason.text = general
        if len(reason.examples) < MOST_EXAMPLES:
            reason.examples.append(name)
            reason.paths.append(path)

    def sorted(self) -> tuple[Reason, ...]:
        """The reasons, the most frequent first."""
        return tuple(sorted(self._found.values(), key=lambda reason: -reason.count))


def _without_path(text: str, recording: str | None) -> str:
    """A text with "..." for the recording's path or file name, and without these where
    they come first."""
    for path in filter(None, (recording, Path(recording or "").name)):
        place = rf"(?<!\w){re.escape(path)}(?!\w)"
        # the name of a folder may be a word of the text
        text = re.sub(place if "." in path else f"^{place}", "...", text)
    return re.sub(r"^\.\.\.[^:]*: ", "", text)


FAR = 5.0
"""Robust standard deviations of the logarithm of the residual above the median, from
which on a recording is an outlier: one in four million of a Gaussian."""
LEAST_FACTOR = 1.5
"""Ratio of an outlier's residual to the median at least; the spread alone would be too
strict for copies, or recordings of one sensor."""
FEWEST = 20
"""Smallest number of residuals among which outliers are looked for."""
MOST_OUTLIERS = 20
"""Largest number of recordings worth a look that are named, of each kind."""
MAD = 1.4826
"""Ratio of a Gaussian's standard deviation to its median absolute deviation."""
COLUMNS = (
    *("recording", "name", "object", "error", "error_text", "left_out"),
    *("verdict", "reasons"),
    *("mass", "intervals", "residual", "seconds", "messages"),
)
VERDICTS = ("good", "usable with care", "do not use")


@dataclass(frozen=True)
class Outlier:
    """A recording that is worth a look."""

    name: str
    """Identity of its row."""
    recording: str | None
    """Its path; None for several recordings of an object."""
    why: str


@immutable
class Summary:
    """Summary of a folder of results."""

    verdicts: dict[str, int]
    """Number of rows by verdict, of those that did not fail."""
    reasons: tuple[Reason, ...]
    """Errors of the rows that failed, the most frequent first."""
    left_out: tuple[Reason, ...]
    """Errors of recordings that were left out of objects with other recordings, the
    most frequent first."""
    doubts: dict[str, int]
    """Rows by code of a message that puts them in doubt, the most frequent first."""
    doubt_texts: dict[str, str]
    """Text of such a message in one of the rows, by code."""
    residuals: Array
    """(n, 2) force [N] and torque [N m] residuals of rows that did not fail."""
    masses: Array
    """(n,) [kg]"""
    seconds: dict[str, float]
    """[s] of processor-bound time by stage, of all rows together"""
    outliers: tuple[Outlier, ...]

    @property
    def failed(self) -> int:
        """Number of rows with an error."""
        return sum(reason.count for reason in self.reasons)

    @property
    def total(self) -> int:
        """Number of rows."""
        return self.failed + sum(self.verdicts.values())

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values."""
        from hefting import __version__

        return {
            "schema": SCHEMA,
            "version": __version__,
            "rows": self.total,
            "verdicts": self.verdicts,
            "failed": self.failed,
            "failures": [vars(reason) for reason in self.reasons],
            "left_out": [vars(reason) for reason in self.left_out],
            "doubts": self.doubts,
            "seconds": self.seconds,
            "outliers": [vars(outlier) for outlier in self.outliers],
        }


def summary_of(tables: "Iterable[pa.Table]") -> Summary:
    """Summary of the rows of tables, from their `COLUMNS`."""
    tally = _Tally()
    for table in tables:
        for row in table.select(list(COLUMNS)).to_pylist():
            tally.add(row)
    return tally.summary()


class _Tally:
    """What of the rows so far goes into a `Summary`."""

    def __init__(self) -> None:
        self._verdicts, self._doubts = Counter[str](), Counter[str]()
        self._texts: dict[str, str] = {}
        self._failures, self._left_out = Reasons(), Reasons()
        self._seconds = dict.fromkeys(STAGES, 0.0)
        self._found = _Found()
        self._not_to_use: list[Outlier] = []

    def add(self, row: dict[str, Any]) -> None:
        """Count a row, which may have failed."""
        for stage, spent in (row["seconds"] or {}).items():
            self._seconds[stage] += spent or 0.0
        name = row["name"] or row["recording"] or row["object"]
        if row["error"] is not None:
            first = next(iter(row["left_out"] or ()), {})
            self._failures.add(row, name, row["recording"], first.get("recording"))
            return
        for each in row["left_out"] or ():
            self._left_out.add(each, each["recording"], each["recording"])
        self._add_verdict(name, row)
        force, torque = row["residual"] or (np.nan, np.nan)
        numbers = (row["mass"], _half_of_mass(row), force, torque)
        self._found.add(name, row, numbers)

    def _add_verdict(self, name: str, row: dict[str, Any]) -> None:
        """Count the verdict of a row that did not fail, and the doubts behind it."""
        self._verdicts[row["verdict"]] += 1
        for code, text in _doubts(row).items():
            self._doubts[code] += 1
            self._texts.setdefault(code, text)
        if row["verdict"] == VERDICTS[-1] and len(self._not_to_use) < MOST_OUTLIERS:
            self._not_to_use.append(Outlier(name, row["recording"], _why_not(row)))

    def summary(self) -> Summary:
        """The summary of all rows that were added."""
        found = self._found
        far = (*_far_residuals(found), *_far_masses(found))
        values = found.values
        return Summary(
            {level: self._verdicts[level] for level in VERDICTS},
            self._failures.sorted(),
            self._left_out.sorted(),
            dict(self._doubts.most_common()),
            self._texts,
            values[:, 2:],
            values[:, 0],
            self._seconds,
            _together((*self._not_to_use, *far)),
        )


def _half_of_mass(row: dict[str, Any]) -> float:
    """Half the mass's interval [kg]; NaN where it has no two ends."""
    low, high = (row["intervals"] or {}).get("mass") or (None, None)
    return 0.5 * (high - low) if low is not None and high is not None else np.nan


def _together(outliers: Iterable[Outlier]) -> tuple[Outlier, ...]:
    """Each recording once, with all its reasons."""
    whys: dict[tuple[str, str | None], list[str]] = {}
    for each in outliers:
        whys.setdefault((each.name, each.recording), []).append(each.why)
    return tuple(Outlier(*of, "; ".join(why)) for of, why in whys.items())


def _why_not(row: dict[str, Any]) -> str:
    """Verdict of a row, its first reason, and the number of the others."""
    first, *others = row["reasons"] or ("no reason is given",)
    more = f" (and {len(others)} more)" if others else ""
    return f"{row['verdict']}: {first}{more}"


def _doubts(row: dict[str, Any]) -> dict[str, str]:
    """Texts, by code, of the messages that put a row in doubt."""
    reasons = set(row["reasons"] or ())
    messages = row["messages"] or ()
    return {each["code"]: each["text"] for each in messages if each["text"] in reasons}


class _Found:
    """Numbers and names of the rows that did not fail, some hundred bytes each."""

    def __init__(self) -> None:
        self._numbers, self._names = array("d"), bytearray()
        self._ends = array("q", [0])
        self.of_object: dict[str, array[int]] = {}
        """row numbers of each object"""

    def add(self, name: str, row: dict[str, Any], numbers: Sequence[float]) -> None:
        """Add a row; `numbers` are mass and half its interval [kg], and force [N] and
        torque [N m] residual."""
        if row["object"] is not None:
            self.of_object.setdefault(row["object"], array("q")).append(len(self))
        self._numbers.extend(numbers)
        path = None if row["recording"] == name else row["recording"]
        self._names += json.dumps([name, path, row["recording"] is None]).encode()
        self._ends.append(len(self._names))

    def __len__(self) -> int:
        return len(self._ends) - 1

    @property
    def values(self) -> Array:
        """(n, 4) numbers of all rows"""
        return np.array(self._numbers).reshape(-1, 4)

    def outlier(self, row: int, why: str) -> Outlier:
        """A row as an outlier for a reason."""
        text = self._names[self._ends[row] : self._ends[row + 1]]
        name, path, is_object = json.loads(bytes(text))
        return Outlier(name, None if is_object else path or name, why)


def _far_residuals(found: _Found) -> list[Outlier]:
    """Recordings whose residual is an outlier (`FAR`, `LEAST_FACTOR`)."""
    values = found.values
    if len(values) < FEWEST:
        return []
    far: dict[int, tuple[float, str]] = {}
    for column, (what, unit) in enumerate((("force", "N"), ("torque", "N m")), start=2):
        size = np.log(np.maximum(values[:, column], 1e-12))
        known = size[np.isfinite(size)]
        if not len(known):
            continue
        middle = np.median(known)
        spread = MAD * np.median(np.abs(known - middle))
        least = max(FAR * spread, np.log(LEAST_FACTOR))
        for row in np.flatnonzero(size - middle > least):
            times = float(np.exp(size[row] - middle))
            why = (
                f"{what} residual of {values[row, column]:.2g} {unit}, "
                f"{times:.2g} times the median"
            )
            far[int(row)] = max(far.get(int(row), (0.0, "")), (times, why))
    worst = sorted(far.items(), key=lambda item: -item[1][0])[:MOST_OUTLIERS]
    return [found.outlier(row, why) for row, (_, why) in worst]


def _far_masses(found: _Found) -> list[Outlier]:
    """Recordings whose mass contradicts the median of their object's recordings."""
    values = found.values
    far: list[tuple[float, Outlier]] = []
    for thing, own in found.of_object.items():
        mass, half = values[own, 0], values[own, 1]
        if len(own) < 3:
            continue
        median = float(np.median(mass))
        deviations = np.abs(mass - median) / np.maximum(half, 1e-12)
        for k in np.flatnonzero(deviations > FAR / 1.96):
            why = (
                f"{mass[k]:.4g} ± {half[k]:.2g} kg, where recordings of {thing} have "
                f"{median:.4g} kg (median of {len(own)})"
            )
            far.append((float(deviations[k]), found.outlier(own[k], why)))
    far.sort(key=lambda item: -item[0])
    return [outlier for _, outlier in far[:MOST_OUTLIERS]]

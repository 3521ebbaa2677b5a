"""Summary of a batch: how many of what verdict, why some failed, how large residuals
are, and which recordings are worth a look."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.batch.columns import SCHEMA, STAGES
from hefting.core.spatial import Array

if TYPE_CHECKING:
    import pyarrow as pa

FAR = 5.0
"""Robust standard deviations of the logarithm of the residual from which on a recording
is far above the rest: of a Gaussian one in four million."""
FEWEST = 20
"""Residuals that say how large residuals are."""
MOST_OUTLIERS = 20
"""Recordings worth a look that are named, of each kind."""
MOST_EXAMPLES = 5
"""Recordings that are named for a reason of failure."""
MAD = 1.4826
"""Standard deviation of a Gaussian over its median absolute deviation."""
COLUMNS = (
    *("recording", "name", "object", "error", "error_text", "verdict", "reasons"),
    *("mass", "intervals", "residual", "seconds", "messages"),
)
VERDICTS = ("good", "usable with care", "do not use")


@dataclass
class Reason:
    """Why some failed."""

    error: str
    """Class of the error."""
    text: str
    """What it says, without what differs between recordings."""
    count: int = 0
    examples: list[str] = field(default_factory=list)
    """Some of the recordings."""


@dataclass(frozen=True)
class Outlier:
    """A recording that is worth a look."""

    name: str
    """What identifies it."""
    recording: str | None
    """Its path, unless it stands for several."""
    why: str


@dataclass(frozen=True, eq=False)
class Summary:
    """What a folder of results holds."""

    verdicts: dict[str, int]
    """Number of rows by verdict, of those that did not fail."""
    reasons: tuple[Reason, ...]
    """Why the others failed, the most frequent first."""
    doubts: dict[str, int]
    """Number of rows by what puts them in doubt, the most frequent first."""
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
        return {
            "schema": SCHEMA,
            "rows": self.total,
            "verdicts": self.verdicts,
            "failed": self.failed,
            "failures": [vars(reason) for reason in self.reasons],
            "doubts": self.doubts,
            "seconds": self.seconds,
            "outliers": [vars(outlier) for outlier in self.outliers],
        }


def summary_of(tables: "Iterable[pa.Table]") -> Summary:
    """Summary of rows, of which `COLUMNS` are read, some at a time."""
    verdicts, doubts = Counter[str](), Counter[str]()
    reasons: dict[tuple[str, str], Reason] = {}
    seconds = dict.fromkeys(STAGES, 0.0)
    found: list[tuple[str, str | None, str | None]] = []
    numbers: list[tuple[float, float, float, float]] = []
    not_to_use: list[Outlier] = []
    for table in tables:
        for row in table.select(list(COLUMNS)).to_pylist():
            for stage, spent in (row["seconds"] or {}).items():
                seconds[stage] += spent or 0.0
            name = row["name"] or row["recording"] or row["object"]
            if row["error"] is not None:
                _count(reasons, name, row)
                continue
            verdicts[row["verdict"]] += 1
            doubts.update(_codes(row))
            if row["verdict"] == VERDICTS[-1] and len(not_to_use) < MOST_OUTLIERS:
                why = f"{row['verdict']}: {'; '.join(row['reasons'] or ())}"
                not_to_use.append(Outlier(name, row["recording"], why))
            low, high = (row["intervals"] or {}).get("mass") or (None, None)
            half = (
                0.5 * (high - low) if low is not None and high is not None else np.nan
            )
            force, torque = row["residual"] or (np.nan, np.nan)
            numbers.append((row["mass"], half, force, torque))
            found.append((name, row["recording"], row["object"]))
    values = np.array(numbers, dtype=float).reshape(-1, 4)
    outliers = (
        *not_to_use,
        *_far_residuals(found, values),
        *_far_masses(found, values),
    )
    return Summary(
        {level: verdicts[level] for level in VERDICTS},
        tuple(sorted(reasons.values(), key=lambda reason: -reason.count)),
        dict(doubts.most_common()),
        values[:, 2:],
        values[:, 0],
        seconds,
        outliers,
    )


def _count(
    reasons: dict[tuple[str, str], Reason], name: str, row: dict[str, Any]
) -> None:
    """Count a failure among those that say the same of other recordings."""
    text = str(row["error_text"])
    for path in filter(None, (row["recording"], Path(row["recording"] or "").name)):
        text = text.replace(path, "...")
    text = re.sub(r"^\.\.\.[^:]*: ", "", text)
    general = re.sub(r"\d[\d.,:e+-]*", "#", text)
    key = row["error"], general
    reason = reasons.setdefault(key, Reason(row["error"], text))
    reason.count += 1
    if reason.count > 1:
        reason.text = general
    if len(reason.examples) < MOST_EXAMPLES:
        reason.examples.append(name)


def _codes(row: dict[str, Any]) -> set[str]:
    """Codes of the messages that put a row in doubt."""
    reasons = set(row["reasons"] or ())
    return {each["code"] for each in row["messages"] or () if each["text"] in reasons}


def _far_residuals(
    found: Sequence[tuple[str, str | None, str | None]], values: Array
) -> list[Outlier]:
    """Recordings whose residual is far above that of the rest."""
    if len(found) < FEWEST:
        return []
    far: dict[int, tuple[float, str]] = {}
    for column, (what, unit) in enumerate((("force", "N"), ("torque", "N m")), start=2):
        size = np.log(np.maximum(values[:, column], 1e-12))
        known = size[np.isfinite(size)]
        if not len(known):
            continue
        middle = np.median(known)
        spread = MAD * np.median(np.abs(known - middle))
        for row in np.flatnonzero(size - middle > FAR * max(spread, 1e-3)):
            times = float(np.exp(size[row] - middle))
            why = (
                f"{what} residual of {values[row, column]:.2g} {unit}, "
                f"{times:.2g} times the median"
            )
            far[int(row)] = max(far.get(int(row), (0.0, "")), (times, why))
    worst = sorted(far.items(), key=lambda item: -item[1][0])[:MOST_OUTLIERS]
    return [Outlier(found[row][0], found[row][1], why) for row, (_, why) in worst]


def _far_masses(
    found: Sequence[tuple[str, str | None, str | None]], values: Array
) -> list[Outlier]:
    """Recordings whose mass contradicts that of the others of their object."""
    rows: dict[str, list[int]] = {}
    for row, (_, _, thing) in enumerate(found):
        if thing is not None:
            rows.setdefault(thing, []).append(row)
    far: list[tuple[float, Outlier]] = []
    for thing, own in rows.items():
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
            name, path, _ = found[own[k]]
            far.append((float(deviations[k]), Outlier(name, path, why)))
    far.sort(key=lambda item: -item[0])
    return [outlier for _, outlier in far[:MOST_OUTLIERS]]

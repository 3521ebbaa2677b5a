"""How estimates agree, as a table a person can read."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from hefting.cli.report.estimate import Line, _table
from hefting.core.spatial import Array
from hefting.identification.agreement import QUANTITIES, Agreement

MOST_COLUMNS = 2
"""Number of estimates beside one another; of more, each has a line for a quantity."""
SHOWN = {"m": (1e3, "mm"), "kg m²": (1e3, "10⁻³ kg m²")}
"""Factor and unit in which a quantity is shown, by its own unit."""


def agreement_report(agreement: Agreement) -> Iterable[Line]:
    """Whether they agree, and which of the estimates are in doubt; then every quantity
    with its 95 % interval, and how far the estimates are apart."""
    largest = agreement.largest
    names = _short(list(agreement.values))
    between = f"{names[largest.first]} and {names[largest.second]}"
    far = f"{largest.name} {_deviations(largest.deviations)} standard deviations apart"
    if not agreement.tested:
        yield Line(
            "nothing to compare by: no quantity has an interval in two of them",
            "yellow",
        )
    elif agreement.agree:
        limit = f"up to {agreement.limit:.1f} is chance"
        yield Line(f"they agree: {far}; {limit}", "bold")
    else:
        yield Line(f"they contradict one another: {between}, {far}", "yellow")
    for path, verdict in agreement.doubted.items():
        yield Line(f"{names[path]}: {verdict}", "yellow")
        yield from (Line(f"- {reason}", "yellow") for reason in verdict.reasons)
    yield from _table_of(agreement, names)
    for path, name in names.items():
        if path != name:
            yield Line(f"{name}: {path}")
    yield Line(
        "assumed: the same object in the same grasp, and the same sensor frame. "
        "± 95 %; apart: standard deviations between the two that differ most"
    )


def _table_of(agreement: Agreement, names: dict[str, str]) -> Iterable[Line]:
    """Quantities as rows; of more than `MOST_COLUMNS` estimates, a row for each."""
    apart = np.max(list(agreement.apart.values()), axis=0)
    tall = len(names) > MOST_COLUMNS
    rows: list[list[str]] = []
    ends: list[int] = []
    for at, (quantity, unit) in enumerate(QUANTITIES):
        scale, unit = SHOWN.get(unit, (1.0, unit))
        cells = [
            _interval(scale * agreement.values[path][at], scale * ends_[:, at])
            for path, ends_ in agreement.intervals.items()
        ]
        far = _deviations(float(apart[at]))
        if not tall:
            rows.append([quantity, *cells, far, unit])
            continue
        for i, (name, cell) in enumerate(zip(names.values(), cells, strict=True)):
            rows.append(
                [quantity if i == 0 else "", name, cell, far if i == 0 else "", unit]
            )
        ends.append(len(rows) - 1)
    columns = ["estimate", "value"] if tall else list(names.values())
    head = ["quantity", *columns, "apart", "unit"]
    return _table(head, rows, tuple(ends[:-1]) if tall else (0, 3))


def _interval(value: float, ends: Array) -> str:
    """A value and how far its interval reaches at the farther end, with the digits that
    this is worth."""
    half = float(np.abs(ends - value).max())
    if not np.isfinite(half):
        return "open"
    digits = max(0, 1 - int(np.floor(np.log10(half)))) if half > 0.0 else 6
    if digits > 6:
        return f"{value:.3e} ± {half:.1e}"
    rounded = round(value, digits) + 0.0  # no negative zero
    return f"{rounded:.{digits}f} ± {half:.{digits}f}"


def _deviations(apart: float) -> str:
    return f"{apart:.1f}" if apart < 100.0 else f"{apart:.0f}"


def _short(paths: list[str]) -> dict[str, str]:
    """File names where they tell the estimates apart, else letters."""
    names = [Path(path).stem for path in paths]
    if len(set(names)) < len(names) or max(map(len, names)) > 16:
        names = [chr(ord("A") + i) if i < 26 else f"{i + 1}" for i in range(len(paths))]
    return dict(zip(paths, names, strict=True))

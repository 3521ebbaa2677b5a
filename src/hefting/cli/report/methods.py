"""Readable tables of the methods, of the estimates of several methods, and of the
agreement of estimates."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hefting.cli.report import with_reach
from hefting.cli.report.estimate import MORE, Line, _table, assumptions, plain_errors
from hefting.cli.report.printing import doubt_lines, plain_table
from hefting.core.inertia import EXPLANATIONS
from hefting.core.spatial import Array
from hefting.estimators import VARIANTS, describe_methods
from hefting.estimators.base import INVARIANCES
from hefting.identification.agreement import QUANTITIES, Agreement
from hefting.ingest.plausibility import UNEXPLAINED_RESIDUAL_RATIO

if TYPE_CHECKING:
    from hefting.core.accuracy import Errors
    from hefting.core.estimate import Estimate
    from hefting.core.inertia import InertialParameters
    from hefting.identification.compare import Comparison

METHODS_MORE = "--verbose shows their sources, and what they do not depend on"
MOMENTS = "Jxx, Jyy, Jzz\n10⁻³ kg m²"
SHARES = "COM in % of the bounding box's sides, inertia of a uniform box's moments"


def methods_report(verbose: bool) -> Group:
    """Every method: what it does, needs and is best for; with `verbose` also its source
    and invariances."""
    known = describe_methods()
    table = Table(box=SIMPLE_HEAD, show_lines=True, pad_edge=False)
    for name in ("method", "what it does", "needs", "best for"):
        table.add_column(name, no_wrap=name == "method")
    for name, of in known.items():
        source = f"\n[dim]{of['source']}[/dim]" if verbose else ""
        what = f"{of['summary']}{source}"
        table.add_row(f"[bold]{name}[/bold]", what, of["needs"], of["best_for"])
    lines = [
        f"always a body that can exist: {', '.join(name for name in known if known[name]['consistent'])}"
    ]
    if not verbose:
        return Group(table, *map(Text, (*lines, METHODS_MORE)))
    lines.append(
        "where the motion determines all and the noise is known, these find the same body for"
    )
    for invariance, of in INVARIANCES.items():
        others = [
            name for name in known if invariance not in known[name]["invariances"]
        ]
        lines.append(f"- {of}: {'all but ' + ', '.join(others) if others else 'all'}")
    lines.append(
        f"with another model of the motion, or a condition more: {', '.join(VARIANTS)}"
    )
    return Group(table, *map(Text, lines))


def comparison_report(
    comparison: "Comparison",
    errors: "dict[str, Errors] | None",
    verbose: bool,
    truth: "InertialParameters | None",
) -> Group:
    """Methods as rows: mass, COM and inertia with half-widths of their intervals, and the
    recommended method. With `verbose` also residual, consistency, time, variants of
    methods and assumptions."""
    best = comparison.results[comparison.recommended]
    names = list(comparison.results if verbose else comparison.shown)
    lines: list[RenderableType] = [
        *doubt_lines(best.verdict, best.warnings),
        Text(
            f"recommended: {comparison.recommended}, as {comparison.reason}",
            style="bold",
        ),
        _answers(comparison, names),
    ]
    if any(not comparison.results[name].physically_consistent for name in names):
        lines.append(Text("! no body has these numbers"))
    if errors:
        lines.append(_errors_table({name: errors[name] for name in names}))
        lines.append(Text(SHARES))
    elif truth is not None:
        table = plain_table("error", "mass, %", "COM, mm")
        for name in names:
            mass, com = plain_errors(comparison.results[name].parameters, truth)
            table.add_row(name, _percent(mass), _percent(1e3 * com))
        lines.append(table)
    if not verbose:
        return Group(*lines, Text(MORE))
    lines.append(_checks(comparison, names))
    failed = {e.consistency.violated for e in comparison.results.values()}
    lines += [
        Text(f"no: {FAILURES[name]}: {text}")
        for name, text in EXPLANATIONS.items()
        if name in failed
    ]
    if any(name in VARIANTS for name in names):
        lines.append(
            Text("names with a hyphen: variants, see hefting methods --verbose")
        )
    lines.extend(Text(f"left out: {why}") for why in comparison.skipped.values())
    return Group(*lines, *map(Text, assumptions(best)))


def _answers(comparison: "Comparison", names: list[str]) -> Table:
    """Estimates of each method, with half-widths of their intervals."""
    table = plain_table("method", "mass\nkg", "COM x, y, z\nmm", MOMENTS)
    for name, following in zip(names, [*names[1:], None], strict=True):
        e = comparison.results[name]
        mark = " ◀" if name == comparison.recommended else ""
        doubt = "" if e.physically_consistent else "!"
        reach = _reach_of(e)
        com = 1e3 * e.parameters.center_of_mass
        table.add_row(
            f"[bold]{name}[/bold]{mark}" if mark else f"{name}{doubt}",
            with_reach([e.parameters.mass], reach and reach[0]),
            with_reach(com, reach and reach[1]),
            _moments(e, reach and reach[2:]),
            end_section=following in VARIANTS and name not in VARIANTS,
        )
    return table


def _reach_of(e: "Estimate") -> tuple[float, float, float, float] | None:
    """Largest half-widths of the 95 % intervals of mass [kg], COM [mm] and moments of
    inertia [10⁻³ kg m²], and the least of the moments; None without intervals."""
    if e.intervals is None:
        return None
    far = {
        name: np.abs(ends - getattr(e.parameters, name)).max(axis=0)
        for name, ends in e.intervals.items()
    }
    moments, com = 1e3 * np.diagonal(far["inertia_at_com"]), far["center_of_mass"]
    widest, least = float(moments.max()), float(moments.min())
    return float(far["mass"]), 1e3 * float(com.max()), widest, least


def _moments(e: "Estimate", reach: tuple[float, ...] | None) -> str:
    """Moments of inertia at the COM, with a digit of the one that is known best, which
    may be the least; or "open" where one is undetermined."""
    if e.undetermined.inertia_at_com.diagonal().any():
        return "open"
    return with_reach(1e3 * e.parameters.inertia_at_com.diagonal(), *(reach or [None]))


def _checks(comparison: "Comparison", names: list[str]) -> Table:
    """Residual, physical consistency and time of each method."""
    table = plain_table("method", "residual\nN, N m", "consistent", "time\nms")
    noise = comparison.ingested.noise
    for name in names:
        e = comparison.results[name]
        residual = _residual(e, np.array((noise.force, noise.torque)))
        failure = FAILURES[e.consistency.violated or "mass"]
        consistent = "yes" if e.physically_consistent else f"no: {failure}"
        spent = f"{1e3 * comparison.seconds[name]:.1f}"
        table.add_row(name, residual, consistent, spent)
    return table


def _residual(e: "Estimate", noise: Array) -> str:
    """Residual force and torque, marked where `noise` does not explain them."""
    r = e.residual
    if r is None:
        return ""
    misfit = bool((r > UNEXPLAINED_RESIDUAL_RATIO * noise).any())
    return f"{'! ' if misfit else ''}{r[0]:.2g}, {r[1]:.2g}"


def _errors_table(errors: "dict[str, Errors]") -> Table:
    table = plain_table("error in %", "mass", "COM", "inertia, sensor", "inertia, COM")
    for name, e in errors.items():
        found = (e.mass, e.center_of_mass, e.inertia_at_origin, e.inertia_at_com)
        table.add_row(name, *map(_percent, found))
    return table


def _percent(value: float) -> str:
    return (
        "< 0.01" if value < 0.01 else f"{value:.2g}" if value < 10.0 else f"{value:.0f}"
    )


FAILURES = {
    "mass": "mass",
    "inertia": "inertia",
    "triangle": "triangle",
    "pseudo_inertia": "pseudo",
    "hull": "COM",
}
"""The condition of consistency that fails, in a word."""


MOST_COLUMNS = 2
"""Largest number of estimates in columns; of more each has a row for each quantity."""
SHOWN = {"m": (1e3, "mm"), "kg m²": (1e3, "10⁻³ kg m²")}
"""Factor and unit in which a quantity is shown, by its own unit."""


def agreement_report(agreement: Agreement) -> Iterable[Line]:
    """Whether estimates agree, and which are in doubt; then every quantity with its 95 %
    interval and the largest difference in standard deviations."""
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
    own = "at the poses that are given, in its frame"
    grasp = "in the same grasp, and the same sensor frame"
    yield Line(
        f"assumed: the same object {grasp if agreement.frame == 'sensor' else own}. "
        "± 95 %; apart: standard deviations between the two that differ most; "
        "moments: the principal ones, compared along common axes"
    )


def _table_of(agreement: Agreement, names: dict[str, str]) -> Iterable[Line]:
    """Quantities as rows; for more than `MOST_COLUMNS` estimates a row for each."""
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
        known = sum(cell != "open" for cell in cells)
        far = _deviations(float(apart[at])) if known > 1 else ""
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
    """A value and the larger half of its interval, with two digits of that."""
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
    """File names, or letters where these are long or repeat."""
    names = [Path(path).stem for path in paths]
    if len(set(names)) < len(names) or max(map(len, names)) > 16:
        names = [chr(ord("A") + i) if i < 26 else f"{i + 1}" for i in range(len(paths))]
    return dict(zip(paths, names, strict=True))

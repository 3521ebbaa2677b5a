"""Methods, and the estimates of several of them side by side, as tables a person can
read."""

from typing import TYPE_CHECKING

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hefting.cli.report.estimate import assumptions
from hefting.cli.report.printing import verdict_texts, warning_lines
from hefting.cli.report.verdict import other_warnings
from hefting.core.inertia import EXPLANATIONS
from hefting.core.spatial import Array
from hefting.estimators import VARIANTS, describe_methods
from hefting.estimators.base import INVARIANCES
from hefting.ingest.plausibility import UNEXPLAINED_RESIDUAL_RATIO

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.core.metrics import Errors
    from hefting.identification.compare import Comparison


def methods_report() -> Group:
    """Every method: what it does, needs, guarantees, is best for and does not depend
    on."""
    known = describe_methods()
    table = Table(box=SIMPLE_HEAD, show_lines=True, pad_edge=False)
    for name in ("method", "what it does", "needs", "best for"):
        table.add_column(name, no_wrap=name == "method")
    for name, of in known.items():
        what = f"{of['summary']}\n[dim]{of['source']}[/dim]"
        table.add_row(f"[bold]{name}[/bold]", what, of["needs"], of["best_for"])
    lines = [
        f"always a body that can exist: {', '.join(name for name in known if known[name]['consistent'])}"
    ]
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
    comparison: "Comparison", errors: "dict[str, Errors] | None" = None
) -> Group:
    """Methods as rows: mass, COM, inertia, residual, consistent or why not, time; and
    which one to trust."""
    table = _comparison_table()
    names = list(comparison.results)
    for name, following in zip(names, [*names[1:], None], strict=True):
        row = _cells(comparison, name)
        table.add_row(*row, end_section=following in VARIANTS and name not in VARIANTS)
    best = comparison.results[comparison.recommended]
    lines: list[RenderableType] = [*verdict_texts(best.verdict), table]
    if errors:
        lines.append(_errors_table(errors))
    lines += _explain_failures(comparison)
    if any(name in VARIANTS for name in names):
        lines.append(Text("below the line: variants, see hefting methods"))
    lines.extend(Text(f"left out: {why}") for why in comparison.skipped.values())
    lines.append(
        Text(
            f"recommended: {comparison.recommended}, as {comparison.reason}",
            style="bold",
        )
    )
    warnings = other_warnings(best.warnings, best.verdict)
    return Group(*lines, *map(Text, assumptions(best)), *warning_lines(warnings))


def _comparison_table() -> Table:
    """The table of a comparison, with no rows yet."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("method", no_wrap=True)
    for name in (
        "mass\nkg",
        "COM x, y, z\nmm",
        "Jxx, Jyy, Jzz at COM\n10⁻³ kg m²",
        "residual\nN, N m",
    ):
        table.add_column(name, justify="right", overflow="fold")
    table.add_column("consistent", overflow="fold")
    table.add_column("time\nms", justify="right", no_wrap=True)
    return table


def _cells(comparison: "Comparison", name: str) -> list[str]:
    """The row of a method."""
    e, noise = comparison.results[name], comparison.ingested.noise
    return [
        f"[bold]{name}[/bold] ◀" if name == comparison.recommended else name,
        f"{e.parameters.mass:.4g}",
        ", ".join(
            f"{round(1e3 * x, 1) + 0.0:.1f}" for x in e.parameters.center_of_mass
        ),
        _moments(e),
        _residual(e, np.array((noise.force, noise.torque))),
        "yes"
        if e.physically_consistent
        else f"no: {FAILURES[e.consistency.violated or 'mass']}",
        f"{1e3 * comparison.seconds[name]:.1f}",
    ]


def _moments(e: "Estimate") -> str:
    """Moments of inertia at the COM, or that nothing determines them."""
    moments = e.parameters.inertia_at_com.diagonal()
    if e.undetermined.inertia_at_com.diagonal().any():
        return "open"
    least = 1e-9 * np.abs(moments).max()
    return ", ".join(f"{1e3 * x if abs(x) > least else 0.0:.2g}" for x in moments)


def _residual(e: "Estimate", noise: Array) -> str:
    """Residual force and torque, marked where the `noise` of both does not explain
    them."""
    r = e.residual
    if r is None:
        return ""
    misfit = bool((r > UNEXPLAINED_RESIDUAL_RATIO * noise).any())
    return f"{'! ' if misfit else ''}{r[0]:.2g}, {r[1]:.2g}"


def _explain_failures(comparison: "Comparison") -> list[Text]:
    """What each condition means that a result fails, one line each."""
    failed = {e.consistency.violated for e in comparison.results.values()}
    return [
        Text(f"no: {FAILURES[name]}: {EXPLANATIONS[name]}")
        for name in EXPLANATIONS
        if name in failed
    ]


def _errors_table(errors: "dict[str, Errors]") -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("error in %", no_wrap=True)
    for name in ("mass", "COM", "inertia, sensor", "inertia, COM"):
        table.add_column(name, justify="right", no_wrap=True)
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
"""The condition of consistency that fails, in a word or two."""

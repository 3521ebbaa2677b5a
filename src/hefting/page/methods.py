"""Methods: what each of several found, beside one another."""

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.estimators import METHODS, VARIANTS
from hefting.identification.compare import Comparison
from hefting.page.answer import Say
from hefting.page.bars import Row, bars
from hefting.page.frame import Section
from hefting.page.html import Markup, element, items, join, table
from hefting.page.quantities import GROUPS, NAMES, ends_of, ten


def methods(
    comparison: Comparison, truth: InertialParameters | None, say: Say
) -> Section:
    """A table of all methods, and each quantity by all of them."""
    best = comparison.recommended
    known = None if truth is None else ten(truth)
    shown = _shown(comparison)
    found = {name: (ten(e.parameters), *ends_of(e)) for name, e in shown.items()}
    groups = [
        _group(found, best, i, group.unit, None if known is None else float(known[i]))
        for group in GROUPS[:3]
        for i in group.rows
    ]
    lines = [
        f"{name} was left out: {say(why)}" for name, why in comparison.skipped.items()
    ]
    content = join(
        (
            element("p", f"Recommended: {best}, as {say(comparison.reason)}."),
            _table(shown, best),
            element("div", *groups, class_="groups"),
            items(lines),
        )
    )
    return Section("methods", "Methods side by side", content)


def _shown(comparison: Comparison) -> dict[str, Estimate]:
    """The estimates, without variants of methods where all methods were asked for."""
    results = comparison.results
    if not set(METHODS) <= {*results, *comparison.skipped}:
        return results
    return {name: e for name, e in results.items() if name not in VARIANTS}


def _table(shown: dict[str, Estimate], best: str) -> Markup:
    """Residual, consistency and verdict of each."""
    rows = []
    for name, estimate in shown.items():
        residual = estimate.residual
        marked = f"{name} ◀" if name == best else name
        rows.append(
            (
                marked,
                estimate.verdict,
                "" if residual is None else f"{residual[0]:.2g}",
                "" if residual is None else f"{residual[1]:.2g}",
                "yes" if estimate.physically_consistent else "no",
            )
        )
    head = ("method", "verdict", "residual [N]", "residual [N m]", "a body can be so")
    return table(head, rows)


def _group(found: dict, best: str, i: int, unit: str, truth: float | None) -> Markup:
    """One quantity by all methods; the scale is made for the one recommended."""
    rows = [
        Row(name, float(v[i]), float(low[i]), float(high[i]), truth, name == best)
        for name, (v, low, high) in found.items()
    ]
    own = next(row for row in rows if row.matters)
    reach = 3.0 * max(own.high - own.low, 0.05 * abs(own.value or 0.0))
    rows = [row if row.matters else _near(row, own, reach) for row in rows]
    return element("div", element("h3", NAMES[i]), bars(rows, unit))


def _near(row: Row, own: Row, reach: float) -> Row:
    """The row, which matters for the scale if its value is near the recommended one."""
    near = row.value is not None and abs(row.value - (own.value or 0.0)) <= reach
    return Row(row.name, row.value, row.low, row.high, row.truth, near)

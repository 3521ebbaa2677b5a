"""A planned motion as a readable report: accuracy now and after it, binding limits,
assumptions."""

from collections.abc import Iterable

import numpy as np

from hefting.cli.report.estimate import Line
from hefting.core.accuracy import Accuracy
from hefting.planning.result import Plan, reduced_speed_text, speed_text

ROWS = {
    "mass": ("mass", "%", 1e2),
    "center_of_mass": ("COM", "mm", 1e3),
    "inertia": ("inertia", "%", 1e2),
}
"""Name, unit and factor of each quantity of an `Accuracy`."""
OPEN = "open"
"""Text for an unknown quantity."""
MOST_OPEN = 10.0
"""Half-width (relative, of the COM in m) above which a quantity is open."""


def plan_report(plan: Plan, verbose: bool) -> list[Line]:
    """The motion, half-widths now, after it and as asked, binding limits, and
    assumptions; with `verbose` also the used share of each limit."""
    lines = [Line(_headline(plan), "bold")]
    lines += [Line(f"{own.severity}: {own}", "yellow") for own in plan.warnings]
    lines += [Line(text, whole=True) for text in _table(plan)]
    lines += [Line(f"binds: {text}") for text in plan.binding]
    lines.append(Line(_speed(plan)))
    lines += [Line(f"- {text}") for text in plan.notes]
    if verbose and plan.usage:
        used = (f"{name} {1e2 * share:.0f} %" for name, share in plan.usage.items())
        lines.append(Line(f"used of each limit: {', '.join(used)}"))
    return lines


def _headline(plan: Plan) -> str:
    what = (
        f"motion of {plan.duration:.4g} s for '{plan.tip}' by {len(plan.joints)} joints"
    )
    if plan.time_needed is None:
        return what
    return f"{what}: what is asked is expected after {plan.time_needed:.3g} s"


def _speed(plan: Plan) -> str:
    """The largest speed of a corner, its limit, and whether that is reduced speed."""
    limit = plan.limits.corner_speed
    what = "assumed box" if plan.box_is_assumed else "object"
    of = f"corner of the {what}" if len(plan.corners) > 1 else "point, the tip,"
    used = plan.usage.get("corner_speed")
    if used is None:
        return f"every {of} keeps {speed_text(limit)}"
    fastest = speed_text(used * limit).removesuffix(" mm/s")
    return (
        f"{reduced_speed_text(plan)}: the fastest {of} moves at {fastest} of "
        f"{speed_text(limit)}"
    )


def _table(plan: Plan) -> list[str]:
    """Half-widths of 95 % intervals now, after the motion, and as asked."""
    first, last = plan.forecast.accuracy[0], plan.forecast.accuracy[-1]
    head = ["", "± now", "± after", *(["asked"] if plan.asked is not None else []), ""]
    rows = [head]
    for name, (label, unit, factor) in ROWS.items():
        each = [_cell(x, name, factor) for x in (first, last)]
        if plan.asked is not None:
            each.append(_cell(plan.asked, name, factor, ""))
        rows.append([label, *each, unit])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [_row(row, widths) for row in rows]


def _row(row: list[str], widths: Iterable[int]) -> str:
    cells = [
        text.ljust(width) if i in (0, len(row) - 1) else text.rjust(width)
        for i, (text, width) in enumerate(zip(row, widths, strict=True))
    ]
    return "  ".join(cells).rstrip()


def _cell(accuracy: Accuracy, name: str, factor: float, without: str = OPEN) -> str:
    value = getattr(accuracy, name)
    if value is None:
        return without
    if not np.isfinite(value) or value > MOST_OPEN:
        return OPEN
    return f"{factor * value:.2g}" if factor * value < 1e2 else f"{factor * value:.0f}"

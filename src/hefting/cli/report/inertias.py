"""Inertials of a URDF as a readable report: a line for each link that fails, and the
number of the others."""

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from hefting.cli.report.printing import bare_table, warning_lines
from hefting.core.errors import printable
from hefting.robots import LinkCheck, Repaired
from hefting.robots.inertia_check import THINNEST_LENGTH
from hefting.robots.urdf import listed

CONDITIONS = {
    "inertial-unreadable": "cannot be read",
    "inertial-mass": "mass not positive",
    "inertial-zero": "tensor is zero",
    "inertial-not-definite": "tensor not positive definite",
    "inertial-triangle": "triangle inequality",
    "inertial-thin": "no thickness",
}
"""The condition that fails, in a few words."""


def inertias_report(repaired: Repaired, written: str | None) -> Group:
    """Links that fail, the number of others, and the `written` file or what to do."""
    failing, links = repaired.failing, len(repaired.checks)
    massless = sum(checked.inertial.is_massless for checked in repaired.checks)
    name = printable(repaired.source)
    lines: list[RenderableType] = []
    if failing:
        text = f"no body can have the inertials of {len(failing)} of {links} links"
        lines += [Text(f"{name}: {text}", style="yellow"), _table(failing)]
        lines += _legend(failing)
    others = links - len(failing) - massless
    text = f"fine: {others} link{'s' * (others != 1)}, and {massless} without mass"
    lines.append(Text(text if failing else f"{name}: all {text}"))
    return Group(
        *lines, *warning_lines(_doubts(repaired.checks)), *_what_next(repaired, written)
    )


def _table(failing: list[LinkCheck]) -> Table:
    table = bare_table()
    table.add_column("link", overflow="fold")
    table.add_column("what fails", overflow="fold")
    table.add_column("by", justify="right", no_wrap=True)
    table.add_column("nearest", justify="right", no_wrap=True)
    for checked in failing:
        table.add_row(*map(Text, _cells(checked)))
    return table


def _legend(failing: list[LinkCheck]) -> list[Text]:
    """Explanations of the last two columns, and of the least tensor."""
    lines = []
    if any(
        checked.change is not None and not checked.inertial.is_point
        for checked in failing
    ):
        lines += [
            "by: share of the largest moment; nearest: change of the tensor with mass",
            "and COM kept (Frobenius norm of the second moments)",
        ]
    if any(checked.inertial.is_point for checked in failing):
        lines.append(
            f"least: a size of {1e3 * THINNEST_LENGTH:g} mm; better give the real one"
        )
    return [Text(line) for line in lines]


def _cells(checked: LinkCheck) -> list[str]:
    """Link, condition, shortfall, distance to the nearest tensor."""
    assert checked.fault is not None  # only failing links come here
    what = CONDITIONS[checked.fault.code]
    if checked.fault.code == "inertial-unreadable":
        what = str(checked.fault).partition(": ")[2]
    if checked.shortfall is None:
        by = ""
    elif checked.fault.code == "inertial-mass":
        by = f"{checked.inertial.mass:.3g} kg"
    else:
        by = _percent(checked.shortfall)
    change = "none" if checked.change is None else _percent(checked.change)
    if checked.fault.code == "inertial-zero":
        change = "least"
    return [printable(checked.link), what, by, change]


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def _doubts(checks: list[LinkCheck]) -> list[str]:
    """A line for each kind of doubt: its first link, and the number of others."""
    of_kind: dict[str, list[str]] = {}
    for checked in checks:
        for doubt in checked.doubts:
            text = f"{printable(checked.link)}: {printable(doubt)}"
            of_kind.setdefault(doubt.code, []).append(text)
    return [
        first + (f" (and {len(more)} more like it: --json)" if more else "")
        for first, *more in of_kind.values()
    ]


def _what_next(repaired: Repaired, written: str | None) -> list[Text]:
    """The written file and the links left, or how to repair."""
    by_hand = listed((printable(c.link) for c in repaired.remaining), 10)
    lines = []
    if repaired.remaining:
        lines.append(f"to be given by hand, as no tensor helps: {by_hand}")
    count = len(repaired.failing) - len(repaired.remaining)
    if written:
        lines.append(
            f"wrote {written}, with {count} of {len(repaired.failing)} repaired"
        )
    elif count:
        lines.append("see the nearest tensors: --diff; write them: --repair FILE")
    return [Text(line) for line in lines]

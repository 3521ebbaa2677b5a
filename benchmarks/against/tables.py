"""The comparison as tables of text, for the terminal and for the documentation."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from rich.table import Table as RichTable

from benchmarks.against.cost import slope
from benchmarks.against.ours import BARE
from benchmarks.report import number, seconds
from hefting.reproduction.experiment import MOSTLY_WRONG, shown

MISSED, PRINTED = "**missed**", "[bold]missed[/bold]"
"""Of a goal, on a page and on the terminal."""


@dataclass(frozen=True)
class Table:
    """Headings and rows of text."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def tables(values: dict[str, Any]) -> list[Table]:
    """All of them, from what `benchmarks.against.measure` says."""
    found = [of_set(each) for each in values["sets"]]
    found += [of_cost(values["cost"]), paper(values["published"])]
    return [*found, *goals(values)]


def of_set(each: dict[str, Any]) -> Table:
    """Every party on one set; those without intervals are told in brackets."""
    times = {p["party"]: p["seconds"] for p in each["parties"]}
    rows = []
    for p in each["parties"]:
        if p["party"].endswith(BARE):
            continue
        bare = times.get(p["party"] + BARE)
        time = seconds(p["seconds"]) + (f" ({seconds(bare)})" if bare else "")
        ratio = p["seconds"] / times[p["beside"]] if p["beside"] in times else None
        rows.append(
            (
                p["party"],
                " / ".join(error(e) for e in p["errors"].values()),
                f"{p['consistent']:.0f} %",
                held(p),
                time,
                "" if ratio is None else number(ratio, ""),
            )
        )
    return Table(
        f"{each['recordings']} {each['set']}, {each['samples']:,} samples each",
        (
            "",
            "mass / COM / inertia %",
            "bodies",
            "95 % hold",
            "time",
            "over Hefting's",
        ),
        tuple(rows),
    )


def error(value: float | None) -> str:
    """A median error [%]."""
    return "none" if value is None else shown(value)


def held(party: dict[str, Any]) -> str:
    """How many intervals hold, and how many numbers have one if not all."""
    if party["held"] is None:
        return "none"
    some = "" if party["intervals"] == 10 else f", of {party['intervals']} numbers"
    return f"{party['held']:.1f} %{some}"


def of_cost(cost: dict[str, Any]) -> Table:
    """Times at the ends of every curve, and how they grow."""
    rows = []
    for what, curves in cost.items():
        for party, curve in curves.items():
            at, took = curve["at"], curve["seconds"]
            rows.append(
                (
                    what,
                    party,
                    f"{seconds(took[0])} at {at[0]:,}",
                    f"{seconds(took[-1])} at {at[-1]:,}",
                    f"{slope(curve):.2f}" if len(at) > 1 else "",
                )
            )
    return Table(
        "Cost against samples, points and recordings of 150 samples",
        ("", "party", "least", "most", "power"),
        tuple(rows),
    )


def paper(rows: Sequence[dict[str, Any]]) -> Table:
    """The published table, and ours."""
    speeds = " / ".join(f"{speed:g}" for speed in rows[0]["speeds"])
    names = {"published": "the paper", "warm": "here, warm", "cold": "here, cold"}
    return Table(
        f"The paper's table of 150 observations: mean errors at {speeds} rad/s",
        ("method", "source", "mass %", "COM %", "inertia %"),
        tuple(
            (
                row["method"],
                names[row["source"]],
                *(
                    " / ".join(map(clipped, errors))
                    for errors in row["errors"].values()
                ),
            )
            for row in sorted(rows, key=_by_method(rows))
        ),
    )


def _by_method(rows: Sequence[dict[str, Any]]):
    order = list(dict.fromkeys(row["method"] for row in rows))
    return lambda row: order.index(row["method"])


def clipped(value: float | None) -> str:
    """An error [%], as the paper prints it."""
    return "> 500" if value is None or value >= MOSTLY_WRONG else shown(value)


def goals(values: dict[str, Any]) -> list[Table]:
    """Every goal, those of the sets side by side, those of cost below each other; what
    is missed stands out."""
    found: dict[str, dict[str, dict[str, Any]]] = {}
    for goal in values["goals"]:
        where = goal["section"].removeprefix("against peers, ")
        found.setdefault(goal["what"], {})[where] = goal
    sets = list(
        dict.fromkeys(
            where for each in found.values() for where in each if "," in where
        )
    )
    of_sets = {what: each for what, each in found.items() if sets[0] in each}
    others = {what: each["cost"] for what, each in found.items() if "cost" in each}
    return [
        Table(
            "Goals by set",
            ("", "goal", *sets),
            tuple(
                (
                    what,
                    bound(next(iter(each.values()))),
                    *(reached(each[name]) if name in each else "" for name in sets),
                )
                for what, each in of_sets.items()
            ),
        ),
        Table(
            "Goals of cost",
            ("", "goal", "found"),
            tuple((what, bound(g), reached(g)) for what, g in others.items()),
        ),
    ]


def bound(goal: dict[str, Any]) -> str:
    """What a figure should be."""
    unit = "%" if goal["unit"] == "%" else ""
    if goal["at_least"] is not None:
        return f"≥ {number(goal['at_least'], unit)}"
    return f"≤ {number(goal['at_most'], unit)}"


def reached(goal: dict[str, Any]) -> str:
    """What it is, and that it is missed."""
    figure = number(goal["figure"], "%" if goal["unit"] == "%" else "")
    return figure if goal["met"] else f"{figure} {MISSED}"


def show(every: Sequence[Table]) -> None:
    """Print them."""
    console = Console(width=140)
    for table in every:
        printed = RichTable(
            title=table.title, title_justify="left", show_edge=False, pad_edge=False
        )
        for i, column in enumerate(table.columns):
            printed.add_column(column, justify="left" if i == 0 else "right")
        for row in table.rows:
            cells = (cell.replace("**missed**", "[bold]missed[/bold]") for cell in row)
            printed.add_row(*cells)
        console.print(printed)
        console.print()


def markdown(table: Table) -> str:
    """As a section of a page."""
    rule = "|".join("---" for _ in table.columns)
    lines = [" | ".join(row) for row in (table.columns, *table.rows)]
    body = [f"| {line} |" for line in lines]
    return "\n".join((f"### {table.title}", "", body[0], f"|{rule}|", *body[1:]))

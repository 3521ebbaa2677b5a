"""Ratios that are kept from run to run in ratios.json, and those that have become
worse.

Absolute times differ from machine to machine; ratios of parties that take turns hardly
do.
"""

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks.report import Section

FILE = Path(__file__).with_name("ratios.json")
WORSE = 1.3
"""Times that a ratio may be worse than the one kept."""
FASTER, SHARE = "times faster", "share of the time or memory"
"""Kinds of ratios: more is better, less is better."""

Ratios = dict[str, dict[str, float]]
"""By kind, then name."""


@dataclass(frozen=True)
class Change:
    """A ratio beside the one that is kept."""

    name: str
    kind: str
    kept: float | None
    found: float | None

    @property
    def worse(self) -> float | None:
        """Times as bad as the one kept; None where there are not both."""
        if self.kept is None or self.found is None:
            return None
        return self.kept / self.found if self.kind == FASTER else self.found / self.kept

    @property
    def failed(self) -> bool:
        """Whether it is too much worse."""
        return self.worse is not None and not self.worse < WORSE

    def __str__(self) -> str:
        return f"{self.name}: {self.worse:.2f} times worse ({self.kind}: {self.found:.3g}, kept {self.kept:.3g})"


def ratios_of(sections: Iterable[Section]) -> Ratios:
    """Every ratio of a report, rounded to four digits; the number of points is no part
    of its name."""
    found: Ratios = {FASTER: {}, SHARE: {}}
    for section in sections:
        above, title = "", re.sub(r", [\d,]+ points\b", "", section.title)
        for row in section.rows:
            own = row.what.strip()
            above = above if row.what.startswith(" ") else own
            if row.figure is None or not (row.name or row.unit == "x"):
                continue
            name = row.name or ", ".join(dict.fromkeys((title, above, own)))
            kind = FASTER if row.unit == "x" else SHARE
            if name in found[kind]:
                raise ValueError(f"two ratios are named '{name}'")
            found[kind][name] = float(f"{row.figure:.4g}")
    return found


def better(one: Ratios, other: Ratios) -> Ratios:
    """Of two measurements of the same ratios the better ones."""
    best = {FASTER: max, SHARE: min}
    return {
        kind: {
            name: best[kind](ratio, other[kind].get(name, ratio))
            for name, ratio in one[kind].items()
        }
        for kind in one
    }


def merged(parts: Iterable[Ratios]) -> Ratios:
    """All of them; their names differ."""
    found: Ratios = {FASTER: {}, SHARE: {}}
    for part in parts:
        for kind, each in part.items():
            found[kind] |= each
    return found


def read(path: Path, quick: bool) -> Ratios:
    """The ratios that are kept for this setting, if any."""
    kept = json.loads(path.read_text()) if path.exists() else {}
    return {FASTER: {}, SHARE: {}} | kept.get(_setting(quick), {})


def keep(path: Path, quick: bool, found: Ratios) -> None:
    """Write them in place of those kept for this setting."""
    kept = json.loads(path.read_text()) if path.exists() else {}
    path.write_text(
        json.dumps(kept | {_setting(quick): found}, indent=1, ensure_ascii=False) + "\n"
    )


def _setting(quick: bool) -> str:
    return "quick" if quick else "full"


def changes(kept: Ratios, found: Ratios) -> list[Change]:
    """Every ratio that is kept or was found."""
    return [
        Change(name, kind, kept[kind].get(name), found[kind].get(name))
        for kind in (SHARE, FASTER)
        for name in dict.fromkeys((*kept[kind], *found[kind]))
    ]


def failures(kept: Ratios, found: Ratios) -> list[Change]:
    """Those that are too much worse."""
    return [change for change in changes(kept, found) if change.failed]


def show_changes(compared: list[Change]) -> None:
    """Print a table of ratios beside those kept."""
    table = Table(show_edge=False, pad_edge=False)
    table.add_column("ratio", overflow="fold")
    for name in ("kept", "now", "times worse"):
        table.add_column(name, justify="right", no_wrap=True)
    for kind in (SHARE, FASTER):
        table.add_section()
        table.add_row(
            f"[bold]{kind}[/bold], {'more' if kind == FASTER else 'less'} is better"
        )
        for change in compared:
            if change.kind == kind:
                kept, found = (_shown(value) for value in (change.kept, change.found))
                worse = _shown(change.worse)
                table.add_row(
                    f"  {change.name}",
                    kept,
                    found,
                    f"[bold]{worse} ![/bold]" if change.failed else worse,
                )
    Console(width=118).print(table)


def _shown(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"

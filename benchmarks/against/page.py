"""The kept figures, and the tables of the documentation made from them."""

import json
from pathlib import Path
from typing import Any

from benchmarks.against.tables import markdown, tables

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "benchmarks" / "against.json"
"""Figures of the last run that was kept."""
PAGE = ROOT / "docs" / "peers.md"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
"""Between these the page is written by `rendered`."""


def kept(path: Path = KEPT) -> dict[str, Any]:
    """What was kept."""
    return json.loads(path.read_text())


def keep(values: dict[str, Any], path: Path = KEPT, page: Path = PAGE) -> None:
    """Write the figures, and the page's tables anew."""
    path.write_text(text(values))
    page.write_text(with_tables(page.read_text(), values))


def text(values: dict[str, Any]) -> str:
    """As JSON."""
    return json.dumps(values, indent=1, ensure_ascii=False) + "\n"


def rendered(values: dict[str, Any]) -> str:
    """Versions and tables as Markdown."""
    versions = ", ".join(f"{name} {v}" for name, v in values["versions"].items())
    parts = [f"Versions: {versions}.", *map(markdown, tables(values))]
    return "\n\n".join(parts)


def with_tables(page: str, values: dict[str, Any]) -> str:
    """The page with its measured part replaced."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n\n{rendered(values)}\n\n{END}{after}"

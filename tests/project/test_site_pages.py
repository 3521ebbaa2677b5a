"""Pages of the site that list what the library has leave nothing out."""

import re
from pathlib import Path

from hefting.export import REGISTRY

DOCS = Path(__file__).parents[2] / "docs"
FAILS = (DOCS / "fails.md").read_text()
LARGEST_PICTURE = 60_000
"""Bytes: pictures of this size do not weigh on a clone."""


def test_each_mistake_that_is_looked_for_is_on_the_page_of_failures():
    table = (DOCS / "mistakes.md").read_text().split("| code | mistake |", 1)[1]
    cells = [row.split("|")[1] for row in table.split("\n\n")[0].splitlines()[2:]]
    codes = {code for cell in cells for code in re.findall(r"`([\w-]+)`", cell)}
    assert len(codes) > 20
    assert codes == set(re.findall(r"Code `([\w-]+)`", FAILS))


def test_each_mistake_has_a_small_picture_and_no_picture_is_left_over():
    shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", FAILS)
    assert len(shown) == FAILS.count("\n### ")
    there = {path.relative_to(DOCS).as_posix() for path in DOCS.glob("mistakes_seen/*")}
    assert there == set(shown)
    for name in shown:
        assert (DOCS / name).stat().st_size < LARGEST_PICTURE, name


def test_each_target_of_a_simulator_or_controller_is_listed():
    """With what it takes."""
    text = (DOCS / "howto" / "controllers.md").read_text()
    rows = [line.split("|") for line in text.splitlines() if line.startswith("|")]
    listed = {
        name: row[3].strip()
        for row in rows
        for name in re.findall(r"`([\w-]+)`", row[2])
    }
    ours = {name for name in REGISTRY if name not in ("json", "csv")}  # for Hefting
    assert set(listed) == ours
    for name in ours:
        target = REGISTRY[name]
        if target.needs_inertia:
            continue
        takes = "mass, COM, inertia" if target.takes_inertia else "mass, COM"
        assert listed[name] == takes, name


def test_figures_on_trust_are_those_of_the_pages_that_measured_them():
    """A number of the table stands in the README or on a page that it leads to."""
    text = (DOCS / "trust.md").read_text()
    names = {"README"} | set(re.findall(r"\]\((\w+)\.md", text))
    source = (DOCS.parent / "README.md").read_text()
    source += "".join((DOCS / f"{name}.md").read_text() for name in names - {"README"})
    rows = [line.split("|")[2] for line in text.splitlines() if line.startswith("| ")]
    figures = {number for row in rows for number in re.findall(r"\d+\.\d+", row)}
    assert len(figures) > 10
    known = set(re.findall(r"\d+\.\d+", source))
    assert not figures - known

"""`python -m benchmarks.against [--quick] [--json FILE] [--figure FILE] [--keep]`:
Hefting and its peers on the same recordings, on one thread.

mujoco.sysid, CVXPY with Clarabel, Pinocchio with NumPy's `lstsq`, and the published
table of the paper: accuracy, consistency, intervals and time on random tools and, where
HEFTING_DATA names their folder, twelve workshop tools; cost against samples, points and
recordings. `docs/peers.md` says how each is set up. Six minutes; a ratio that is 1.3
times worse than that kept in ratios.json ends with an error.
"""

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL", "RAYON"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

if TYPE_CHECKING:
    from benchmarks.report import Section

PART = "peers"
"""Begins the names of ratios that are kept."""


def main() -> None:
    """Compare Hefting with its peers on the same recordings, and print tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.against", description=main.__doc__
    )
    parser.add_argument(
        "--quick", action="store_true", help="fewer and shorter: a check that it runs"
    )
    parser.add_argument(
        "--json", metavar="FILE", type=Path, help="write the figures to a file as well"
    )
    parser.add_argument(
        "--figure", metavar="FILE", type=Path, help="draw cost: .png, .svg or .pdf"
    )
    parser.add_argument(
        "--keep",
        action="store_true",
        help="keep figures, ratios and the documentation's tables",
    )
    arguments = parser.parse_args()
    if arguments.keep and arguments.quick:
        parser.error("a quick run is not kept")

    from benchmarks import ratios
    from benchmarks.against import page
    from benchmarks.against.figure import cost_figure
    from benchmarks.against.measure import comparison
    from benchmarks.against.tables import show, tables
    from hefting.plots.style import picture_of, picture_suffix

    suffix = picture_suffix(arguments.figure) if arguments.figure else None
    found = comparison(arguments.quick)
    show(tables(found.values))
    if arguments.json is not None:
        arguments.json.write_text(page.text(found.values))
    if suffix is not None:
        picture = picture_of(cost_figure(found.values["cost"]), suffix)
        arguments.figure.write_bytes(picture)
    now = ratios.ratios_of(found.sections)
    before = ratios.read(ratios.FILE, arguments.quick)
    if arguments.keep:
        page.keep(found.values)
        ratios.keep(ratios.FILE, False, replaced(before, now))
        return
    failed = ratios.failures(before, now)
    if failed:
        sys.exit("\n".join(("worse than the ratios kept:", *map(str, failed))))


def replaced(
    before: dict[str, dict[str, float]], now: dict[str, dict[str, float]]
) -> dict[str, dict[str, float]]:
    """The ratios kept, those of peers new."""
    others = {
        kind: {name: r for name, r in each.items() if not name.startswith(f"{PART}, ")}
        for kind, each in before.items()
    }
    return {kind: others[kind] | now[kind] for kind in others}


def sections() -> "list[Section]":
    """All rows with goals; prints the tables as well."""
    from benchmarks.against.measure import comparison
    from benchmarks.against.tables import show, tables

    found = comparison(quick=False)
    show(tables(found.values))
    return found.sections


if __name__ == "__main__":
    main()

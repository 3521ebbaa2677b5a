"""`python -m benchmarks [--quick] [--json FILE] [--keep]`: every comparison in one run,
on one thread.

Ratios are compared with those in ratios.json; where one is 1.3 times worse, twice in a
row, it ends with an error. `--keep` writes that file anew.
"""

import argparse
import os
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL", "RAYON"):
    # read when NumPy and the conic solver are loaded
    os.environ[f"{library}_NUM_THREADS"] = "1"

if TYPE_CHECKING:
    from benchmarks.report import Section


def main() -> None:
    """Time Hefting beside what one would use instead, in one run, on one thread."""
    from benchmarks import ratios
    from benchmarks.report import saved, show

    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=main.__doc__
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="smaller and fewer: a check that it all runs",
    )
    parser.add_argument(
        "--json", metavar="FILE", type=Path, help="write the figures to a file as well"
    )
    parser.add_argument(
        "--keep",
        action="store_true",
        help="keep the ratios found, to compare later runs with",
    )
    parser.add_argument(
        "--ratios",
        metavar="FILE",
        type=Path,
        default=ratios.FILE,
        help="where they are kept",
    )
    parser.add_argument(
        "--only",
        metavar="TEXT",
        default="",
        help="parts whose name has it; cannot be kept",
    )
    parser.add_argument(
        "--before",
        metavar="PATH",
        type=Path,
        help="checkout of the code before; default from git",
    )
    arguments = parser.parse_args()
    if arguments.only and arguments.keep:
        parser.error("--keep is for all of them, --only for some")
    with TemporaryDirectory() as folder:
        parts = dict(every(Path(folder), arguments.before, arguments.quick))
        chosen = {
            name: make
            for name, make in parts.items()
            if arguments.only.lower() in name.lower()
        }
        found = {name: measured(name, make) for name, make in chosen.items()}
        kept = ratios.read(arguments.ratios, arguments.quick)
        best = {name: ratios.ratios_of(sections) for name, sections in found.items()}
        for name, make in chosen.items():
            if not arguments.keep and ratios.failures(kept, best[name]):
                again = ratios.ratios_of(measured(f"{name}, once more", make))
                best[name] = ratios.better(best[name], again)
    sections = [section for each in found.values() for section in each]
    show(sections)
    if arguments.json is not None:
        saved(sections, arguments.quick, arguments.json)
    together = ratios.merged(best.values())
    compared = ratios.changes(kept, together)
    if arguments.keep:
        ratios.keep(arguments.ratios, arguments.quick, together)
        for change in compared:
            if change.found is None:
                tell(f"no longer kept, as it was not measured: {change.name}")
        return
    if not any(kept.values()):
        tell(
            f"no ratios are kept for this setting in {arguments.ratios}: nothing to compare with; see --keep"
        )
        return
    ratios.show_changes(
        [change for change in compared if not (arguments.only and change.found is None)]
    )
    failed = ratios.failures(kept, together)
    if failed:
        sys.exit("\n".join(("worse than the ratios kept:", *map(str, failed))))


def every(
    folder: Path, before: Path | None, quick: bool
) -> "Iterator[tuple[str, Callable[[], Section | list[Section]]]]":
    """Name of each part, and what measures it."""
    from benchmarks.against.__main__ import PART
    from benchmarks.against.__main__ import sections as against_peers
    from benchmarks.conic import against_conic_solver
    from benchmarks.estimators import (
        from_the_moments,
        geo_against_conic_solver,
        lmi_against_conic_solver,
    )
    from benchmarks.intervals import with_intervals
    from benchmarks.least_squares import against_pinocchio
    from benchmarks.long_recording import long_recording
    from benchmarks.memory import folding_memory
    from benchmarks.points import many_points
    from benchmarks.posterior import posterior
    from benchmarks.processes import QUICK_ROWS, ROWS, Processes
    from benchmarks.streaming import one_sample_at_a_time

    yield from Processes(folder, before, quick).sections()
    many = 300 if quick else 3500
    yield (
        "PMD, 150 samples",
        partial(against_conic_solver, 150, rounds=1 if quick else 20),
    )
    yield (
        f"PMD, {many:,} samples",
        partial(against_conic_solver, many, rounds=1 if quick else 5),
    )
    yield "PMD, a live stream", partial(one_sample_at_a_time, 150 if quick else 3000)
    yield "GEO", partial(geo_against_conic_solver, 1000, rounds=1 if quick else 10)
    yield "LMI", partial(lmi_against_conic_solver, 1000, rounds=1 if quick else 10)
    rounds = 1 if quick else 50
    yield (
        "from the moments",
        partial(from_the_moments, 1000, 2_000 if quick else 100_000, rounds=rounds),
    )
    many_samples = 2_000 if quick else 100_000
    yield "intervals", partial(with_intervals, 1000, many_samples, rounds=rounds)
    yield "Bayes", partial(posterior, 2_000 if quick else 10_000, rounds=rounds)
    yield (
        "many points",
        partial(many_points, 2_000 if quick else 100_000, rounds=1 if quick else 7),
    )
    yield "OLS", partial(against_pinocchio, 1000, rounds=rounds)
    yield "folding", partial(folding_memory, 200_000 if quick else 10_000_000)
    # the log is that of the whole processes above
    yield (
        "a long recording",
        partial(long_recording, QUICK_ROWS if quick else ROWS, folder),
    )
    if not quick:  # it has a quick run of its own
        yield PART, against_peers


def measured(
    name: str, make: "Callable[[], Section | list[Section]]"
) -> "list[Section]":
    """Its sections."""
    tell(name)
    found = make()
    return found if isinstance(found, list) else [found]


def tell(line: str) -> None:
    """A line on standard error."""
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()

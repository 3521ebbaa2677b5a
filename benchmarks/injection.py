"""`python -m benchmarks.injection [--bodies N] [--seed S] [--exact WHAT] [--json FILE]`:
how often intervals hold on real recordings.

Random bodies of 0.1 to 2 kg are added to recordings of three robots with three sensors,
and identified with what those really held as a tool (`benchmarks.injected`), in whole
recordings and in parts of 4, 6 and 9 s: by Bayes with the shape, and by the default
method without one. With `--exact` the tool, or the sensor, is taken to have no errors
but noise, which tells what its errors make of the intervals. Needs the recordings in
the folder that HEFTING_DATA names. Some twenty minutes for 200 bodies.
"""

import argparse
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

if TYPE_CHECKING:
    from benchmarks.injected_runs import Run

MEDIAN_OF_NORMAL = 0.6745
"""Median size of a standard normal number."""


def main() -> None:
    """Print one table for each method."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.injection", description=main.__doc__
    )
    parser.add_argument("--bodies", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--exact",
        action="append",
        default=[],
        choices=("sensor", "tool"),
        help="taken to have no errors but noise; may be given twice",
    )
    parser.add_argument("--json", type=Path, help="write the figures of the tables")
    arguments = parser.parse_args()
    if not os.environ.get("HEFTING_DATA"):
        parser.error("set HEFTING_DATA to the folder of the recordings")

    from benchmarks.injected import cases, hosts
    from benchmarks.injected_runs import METHODS, identified

    runs: list[Run] = []
    for case in cases(
        hosts(Path(os.environ["HEFTING_DATA"])), arguments.bodies, arguments.seed
    ):
        runs += identified(case, arguments.exact)
    figures = {method: table(runs, method) for method in METHODS}
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1))


def table(runs: "list[Run]", method: str) -> list[dict[str, float | str]]:
    """Print and return the figures of one method: pooled, and of each data set and
    length."""
    own = [run for run in runs if run.method == method]
    print(f"\n{method}: {len(own)} identifications")
    print(
        f"{'':14}{'number':>7}{'refused':>9}{'doubted':>9}{'95 % hold':>11}"
        f"{'mass':>7}{'COM':>7}{'inertia':>9}{'beyond twice':>14}"
        f"{'mass: error, half-width [kg], ratio':>38}"
    )
    groups = list(dict.fromkeys((run.set, run.window) for run in own))
    rows = [line("all", own)]
    rows += [
        line(
            f"{data} {window}", [r for r in own if (r.set, r.window) == (data, window)]
        )
        for data, window in groups
    ]
    return rows


def line(name: str, chosen: "list[Run]") -> dict[str, float | str]:
    """Print and return the figures of some runs.

    Shares are of those identified [%]: refused are those not identifiable, doubted
    those whose mass is said not to be determined. The ratio is that of the median
    half-width to the standard deviation of a normal error with the same median.
    """
    import numpy as np

    found = [run for run in chosen if run.held is not None]
    if not found:
        return {"name": name, "number": len(chosen)}
    held = np.array([run.held for run in found])
    mass, com, inertia = (
        100.0 * float(held[:, part].mean())
        for part in (slice(1), slice(1, 4), slice(4, 10))
    )
    error, half = (
        float(np.median([getattr(run, key) for run in found]))
        for key in ("error", "half_width")
    )
    row: dict[str, float | str] = {
        "name": name,
        "number": len(chosen),
        "refused": len(chosen) - len(found),
        "doubted": sum(run.doubted for run in found),
        "held": 100.0 * float(held.mean()),
        "mass": mass,
        "com": com,
        "inertia": inertia,
        "beyond_twice": 100.0 * float(np.mean([run.beyond_twice for run in found])),
        "mass_error": error,
        "mass_half_width": half,
        "ratio": half / (error / MEDIAN_OF_NORMAL),
    }
    print(
        f"{name:14}{row['number']:7}{row['refused']:9}{row['doubted']:9}"
        f"{row['held']:11.1f}{mass:7.1f}{com:7.1f}{inertia:9.1f}"
        f"{row['beyond_twice']:14.1f}{error:16.4f}{half:10.4f}{row['ratio']:9.2f}",
        flush=True,
    )
    return row


if __name__ == "__main__":
    main()

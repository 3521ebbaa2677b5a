"""`python -m benchmarks [--quick] [--json FILE]`: every comparison in one run, on one thread."""

import argparse
import json
import os
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL", "RAYON"):
    os.environ[f"{library}_NUM_THREADS"] = "1"  # read when NumPy and the conic solver are loaded


def main() -> None:
    """Time the estimators beside what one would use instead, in one run, on one thread."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=main.__doc__)
    parser.add_argument("--quick", action="store_true", help="smaller and fewer: a check that it all runs")
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the figures to a file as well")
    arguments = parser.parse_args()
    quick = arguments.quick

    from benchmarks.conic import against_conic_solver
    from benchmarks.estimators import from_the_moments, geo_against_conic_solver, lmi_against_conic_solver
    from benchmarks.least_squares import against_pinocchio
    from benchmarks.long_recording import long_recording
    from benchmarks.memory import folding_memory
    from benchmarks.points import many_points
    from benchmarks.posterior import posterior
    from benchmarks.report import show
    from benchmarks.streaming import one_sample_at_a_time

    sections = [
        against_conic_solver(150, rounds=3 if quick else 20),
        against_conic_solver(300 if quick else 3500, rounds=1 if quick else 5),
        one_sample_at_a_time(300 if quick else 3000),
        *geo_against_conic_solver(1000, rounds=1 if quick else 10),
        *lmi_against_conic_solver(1000, rounds=1 if quick else 10),
        *from_the_moments(1000, 2_000 if quick else 100_000, rounds=5 if quick else 50),
        posterior(2_000 if quick else 10_000, rounds=5 if quick else 50),
        many_points(2_000 if quick else 100_000, rounds=2 if quick else 7),
        against_pinocchio(1000, rounds=5 if quick else 50),
        folding_memory(200_000 if quick else 10_000_000),
        long_recording(50_000 if quick else 1_000_000),
    ]
    show(sections)
    if arguments.json is not None:
        report = {
            "quick": quick,
            "sections": [{"title": s.title, "rows": [r.to_dict() for r in s.rows]} for s in sections],
        }
        arguments.json.write_text(json.dumps(report, indent=1) + "\n")


if __name__ == "__main__":
    main()

"""`python -m benchmarks.calibration [--objects N] [--runs N] [--cases ...]`: how often Bayes' intervals hold the truth.

Random bodies of six kinds (`benchmarks.bodies`), each wielded several times: three kinds of motion, 150 to 1,000
samples, three noise levels. Shares of 95 % and 50 % intervals of mass, COM and inertia about the sensor that hold the
truth, and the median error over PMD's. Some minutes for 36 objects of each kind.
"""

import argparse
import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

NOISE = ("given", "estimated", "AR 0.9", "AR 0.97")
SHAPES = ("box", "hull", "larger", "smaller", "misplaced", "noisy scan", "one side")
CASES = (*NOISE, *SHAPES)
"""What is known of the noise, or how it is coloured; or what is taken for the shape (`benchmarks.wrong_shapes`)."""


def main() -> None:
    """Print one table for each case."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description=main.__doc__)
    parser.add_argument("--objects", type=int, default=36, help="of each kind")
    parser.add_argument("--runs", type=int, default=10, help="identifications of each object")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=NOISE)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()

    import numpy as np

    from benchmarks.bodies import FILLINGS, random_body
    from benchmarks.calibration_runs import Run, identified

    bodies = [random_body(kind, arguments.seed * 1000 + i) for kind in FILLINGS for i in range(arguments.objects)]
    for case in arguments.cases:
        runs: list[Run] = []
        for i, body in enumerate(bodies):
            runs += [identified(body, case, (arguments.seed, i, run)) for run in range(arguments.runs)]
        kind = "shape" if case in SHAPES else "noise"
        print(f"\n{kind} {case}: {len(runs)} identifications of {len(bodies)} objects")
        print(f"{'':15}{'95 % holds':>11}{'50 %':>7}   {'mass COM J (95 %)':22}{'over PMD: mass COM J':24}widths [%]")

        def line(name: str, chosen: list[Run]) -> None:
            held = np.array([run.held95 for run in chosen])
            half = np.array([run.held50 for run in chosen]).mean()
            groups = [held[:, part].mean() for part in (slice(1), slice(1, 4), slice(4, 10))]
            ours, theirs = (np.median([getattr(run, n) for run in chosen], axis=0) for n in ("errors", "pmd"))
            width = np.median([run.widths for run in chosen], axis=0)
            print(f"{name:15}{100 * held.mean():11.1f}{100 * half:7.1f}   "
                  f"{' '.join(f'{100 * g:.1f}' for g in groups):22}"
                  f"{' '.join(f'{r:.2f}' for r in ours / theirs):24}"
                  f"{' '.join(f'{w:.2g}' for w in width)}", flush=True)  # fmt: skip

        line("all", runs)
        line("less even ones", [run for run in runs if run.body.kind != "homogeneous"])
        for kind in FILLINGS:
            line(kind, [run for run in runs if run.body.kind == kind])


if __name__ == "__main__":
    main()

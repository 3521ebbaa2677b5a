"""`python -m benchmarks.calibration [--objects N] [--runs N] [--cases ...]`: how often
Bayes' intervals hold the truth.

`--streamed`: samples come a few at a time, white or coloured, and the state alone must
know its noise; it is looked at on the way and at the end.

Random bodies of twelve kinds (`benchmarks.bodies`), 600 by default, each wielded for
150 and for 1,000 samples: three kinds of motion, three noise levels. Shares of 95 % and
50 % intervals of mass, COM and inertia about the sensor that hold the truth, and the
median error over PMD's, or LMI's where the shape is unknown; by contrast of the density
and by kind. A minute for a case.

`--methods`: every other method, and HPS on bodies of labelled parts
(`benchmarks.method_calibration`): `--methods --objects 21 --runs 6` are 1,008 recordings
for each kind of noise.
"""

import argparse
import os
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchmarks.calibration_runs import Run

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

NOISE = ("given", "estimated", "AR 0.9", "AR 0.97")
SHAPES = ("box", "hull", "larger", "smaller", "misplaced", "noisy scan", "one side")
UNSAID = ("misplaced, unsaid", "sensor box", "generous box", "open mesh", "unknown")
STREAMS = ("white", "AR 0.9", "AR 0.97")
"""Wrench noise of streams."""
CASES = (*NOISE, *SHAPES, *UNSAID)
"""What is known of the noise, or how it is coloured; or what is taken for the shape,
its deviation stated or unsaid (`benchmarks.wrong_shapes`)."""
CONTRASTS = (0.0, 0.5, 1.0, 1.5)
"""Ends of bins of contrast: a density's standard deviation over its mean."""


def main() -> None:
    """Print one table for each case."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.calibration", description=main.__doc__
    )
    parser.add_argument("--objects", type=int, default=50, help="of each kind")
    parser.add_argument(
        "--runs",
        type=int,
        default=1,
        help="of each object for each number of samples",
    )
    parser.add_argument("--cases", nargs="+", choices=CASES, default=("given",))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--streamed",
        action="store_true",
        help="streams: --runs of each object and noise",
    )
    parser.add_argument(
        "--methods",
        action="store_true",
        help="every method but Bayes: --runs recordings of each object",
    )
    parser.add_argument(
        "--only", nargs="+", default=(), metavar="NAME", help="with --methods: these"
    )
    arguments = parser.parse_args()
    if arguments.methods:
        from benchmarks.method_calibration import table

        chosen = tuple(arguments.only)
        table(arguments.objects, arguments.runs, arguments.seed, chosen)
        return

    from benchmarks.bodies import KINDS, random_body
    from benchmarks.calibration_runs import SPANS, identified

    bodies = [
        random_body(kind, arguments.seed * 1000 + i)
        for kind in KINDS
        for i in range(arguments.objects)
    ]
    if arguments.streamed:
        streams(bodies, arguments.runs, arguments.seed)
        return
    for case in arguments.cases:
        runs = [
            identified(body, case, count, (arguments.seed, i, run, count))
            for i, body in enumerate(bodies)
            for run in range(arguments.runs)
            for count in SPANS
        ]
        kind = "noise" if case in NOISE else "shape"
        print(f"\n{kind} {case}: {len(runs)} identifications of {len(bodies)} objects")
        show(runs)


def show(runs: "list[Run]") -> None:
    """Print the table of a case."""
    from benchmarks.bodies import KINDS
    from benchmarks.calibration_runs import SPANS

    over = "over LMI" if runs[0].unknown else "over PMD"
    print(
        f"{'':22}{'runs':>6}{'95 % holds':>11}{'50 %':>7}   {'mass COM J (95 %)':20}"
        f"{over + ': mass COM J':24}{'widths [%]':14}{'beyond':>7}{'outside':>8}"
    )
    line("all", runs)
    for count in SPANS:
        part = [run for run in runs if run.samples == count]
        line(f"{count} samples", part)
        for low, high in pairwise((-1.0, *CONTRASTS, 1e9)):
            name = f"above {low:g}" if high > 1e3 else f"to {high:g}"
            inside = [run for run in part if low < run.body.contrast <= high + 1e-9]
            line(f"  contrast {name}", inside)
    for kind in KINDS:
        line(kind, [run for run in runs if run.body.kind == kind])


def line(name: str, chosen: "list[Run]") -> None:
    """Print one row of it."""
    import numpy as np

    if not chosen:
        return
    held = np.array([run.held95 for run in chosen])
    half = np.array([run.held50 for run in chosen]).mean()
    groups = [held[:, part].mean() for part in (slice(1), slice(1, 4), slice(4, 10))]
    ours, theirs = (
        np.median([getattr(run, n) for run in chosen], axis=0)
        for n in ("errors", "beside")
    )
    width = np.median([run.widths for run in chosen], axis=0)
    beyond, outside = (
        sum(getattr(run, n) for run in chosen) for n in ("beyond", "outside")
    )
    shares = " ".join(f"{100 * g:.1f}" for g in groups)
    ratios = " ".join(f"{r:.2f}" for r in ours / theirs)
    widths = " ".join(f"{w:.2g}" for w in width)
    print(
        f"{name:22}{len(chosen):6}{100 * held.mean():11.1f}{100 * half:7.1f}   "
        f"{shares:20}{ratios:24}{widths:14}{beyond:7}{outside:8}",
        flush=True,
    )


def streams(bodies: list, runs: int, seed: int) -> None:
    """Print, for each noise and number of samples, the shares of 95 % intervals that
    hold."""
    import numpy as np

    from benchmarks.calibration_runs import LOOKS, SAMPLES, Run, streamed

    print(
        f"{'noise':10}{'samples':>8}{'looks':>7}{'95 % holds':>12}   mass COM J (95 %)      widths [%]"
    )
    for case in STREAMS:
        found: dict[str, list[Run]] = {}
        for i, body in enumerate(bodies):
            for run in range(runs):
                for samples, judged in streamed(body, case, (seed, i, run)).items():
                    found.setdefault(
                        "the end" if samples in SAMPLES else str(samples), []
                    ).append(judged)
        for name in (*map(str, LOOKS), "the end"):
            held = np.array([run.held95 for run in found.get(name, [])])
            if not len(held):
                continue
            groups = [
                100.0 * held[:, part].mean()
                for part in (slice(1), slice(1, 4), slice(4, 10))
            ]
            width = np.median([run.widths for run in found[name]], axis=0)
            shares, widths = (
                " ".join(f"{x:{how}}" for x in values)
                for values, how in ((groups, ".1f"), (width, ".2g"))
            )
            print(
                f"{case:10}{name:>8}{len(held):7}{100.0 * held.mean():12.1f}   {shares:22} {widths}",
                flush=True,
            )


if __name__ == "__main__":
    main()

"""`python -m benchmarks.calibration [--objects N] [--runs N] [--cases ...]`: how often
Bayes' intervals hold the truth.

`--streamed`: samples come a few at a time, white or coloured, and the state alone must
know its noise; it is looked at on the way and at the end.

`--methods`: every other method, and HPS on bodies of labelled parts
(`benchmarks.method_calibration`): `--methods --objects 21 --runs 6` are 1,008 recordings
for each kind of noise.

Random bodies of six kinds (`benchmarks.bodies`), each wielded several times: three
kinds of motion, 150 to 1,000 samples, three noise levels. Shares of 95 % and 50 %
intervals of mass, COM and inertia about the sensor that hold the truth, and the median
error over PMD's. Some minutes for 36 objects of each kind.
"""

import argparse
import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

NOISE = ("given", "estimated", "AR 0.9", "AR 0.97")
SHAPES = ("box", "hull", "larger", "smaller", "misplaced", "noisy scan", "one side")
STREAMS = ("white", "AR 0.9", "AR 0.97")
"""Wrench noise of streams."""
CASES = (*NOISE, *SHAPES)
"""What is known of the noise, or how it is coloured; or what is taken for the shape
(`benchmarks.wrong_shapes`)."""


def main() -> None:
    """Print one table for each case."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.calibration", description=main.__doc__
    )
    parser.add_argument("--objects", type=int, default=36, help="of each kind")
    parser.add_argument(
        "--runs", type=int, default=10, help="identifications of each object"
    )
    parser.add_argument("--cases", nargs="+", choices=CASES, default=NOISE)
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

    import numpy as np

    from benchmarks.bodies import FILLINGS, random_body
    from benchmarks.calibration_runs import Run, identified

    bodies = [
        random_body(kind, arguments.seed * 1000 + i)
        for kind in FILLINGS
        for i in range(arguments.objects)
    ]
    if arguments.streamed:
        streams(bodies, arguments.runs, arguments.seed)
        return
    for case in arguments.cases:
        runs: list[Run] = []
        for i, body in enumerate(bodies):
            runs += [
                identified(body, case, (arguments.seed, i, run))
                for run in range(arguments.runs)
            ]
        kind = "shape" if case in SHAPES else "noise"
        print(f"\n{kind} {case}: {len(runs)} identifications of {len(bodies)} objects")
        print(
            f"{'':15}{'95 % holds':>11}{'50 %':>7}   {'mass COM J (95 %)':22}{'over PMD: mass COM J':24}widths [%]"
        )

        def line(name: str, chosen: list[Run]) -> None:
            held = np.array([run.held95 for run in chosen])
            half = np.array([run.held50 for run in chosen]).mean()
            groups = [
                held[:, part].mean() for part in (slice(1), slice(1, 4), slice(4, 10))
            ]
            ours, theirs = (
                np.median([getattr(run, n) for run in chosen], axis=0)
                for n in ("errors", "pmd")
            )
            width = np.median([run.widths for run in chosen], axis=0)
            print(f"{name:15}{100 * held.mean():11.1f}{100 * half:7.1f}   "
                  f"{' '.join(f'{100 * g:.1f}' for g in groups):22}"
                  f"{' '.join(f'{r:.2f}' for r in ours / theirs):24}"
                  f"{' '.join(f'{w:.2g}' for w in width)}", flush=True)  # fmt: skip

        line("all", runs)
        line("less even ones", [run for run in runs if run.body.kind != "homogeneous"])
        for kind in FILLINGS:
            line(kind, [run for run in runs if run.body.kind == kind])


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

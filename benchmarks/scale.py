"""`python -m benchmarks.scale [--objects N] [--sizes ...] [--only-bayes]`: how often
intervals hold where a scale told the mass, of a sensor whose gain is wrong.

Random bodies of twelve kinds, 42 of each by default: 504 recordings for each size of
the sensor's errors, as of `benchmarks.sensor_accuracy`, and of each a scale's reading.
Shares of 95 % intervals of mass, COM and inertia about the sensor that hold the truth,
median widths, by the wrench and by both, and how often the scale was said to contradict
the wrench. Four minutes a size; with the other methods, twelve.
"""

import argparse
import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

SIZES = ("default", "2%")
"""Accuracies of the sensor that are told; in ``default`` the errors are half a percent,
and nothing is said of them."""
PARTS = {"mass": slice(1), "com": slice(1, 4), "inertia": slice(4, 10)}
"""Of the ten numbers that are judged."""


def main() -> None:
    """Print one table for each size."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.scale", description=main.__doc__
    )
    parser.add_argument("--objects", type=int, default=42, help="of each kind")
    parser.add_argument("--sizes", nargs="+", default=SIZES)
    parser.add_argument("--seed", type=int, default=17)
    parser.add_argument("--only-bayes", action="store_true")
    arguments = parser.parse_args()
    for size in arguments.sizes:
        table(size, arguments.objects, arguments.seed, others=not arguments.only_bayes)


def table(
    size: str, objects: int, seed: int, *, others: bool
) -> dict[str, dict[str, float]]:
    """Print the table of one size of the sensor's errors; returns shares [%] by method:
    of all intervals, of mass, COM and inertia, and of contradictions."""
    from benchmarks.bodies import KINDS, random_body
    from benchmarks.scale_runs import Weighed, weighed
    from hefting.core.sensor_accuracy import SensorAccuracy

    accuracy = None if size == "default" else SensorAccuracy.parse(size)
    found: dict[str, list[Weighed]] = {}
    number = 0
    for kind in KINDS:
        for i in range(objects):
            number += 1
            body = random_body(kind, 1000 * seed + i)
            for run in weighed(body, accuracy, (seed, number, 47), others):
                found.setdefault(run.both.method, []).append(run)
    print(f"\n{size}: {number} recordings")
    print(
        f"{'':17}{'runs':>5}{'hold':>7}   {'mass COM J':17}{'widths [%]':15}"
        f"{'without the scale':34}contradictions"
    )
    return {name: _row(name, runs) for name, runs in found.items()}


def _row(name: str, runs: list) -> dict[str, float]:
    """Print the row of a method; its shares [%]."""
    import numpy as np

    from benchmarks.method_calibration import share

    texts, shares = [], {}
    for which in ("alone", "both"):
        own = [getattr(run, which) for run in runs]
        shares = {"all": share(own)} | {k: share(own, p) for k, p in PARTS.items()}
        widths = np.median([run.widths for run in own], axis=0)
        groups = " ".join(f"{shares[k]:.1f}" for k in PARTS)
        texts.append(f"{groups:17}{' '.join(f'{width:.2g}' for width in widths):15}")
    shares["contradicted"] = 100.0 * float(np.mean([run.contradicted for run in runs]))
    print(
        f"{name:17}{len(runs):5}{shares['all']:7.1f}   {texts[1]}{texts[0]}  "
        f"{shares['contradicted']:.2g} %",
        flush=True,
    )
    return shares


if __name__ == "__main__":
    main()

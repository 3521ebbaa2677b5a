"""`python -m benchmarks.sensor_accuracy [--objects N] [--sizes ...] [--only-bayes] [--of-parts]`:
how often intervals hold where the sensor has errors of gain, cross-talk and offset.

Random bodies of twelve kinds, 42 of each by default: 504 recordings for each size of
the errors, or as many of bodies of parts, which HPS identifies, too; every method is
told the size but for ``default``. Shares of 95 % intervals of mass, COM and inertia about
the sensor that hold the truth, and median widths. Two minutes a size; with the other
methods, six.
"""

import argparse
import itertools
import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

SIZES = ("default", "0.5% 0.3N 0.01Nm", "2%", "2% 1N 0.05Nm")
"""Accuracies that are told; in ``default`` the errors are half a percent, and nothing is
said of them."""


def main() -> None:
    """Print one table for each size."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.sensor_accuracy", description=main.__doc__
    )
    parser.add_argument("--objects", type=int, default=42, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sizes", nargs="+", default=SIZES)
    parser.add_argument("--only-bayes", action="store_true")
    parser.add_argument("--of-parts", action="store_true", help="bodies that HPS takes")
    given = parser.parse_args()
    kinds = {"of_parts": given.of_parts, "others": not given.only_bayes}
    for size in given.sizes:
        table(size, given.objects, given.seed, **kinds)


def table(
    size: str, objects: int, seed: int, *, others: bool, of_parts: bool = False
) -> dict[str, dict[str, float]]:
    """Print and return the shares that hold [%], by method: pooled, of mass, COM and
    inertia."""
    import numpy as np

    from benchmarks.bodies import KINDS, random_body
    from benchmarks.method_calibration import share
    from benchmarks.method_runs import MethodRun, body_of_parts
    from benchmarks.sensor_accuracy_runs import identified
    from hefting.core.sensor_accuracy import SensorAccuracy

    accuracy = None if size == "default" else SensorAccuracy.parse(size)
    found: dict[str, list[MethodRun]] = {}
    number = 0
    for kind, i in itertools.product(KINDS, range(objects)):
        number += 1
        body = (
            body_of_parts(1000 * seed + number)
            if of_parts
            else random_body(kind, 1000 * seed + i)
        )
        for run in identified(body, accuracy, (seed, number, 31), others):
            found.setdefault(run.method, []).append(run)
    print(f"\n{size}: {number} recordings")
    print(f"{'':17}{'runs':>6}{'95 % holds':>12}   {'mass COM J':18}widths [%]")
    shares: dict[str, dict[str, float]] = {}
    for name, runs in found.items():
        parts = {"mass": slice(1), "com": slice(1, 4), "inertia": slice(4, 10)}
        own = {"all": share(runs)} | {k: share(runs, part) for k, part in parts.items()}
        widths = np.median([run.widths for run in runs], axis=0)
        groups = " ".join(f"{own[k]:.1f}" for k in parts)
        print(
            f"{name:17}{len(runs):6}{own['all']:12.1f}   {groups:18}"
            f"{' '.join(f'{width:.2g}' for width in widths)}",
            flush=True,
        )
        shares[name] = own
    return shares


if __name__ == "__main__":
    main()

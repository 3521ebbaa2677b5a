"""`python -m benchmarks.planning [--objects N] [--random M] [--arms A,B] [--limits N]`:
planned motions against random ones and the paper's.

Each is played in MuJoCo with noise, a bias and pose noise, and identified by
`hefting.identify`. Random motions are Fourier series that fill the same limits.
`--limits N` checks so many plans with random limits in MuJoCo instead
(`benchmarks.planning_limits`). All of it with 20 objects and 60 random motions takes
half an hour; needs MuJoCo.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from hefting.core.spatial import Array  # noqa: E402

ARMS = ("ur5e", "panda", "xarm7")
PARTS = ("plain", "shape", "next")
SEEDS = 4
"""Plans of each arm without a shape; objects take turns."""


def main() -> None:
    """Run the parts that are asked for and print tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.planning", description=main.__doc__
    )
    parser.add_argument("--objects", type=int, default=20, metavar="N")
    parser.add_argument("--random", type=int, default=60, metavar="M")
    parser.add_argument("--arms", default=",".join(ARMS))
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--limits", type=int, metavar="N")
    arguments = parser.parse_args()
    arms = arguments.arms.split(",")
    with tempfile.TemporaryDirectory() as folder:
        if arguments.limits is not None:
            from benchmarks.planning_limits import show_limits

            show_limits(Path(folder), arms, arguments.limits)
            return
        for part in arguments.parts.split(","):
            SHOW[part](Path(folder), arms, arguments.objects, arguments.random)


def show_plain(folder: Path, arms: Sequence[str], objects: int, number: int) -> None:
    """Without a shape: plans of 10 and 4 s against random motions."""
    from benchmarks.planning_runs import Bench, bodies

    every: dict[str, list[Array]] = {}
    times = []
    for name in arms:
        bench, things = Bench(name, folder), bodies(objects)
        motions = {}
        for T in (10.0, 4.0):
            count = number if T > 5.0 else -(-number // 6)
            motions[f"random {T:g} s"] = list(bench.random(T, count))
            plans = [bench.plan(duration=T, seed=s) for s in range(SEEDS)]
            times += [(T, took) for _, took in plans]
            motions[f"planned {T:g} s"] = [own.trajectory for own, _ in plans]
            motions[f"wrist {T:g} s"] = [bench.wrist(T)]
        same = bench.plan(duration=4.0, seed=0)[0].trajectory.points
        tell(
            f"{name}: same seed, same plan: {(same == plans[0][0].trajectory.points).all()}"
        )
        found: dict[str, list[Array]] = {kind: [] for kind in motions}
        for i, body in enumerate(things):
            for kind, own in motions.items():
                chosen = own if "random" in kind else [own[i % len(own)]]
                each = [
                    bench.play(motion, body, 100 * i + k).errors
                    for k, motion in enumerate(chosen)
                ]
                found[kind].append(np.median(each, axis=0))
            tell(f"{name}: {i + 1} of {objects}")
        _show(f"{name}, without a shape", found)
        for kind, own in found.items():
            every.setdefault(kind, []).extend(own)
    _show("all arms, without a shape", every)
    for T in (10.0, 4.0):
        took = [own for t, own in times if t == T]
        print(
            f"a plan of {T:g} s took {np.median(took):.1f} s, at most {max(took):.1f} s"
        )


def show_shape(folder: Path, arms: Sequence[str], objects: int, number: int) -> None:
    """With a shape: plans of 10 s for it against random motions."""
    from benchmarks.planning_runs import Bench, bodies

    every: dict[str, list[Array]] = {}
    for name in arms:
        bench = Bench(name, folder)
        found: dict[str, list[Array]] = {"random 10 s": [], "planned 10 s": []}
        for i, body in enumerate(bodies(objects)):
            own, _ = bench.plan(shape=body.shape, seed=i)
            planned = [
                bench.play(own.trajectory, body, 100 * i + k, body.shape).errors
                for k in range(3)
            ]
            found["planned 10 s"].append(np.median(planned, axis=0))
            each = [
                bench.play(motion, body, 100 * i + k, body.shape).errors
                for k, motion in enumerate(bench.random(10.0, number, body.shape, i))
            ]
            found["random 10 s"].append(np.median(each, axis=0))
            tell(f"{name} with shapes: {i + 1} of {objects}")
        _show(f"{name}, with the shape", found)
        for kind, own in found.items():
            every.setdefault(kind, []).extend(own)
    _show("all arms, with the shape", every)


def show_next(folder: Path, arms: Sequence[str], objects: int, number: int) -> None:
    """A second motion of 10 s, planned from what a first random one of 10 s left, against
    second random ones."""
    from benchmarks.planning_runs import Bench, bodies, errors, width_ratios
    from hefting import identify

    seconds = min(number, 8)
    gains, ratios, times = [], [], []
    for name in arms:
        bench = Bench(name, folder)
        firsts = list(bench.random(10.0, objects, seed=1))
        others = list(bench.random(10.0, seconds, seed=2))
        for i, body in enumerate(bodies(objects)):
            first = bench.play(firsts[i], body, i)
            own, took = bench.plan(estimate=first.estimate, seed=i)
            times.append(took)
            pair = [first.recording, bench.recording(own.trajectory, body, 1000 + i)]
            found = identify(pair).estimate
            each = []
            for k, motion in enumerate(others):
                pair = [first.recording, bench.recording(motion, body, 2000 + k)]
                each.append(errors(identify(pair).estimate, body))
            gains.append(np.median(each, axis=0) / errors(found, body))
            ratios.append(width_ratios(own, found))
            tell(f"{name} next: {i + 1} of {objects}")
    gain = np.median(gains, axis=0)
    print(
        "\nSecond motion: error with a random one over that with the planned one, median: "
        f"mass {gain[0]:.2f}, COM {gain[1]:.2f}, inertia {gain[2]:.2f}"
    )
    middle = [
        np.median(np.array(ratios)[:, own]) for own in ([0], [1, 2, 3], range(4, 10))
    ]
    print(
        "Half-widths found over those promised, median: mass {:.2f}, COM {:.2f}, inertia "
        "{:.2f}; all {:.2f}".format(*middle, np.median(ratios))
    )
    print(f"a next plan took {np.median(times):.1f} s, at most {max(times):.1f} s")


SHOW = {"plain": show_plain, "shape": show_shape, "next": show_next}


def _show(title: str, found: dict[str, list[Array]]) -> None:
    """Median errors, and over those of random motions of 10 s."""
    print(f"\n{title}: median errors over {len(found['random 10 s'])} objects")
    print(
        f"{'':14}{'mass %':>9}{'COM mm':>9}{'inertia %':>11}   over random 10 s; worst"
    )
    base = np.array(found["random 10 s"])
    for kind, own in found.items():
        middle = np.median(own, axis=0)
        ratio = np.array(own) / base
        shares = " ".join(f"{r:.2f}" for r in np.median(ratio, axis=0))
        worst = " ".join(f"{r:.2f}" for r in ratio.max(axis=0))
        print(
            f"{kind:14}{middle[0]:9.3f}{middle[1]:9.3f}{middle[2]:11.2f}   {shares}; {worst}"
        )
    sys.stdout.flush()


def tell(line: str) -> None:
    """A line on standard error."""
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()

"""`python -m benchmarks.two_mistakes [--seeds N]`: what is said of two mistakes that are
made at once.

Each pair of 30 common mistakes, in N simulated recordings, without a shape: whether both
are named, or one, which is then mended first, and whether an answer that is called good
is wrong. Three to eleven minutes for one seed on two cores.
"""

import argparse
import itertools
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from benchmarks.given import Given, Mistake, correct  # noqa: E402
from benchmarks.mistake_runs import Said, identified  # noqa: E402
from benchmarks.mistaken import mistakes  # noqa: E402

COMMON = (
    ("put down", ""),
    ("cable", "20 N/m"),
    ("in contact", "15%"),
    ("low-passed", "2 Hz"),
    ("compensated wrench", "100% of the payload"),
    ("wrench in base axes", ""),
    ("torque about the TCP", "50 mm"),
    ("turned about z", "30°"),
    ("turned about z", "90°"),
    ("turned about x", "180°"),
    ("gain of one axis", "10%"),
    ("axis flipped", "fx"),
    ("axis flipped", "fz"),
    ("columns swapped", "x and y"),
    ("dead channel", "fy"),
    ("bias none", "5 N"),
    ("unit of force", "kgf"),
    ("unit of torque", "N mm"),
    ("flange behind sensor", "50 mm"),
    ("base tilted", "15°"),
    ("gravity", "upwards"),
    ("axes of position", "y up"),
    ("frozen poses", "0.5 s"),
    ("rows lost", "5%"),
    ("late clock", "100 ms"),
    ("time", "twice as fast"),
    ("inverse pose", "whole"),
    ("quaternion order", "w first"),
    ("form of angles", "roll, pitch, yaw"),
    ("unit of position", "mm"),
)
"""Names and strengths of the mistakes that are made in pairs, in the order in which they
happen: to the object and in the sensor, to the wrench's numbers, to the poses."""


@dataclass(frozen=True)
class Both:
    """What was said of two mistakes at once."""

    said: Said
    named: int
    """how many of the two"""


def main() -> None:
    """Print what the pairs come to."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.two_mistakes")
    parser.add_argument("--seeds", type=int, default=1, help="recordings of each pair")
    parser.add_argument("--only", default="", help="pairs in whose name this stands")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    found = run(arguments.seeds, arguments.only, arguments.jobs)
    print("\n".join(totals(found)))
    print("\n".join(table(found)))


def run(seeds: int, only: str = "", jobs: int = 1) -> list[Both]:
    """What is said of every pair, each of other recordings."""
    from concurrent.futures import ProcessPoolExecutor

    pairs = list(itertools.combinations(range(len(COMMON)), 2))
    work = [
        (first, second, number + seed)
        for number, (first, second) in enumerate(pairs)
        if only in _name(first, second)
        for seed in range(seeds)
    ]
    if jobs == 1:
        return [_said(task) for task in work]
    with ProcessPoolExecutor(jobs) as pool:
        return list(pool.map(_said, work, chunksize=4))


def _name(first: int, second: int) -> str:
    return " + ".join(", ".join(filter(None, COMMON[i])) for i in (first, second))


def _said(task: tuple[int, int, int]) -> Both:
    """Of two mistakes, by their places in the list, and a recording's number."""
    first, second, number = task
    seed = number % 30  # the answers without a mistake are found once
    catalogue = {(each.name, each.strength): each for each in mistakes()}
    one, other = catalogue[COMMON[first]], catalogue[COMMON[second]]

    def make(given: Given, rng: np.random.Generator) -> Given:
        return other.make(one.make(given, rng), rng)

    codes = one.codes | other.codes
    pair = Mistake(_name(first, second), "", make, codes)
    given = make(correct(seed), np.random.default_rng([17, seed]))
    said = identified(given, pair, seed, with_shape=False, tellable=True)
    return Both(said, sum(bool(said.codes & each.codes) for each in (one, other)))


def totals(found: Sequence[Both]) -> Iterable[str]:
    """What all come to."""
    count = Counter(each.named for each in found)
    all_ = len(found)
    yield f"{all_} identifications of two mistakes at once"
    for named, what in ((2, "both"), (1, "one"), (0, "neither")):
        yield f"{what} named: {100.0 * count[named] / max(all_, 1):.1f} %"
    bad = [each for each in found if each.said.is_wrong]
    for level in ("good", "usable with care"):
        wrong = sum(each.said.verdict == level for each in bad)
        yield f"wrong, and {level}: {wrong}"


def table(found: Sequence[Both]) -> Iterable[str]:
    """Those of which none was named, though they are not good, and wrong answers that
    may be used."""
    yield "| pair | recording | named | verdict | wrong | said |"
    yield "|---|---|---|---|---|---|"
    for each in found:
        said = each.said
        usable = said.is_wrong and said.verdict != "do not use"
        if usable or (not each.named and said.verdict != "good"):
            wrong = "yes" if said.is_wrong else "no"
            codes = ", ".join(said.reasons) or "refused"
            yield (
                f"| {said.mistake} | {said.seed} | {each.named} | {said.verdict} | "
                f"{wrong} | {codes} |"
            )


if __name__ == "__main__":
    main()

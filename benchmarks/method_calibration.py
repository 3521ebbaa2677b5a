"""How often the intervals of every method but Bayes hold the truth: the tables of
`python -m benchmarks.calibration --methods`."""

from collections.abc import Iterable

import numpy as np

from benchmarks.bodies import FILLINGS, Body, random_body
from benchmarks.method_runs import MethodRun, body_of_parts, identified_by_all

CASES = ("white", "AR 0.9", "given")
"""Wrench noise: white or first-order, and not known; or white and known."""
BODIES_OF_PARTS = 2
"""Bodies of parts for each body of the other kinds: HPS takes no others."""


def bodies_for(objects: int, seed: int, parts_only: bool = False) -> list[Body]:
    """`objects` of each kind, unless only those of parts are wanted, and
    `BODIES_OF_PARTS` times as many of parts."""
    first, kinds = 1000 * seed, () if parts_only else FILLINGS
    bodies = [random_body(kind, first + i) for kind in kinds for i in range(objects)]
    return bodies + [body_of_parts(first + i) for i in range(BODIES_OF_PARTS * objects)]


def runs_of(
    bodies: list[Body],
    case: str,
    runs: int,
    seed: int,
    chosen: tuple[str, ...] = (),
) -> dict[str, list[MethodRun]]:
    """Each body identified `runs` times: what came of it, by method; of all methods, or
    those `chosen`."""
    found: dict[str, list[MethodRun]] = {}
    for i, body in enumerate(bodies):
        for run in range(runs):
            for each in identified_by_all(body, case, (seed, i, run), chosen):
                found.setdefault(each.method, []).append(each)
    return found


def share(runs: Iterable[MethodRun], part: slice = slice(None)) -> float:
    """Share [%] of the intervals of `part` of the ten numbers that hold."""
    return 100.0 * float(np.mean([run.held[part] for run in runs]))


def table(objects: int, runs: int, seed: int, chosen: tuple[str, ...] = ()) -> None:
    """Print one table for each kind of noise; of all methods, or those `chosen`."""
    bodies = bodies_for(objects, seed, chosen == ("HPS",))
    for case in CASES:
        found = runs_of(bodies, case, runs, seed, chosen)
        print(
            f"\nnoise {case}: {len(bodies) * runs} recordings of {len(bodies)} objects"
        )
        print(
            f"{'':15}{'runs':>6}{'95 % holds':>12}   {'mass COM J':18}"
            f"{'with, without bias':20}{'lowest kind':20}widths [%]"
        )
        for name, each in found.items():
            parts = (slice(1), slice(1, 4), slice(4, 10))
            groups = " ".join(f"{share(each, part):.1f}" for part in parts)
            by_bias = " ".join(
                f"{share(run for run in each if run.free_bias is free):.1f}"
                for free in (True, False)
            )
            kinds = {
                kind: share(run for run in each if run.kind == kind)
                for kind in dict.fromkeys(run.kind for run in each)
            }
            lowest = min(kinds, key=lambda kind: kinds[kind])
            widths = np.median([run.widths for run in each], axis=0)
            print(
                f"{name:15}{len(each):6}{share(each):12.1f}   {groups:18}{by_bias:20}"
                f"{f'{lowest} {kinds[lowest]:.1f}':20}"
                f"{' '.join(f'{width:.2g}' for width in widths)}",
                flush=True,
            )

"""What an identification costs by samples, points of the shape, and recordings."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np

from benchmarks.against.ours import METHODS, told
from benchmarks.against.party import Answer, Party, Task
from benchmarks.against.recordings import given, motion
from benchmarks.against.runs import attempted, rounded
from benchmarks.timing import timed
from hefting.core.measurements import Measurements
from hefting.shapes import Shape
from hefting.simulation import hammer, wield

SAMPLES = (100, 300, 1000, 3000, 10_000, 30_000, 100_000)
POINTS = (14, 56, 200, 600, 2000)
RECORDINGS = (1, 3, 10, 30)
QUICK_SAMPLES, QUICK_POINTS, QUICK_RECORDINGS = (20, 60), (14, 28), (1, 2)
EACH = 150
"""Samples of a recording."""
BY_POINTS = (
    "Hefting Bayes",
    "Hefting PMD, without intervals",
    "CVXPY + Clarabel PMD",
    "CVXPY + Clarabel PMD, reduced",
)
"""Parties whose problem has the points in it."""
LONGEST = ("mujoco.sysid, mass and COM", "mujoco.sysid, ten parameters")
"""The parties that take longest, left out where it must be quick."""
FOLLOWED = (
    *BY_POINTS,
    "Hefting OLS, without intervals",
    "Pinocchio + lstsq",
    *LONGEST,
)
"""Parties whose cost is followed."""
REPETITIONS = 5
SHORT = 0.3
"""[s] above which fewer repetitions do."""

Curve = dict[str, list]
"""``"at"``: sizes; ``"seconds"``: medians."""


def hammer_task(samples: int, points: int = 56) -> Task:
    """The hammer of all benchmarks, on as many samples."""
    exact = wield(motion(samples), hammer().parameters)[:samples]
    return given(exact, Shape.from_mesh(hammer().mesh(), points=points), 1)


def by_samples(
    parties: Sequence[Party], sizes: Sequence[int], repetitions: int = REPETITIONS
) -> dict[str, Curve]:
    """Of one recording that gets longer."""
    return followed(parties, sizes, hammer_task, repetitions)


def by_points(
    parties: Sequence[Party], sizes: Sequence[int], repetitions: int = REPETITIONS
) -> dict[str, Curve]:
    """Of a shape that gets finer, over `EACH` samples. The size is what is asked for;
    the shape has about as many."""
    chosen = [party for party in parties if party.name in BY_POINTS]
    return followed(
        chosen, sizes, lambda points: hammer_task(EACH, points), repetitions
    )


def by_recordings(
    parties: Sequence[Party], sizes: Sequence[int], repetitions: int = REPETITIONS
) -> dict[str, Curve]:
    """Of so many recordings of one object, `EACH` samples each: Hefting merges their
    states, its peers get the samples one after the other."""
    whole = hammer_task(EACH * max(sizes))
    ours = [merging(name) for name in ("Bayes", "PMD", "OLS")]
    chosen = [*ours, *(party for party in parties if party.peer)]

    def task(count: int) -> Task:
        return replace(whole, z=whole.z[: EACH * count])

    return followed(chosen, sizes, task, repetitions)


def merging(name: str) -> Party:
    """A method of Hefting that folds each recording and merges the states."""
    bare = name != "Bayes"

    def pieces(task: Task) -> tuple[Shape, list[Measurements]]:
        z, count = told(task), len(task.z) // EACH
        parts = [z[EACH * i : EACH * (i + 1)] for i in range(count)]
        return replace(task.shape), parts

    def identify(task: Task, ready: tuple[Shape, list[Measurements]]) -> Answer:
        shape, parts = ready
        method = METHODS[name](shape, task.noise, not bare)
        states = (method.update(method.start(), z) for z in parts)
        return Answer(method.estimate(reduce(method.merge, states)).parameters)

    label = f"Hefting {name}" + (", without intervals" if bare else "")
    return Party(label, identify, pieces, method="Hefting")


def followed(
    parties: Iterable[Party],
    sizes: Sequence[int],
    task_of: Callable[[int], Task],
    repetitions: int,
) -> dict[str, Curve]:
    """Medians by size of each party in `FOLLOWED`, until one is beyond its limit."""
    left = [party for party in parties if party.name in FOLLOWED]
    found: dict[str, Curve] = {p.name: {"at": [], "seconds": []} for p in left}
    for size in sizes:
        task, beyond = task_of(size), set()
        for party in left:
            seconds = median(party, task, repetitions)
            found[party.name]["at"].append(size)
            found[party.name]["seconds"].append(rounded([seconds])[0])
            if seconds > party.limit:
                beyond.add(party.name)
        left = [party for party in left if party.name not in beyond]
    return found


def median(party: Party, task: Task, repetitions: int) -> float:
    """Of a few repetitions, after one that is not counted; of long work the first is
    the only one."""

    def once() -> float:
        ready: Any = party.prepare(task)
        return timed(lambda given: attempted(party, task, given), ready)[0]

    first = once()
    if first > party.limit:
        return first
    count = repetitions if first < SHORT else 1
    return float(np.median([once() for _ in range(count)]))


def slope(curve: Curve) -> float:
    """Power of the size with which the last decade's cost grows."""
    at, seconds = np.array(curve["at"], float), np.array(curve["seconds"], float)
    late = at >= 0.1 * at[-1]
    if late.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(at[late]), np.log(seconds[late]), 1)[0])

"""Timing: parties that are compared take turns, so that a busy machine hinders all of
them alike."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from hefting.core.spatial import Array


@dataclass(frozen=True)
class Timing:
    """Times of the repetitions of one piece of work."""

    wall: Array
    """(repetitions,) elapsed time [s]"""
    cpu: Array
    """(repetitions,) processor time of the whole process [s]: other programs hardly
    disturb it"""
    results: tuple[Any, ...]
    """(repetitions,) what the work returned"""

    @property
    def median(self) -> float:
        """Median elapsed time [s]."""
        return float(np.median(self.wall))

    @property
    def median_cpu(self) -> float:
        """Median processor time [s]."""
        return float(np.median(self.cpu))

    @property
    def best(self) -> float:
        """Shortest elapsed time [s]."""
        return float(self.wall.min())


@dataclass(frozen=True)
class Party:
    """A piece of work to time."""

    work: Callable[[Any], Any]
    """What is timed; it is handed what `prepare` returned."""
    prepare: Callable[[], Any] = lambda: None
    """Run before each repetition, not timed."""
    calls: int = 1
    """Repetitions in each round: more for short work."""


def compare(parties: dict[str, Party], rounds: int) -> dict[str, Timing]:
    """Time every party in each of `rounds` rounds, after one round that is not
    counted."""
    records: dict[str, list[tuple[float, float, Any]]] = {name: [] for name in parties}
    for turn in range(rounds + 1):
        for name, party in parties.items():
            for _ in range(party.calls):
                record = timed(party.work, party.prepare())
                if turn > 0:
                    records[name].append(record)
    return {name: collected(rows) for name, rows in records.items()}


def timed(work: Callable[[Any], Any], argument: Any) -> tuple[float, float, Any]:
    """Elapsed time [s], processor time [s] and result of ``work(argument)``."""
    cpu, wall = time.process_time(), time.perf_counter()
    result = work(argument)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return wall, cpu, result


def collected(records: list[tuple[float, float, Any]]) -> Timing:
    """One `Timing` of what `timed` returned."""
    wall, cpu, results = zip(*records, strict=True)
    return Timing(np.array(wall), np.array(cpu), results)

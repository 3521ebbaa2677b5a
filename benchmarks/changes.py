"""`python -m benchmarks.changes [--events N] [--clean N] [--seed S]`: whether changes of
the object within a recording are found, and none where there is none.

Simulated recordings with one event each of five kinds, clean ones, and ones that no body
explains for another reason (`benchmarks.changing`). An event counts as found if a change
is told within half a second of it. Some ten minutes for the defaults.
"""

import argparse
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

if TYPE_CHECKING:
    from benchmarks.changing import Case
    from hefting.ingest.changes.stretches import Changes

NEAR = 0.5
"""[s] Largest distance at which an event counts as found."""


@dataclass(frozen=True)
class Run:
    """What came of one recording."""

    kind: str
    motion: str
    level: str
    told: bool
    """whether a change was told"""
    found: bool
    """whether the event was found"""
    named: bool
    """whether its kind was found, too"""
    error: float
    """[s] from the event to the nearest change; infinite where none was told"""
    held: bool
    """whether the stretches used hold nothing of the event"""


def main() -> None:
    """Print one table each of events, clean recordings and misfits."""
    from benchmarks.changing import CLEAN, EVENTS, LEVELS, MISFITS, MOTIONS

    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.changes", description=main.__doc__
    )
    parser.add_argument("--events", type=int, default=200)
    parser.add_argument("--clean", type=int, default=500)
    parser.add_argument("--misfits", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    a = parser.parse_args()
    began = time.perf_counter()
    events = list(runs(EVENTS, a.events, a.seed))
    print(
        f"{'':14}{'number':>8}{'found':>9}{'kind':>9}{'error':>10}{'part is clean':>15}"
    )
    print(event_row("all", events))
    for name in (*EVENTS, *MOTIONS, *LEVELS):
        chosen = [r for r in events if name in (r.kind, r.motion, r.level)]
        if chosen:
            print(event_row(name, chosen))
    for title, kinds, number in (
        ("clean", CLEAN, a.clean),
        ("misfits", MISFITS, a.misfits),
    ):
        quiet = list(runs(kinds, number, a.seed))
        print(f"\n{title:14}{'number':>8}{'false':>9}")
        print(quiet_row("all", quiet))
        for name in kinds:
            print(quiet_row(name, [r for r in quiet if r.kind == name]))
    print(f"\n{time.perf_counter() - began:.0f} s")


def runs(kinds: tuple[str, ...], number: int, seed: int) -> Iterator[Run]:
    """What came of so many recordings, of each kind in turn."""
    from benchmarks.changing import case
    from hefting.ingest import condition

    for index in range(number):
        recording = case(kinds[index % len(kinds)], 10_000 * seed + index)
        yield run(recording, condition(recording.recording).changes)


def run(case: "Case", changes: "Changes | None") -> Run:
    """What was told of a recording, beside its truth."""
    told = _told(changes)
    error, named, held = float("inf"), False, False
    if case.time is not None and told:
        error = min(abs(at - case.time) for at, _ in told)
        named = any(
            kind == case.kind and abs(at - case.time) < NEAR for at, kind in told
        )
        assert changes is not None
        end = case.time if case.end is None else case.end
        held = all(
            part.end <= case.time + 0.1 or part.start >= end for part in changes.used
        )
    return Run(
        case.kind, case.motion, case.level, bool(told), error < NEAR, named, error, held
    )


def _told(changes: "Changes | None") -> list[tuple[float, str]]:
    """Time [s] and kind of each change that was told."""
    if changes is None:
        return []
    parts = changes.stretches
    told: list[tuple[float, str]] = [
        (0.5 * (one.end + other.start), one.event)
        for one, other in pairwise(parts)
        if one.event not in (None, "touched")
    ]
    return told + [(touch.start, "touched") for touch in changes.touches]


def event_row(name: str, chosen: list[Run]) -> str:
    """Shares of events found, of those with the right kind, the median error, and the
    share of chosen stretches without the event."""
    errors = sorted(r.error for r in chosen)
    found, named, held = (
        100.0 * sum(getattr(r, key) for r in chosen) / len(chosen)
        for key in ("found", "named", "held")
    )
    return (
        f"{name:14}{len(chosen):8}{found:7.1f} %{named:7.1f} %"
        f"{errors[len(errors) // 2]:8.2f} s{held:13.1f} %"
    )


def quiet_row(name: str, chosen: list[Run]) -> str:
    """Number of recordings without an event, and those with a false one."""
    false = sum(r.told for r in chosen)
    return f"{name:14}{len(chosen):8}{false:9}"


if __name__ == "__main__":
    main()

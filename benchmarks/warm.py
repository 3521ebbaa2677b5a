"""`python -m benchmarks.warm [--recordings N] [--repeats N] [--suffix .parquet]`:
processor time of an identification in a process that has made some before.

Recordings of 10 s at 100 Hz (poses and wrench) of the kinds of motion of
`benchmarks.clean`, with a bias and a clock offset, are read from files and identified,
each with its own shape, which is built before. Printed are the median milliseconds of
processor time for each recording and their average, by stage.
"""

import argparse
import os
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

import numpy as np  # noqa: E402

DURATION = 10.0
"""[s]"""
LARGEST_DELAY = 0.01
"""[s] of the wrench's clock, to either side"""
STAGES = {
    "reading": ("hefting.ingest.ingest.as_recording",),
    "motion": ("hefting.ingest.condition.path_of",),
    "fit": ("hefting.ingest.condition._fit",),
    "changes": ("hefting.ingest.condition.find_changes",),
    "mistakes": ("hefting.ingest.chosen_part.doubt_of",),
    "conclusion": ("hefting.identification.front.understand",),
    "solving": ("hefting.identification.identify.run",),
    "checks": ("hefting.identify",),
}
"""What is timed as each stage, less the stages within it."""


@dataclass(frozen=True, eq=False)
class Task:
    """One recording to identify."""

    motion: str
    """key of `benchmarks.clean.MOTIONS`"""
    file: Path
    shape: Any


class Stopwatch:
    """Processor time [s] by stage; that of a stage within another counts once."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)
        self._inner = [0.0]

    def timed(self, stage: str, work: Callable[..., Any]) -> Callable[..., Any]:
        """The same work, timed."""

        def timed_work(*args: Any, **options: Any) -> Any:
            self._inner.append(0.0)
            began = time.process_time()
            try:
                return work(*args, **options)
            finally:
                took = time.process_time() - began
                self.spent[stage] += took - self._inner.pop()
                self._inner[-1] += took

        return timed_work


def tasks(folder: Path, count: int, suffix: str) -> list[Task]:
    """The first recordings, written to files."""
    import hefting
    from benchmarks.clean import simulated

    made = []
    for number in range(count):
        delay = LARGEST_DELAY * np.sin(1.0 + number)
        recording, body, motion, *_ = simulated(number, DURATION, float(delay))
        file = folder / f"{number:03d}{suffix}"
        hefting.write_log(recording, file)
        made.append(Task(motion, file, body.shape))
    return made


@contextmanager
def staged(watch: Stopwatch) -> Iterator[None]:
    """Time the stages of all identifications within."""
    from pkgutil import resolve_name

    with ExitStack() as stack:
        for stage, names in STAGES.items():
            for name in names:
                work = resolve_name(name)
                stack.enter_context(patch(name, watch.timed(stage, work)))
        yield


def stages_of(task: Task) -> dict[str, float]:
    """Processor time [s] of one identification, by stage."""
    import hefting

    watch = Stopwatch()
    with staged(watch):
        hefting.identify(task.file, task.shape)
    return dict(watch.spent)


def measured(given: list[Task], repeats: int) -> list[dict[str, float]]:
    """Median processor time [ms] of each task by stage, after one turn that is not
    counted: with a shape that was used before, as one of many recordings."""
    found = []
    for task in given:
        turns = [stages_of(task) for _ in range(repeats + 1)][1:]
        found.append(
            {
                stage: 1e3 * float(np.median([turn.get(stage, 0.0) for turn in turns]))
                for stage in STAGES
            }
        )
    return found


def show(given: list[Task], found: list[dict[str, float]]) -> None:
    """Print one line for each recording, and the average."""
    print(f"{'motion':16s}" + "".join(f"{name:>11s}" for name in (*STAGES, "all")))
    for task, times in zip(given, found, strict=True):
        print(_line(task.motion, times))
    average = {s: float(np.mean([times[s] for times in found])) for s in STAGES}
    print(_line("average [ms]", average))


def _line(name: str, times: dict[str, float]) -> str:
    columns = (*times.values(), sum(times.values()))
    return f"{name:16s}" + "".join(f"{column:11.1f}" for column in columns)


def main() -> None:
    """Print the times."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.warm")
    parser.add_argument("--recordings", type=int, default=24)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--suffix", default=".csv", help="of the files: .csv, .parquet")
    arguments = parser.parse_args()
    with TemporaryDirectory() as folder:
        given = tasks(Path(folder), arguments.recordings, arguments.suffix)
        show(given, measured(given, arguments.repeats))


if __name__ == "__main__":
    main()

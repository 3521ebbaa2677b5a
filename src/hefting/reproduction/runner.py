"""Running experiments: each result kept, so that a stopped run goes on.

A result is a file named after its job and the version of this library's source: a job
is done again when the source has changed, and never otherwise. Results do not depend on
who does the job, or in which order.
"""

import hashlib
import json
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Self

from hefting.core.errors import HeftingError, InputError
from hefting.core.files import write_atomically
from hefting.jobs import Jobs, Lost, source_version
from hefting.reproduction.experiment import Experiment, Job, Result


class Bars:
    """By name; nothing unless `shown` and standard error is a terminal."""

    def __init__(self, shown: bool):
        self.bars = None
        if shown and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import (
                BarColumn,
                MofNCompleteColumn,
                Progress,
                TextColumn,
                TimeRemainingColumn,
            )

            columns = (
                TextColumn("{task.description}"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
            )
            self.bars = Progress(*columns, console=Console(stderr=True))
        self.tasks: dict[str, int] = {}

    def __enter__(self) -> Self:
        if self.bars:
            self.bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.bars:
            self.bars.stop()

    def __call__(self, name: str, done: int, total: int) -> None:
        """Of `name`, so many jobs of so many are done."""
        if self.bars:
            if name not in self.tasks:
                self.tasks[name] = self.bars.add_task(name, total=total)
            self.bars.update(self.tasks[name], completed=done)  # type: ignore[arg-type]


Progress = Callable[[str, int, int], None]
"""An experiment's name, how many of its jobs are done, and how many there are."""


def run_experiments(
    experiments: Iterable[Experiment],
    folder: Path,
    quick: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda name, done, total: None,
) -> dict[str, list[tuple[Job, Result]]]:
    """All results, each with its job, in the order of `jobs`.

    Those found in ``results`` below `folder` are not computed again. `workers` are
    local processes, by default one a core; `scheduler` is the address of a Dask
    scheduler to use instead (extra ``batch``).

    Raises `InputError` when `folder` cannot be written or the scheduler cannot be
    reached, `HeftingError` when it is lost or its workers have another source, or when
    all else is done but a job by which its worker dies, and whatever a job raises.
    """
    make_folder(folder / "results")
    wanted = {experiment.name: experiment.jobs(quick) for experiment in experiments}
    found = {
        name: [_kept(folder, name, job) for job in jobs]
        for name, jobs in wanted.items()
    }
    missing = [
        (name, i)
        for name, results in found.items()
        for i, result in enumerate(results)
        if result is None
    ]
    for name, results in found.items():
        progress(name, sum(r is not None for r in results), len(results))
    tasks = [(name, wanted[name][i]) for name, i in missing]
    lost: list[str] = []
    with Jobs(workers, scheduler) as jobs:
        # they are long, of different lengths: none waits behind another
        for k, result in jobs.run(do, tasks, window=1):
            name, i = missing[k]
            if isinstance(result, Lost):
                lost.append(f"a job of {name} is lost: {result.reason}")
                continue
            found[name][i] = result
            _keep(folder, name, wanted[name][i], result)
            results = found[name]
            progress(name, sum(r is not None for r in results), len(results))
    if lost:
        raise HeftingError(lost[0])
    return {name: list(zip(wanted[name], found[name], strict=True)) for name in wanted}  # type: ignore[arg-type]


def make_folder(path: Path) -> None:
    """`InputError` when that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made ({error.strerror})", where=path) from error


def do(task: tuple[str, Job]) -> Result:
    """In whichever process."""
    from hefting.reproduction.experiments import EXPERIMENTS

    name, job = task
    # the same as when read back from a file
    return json.loads(json.dumps(EXPERIMENTS[name].run(job)))


def _path(folder: Path, name: str, job: Job) -> Path:
    key = hashlib.sha256(
        json.dumps([source_version(), job], sort_keys=True).encode()
    ).hexdigest()[:24]
    return folder / "results" / name / f"{key}.json"


def _keep(folder: Path, name: str, job: Job, result: Result) -> None:
    path = _path(folder, name, job)
    make_folder(path.parent)
    write_atomically(path, json.dumps({"job": job, "result": result}))


def _kept(folder: Path, name: str, job: Job) -> Result | None:
    path = _path(folder, name, job)
    if not path.exists():
        return None
    try:
        return json.loads(path.read_text())["result"]
    except (OSError, ValueError, KeyError, TypeError):
        return None  # not whole: done again

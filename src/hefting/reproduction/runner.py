"""Running experiments: jobs on local processes or a Dask cluster, each result kept, so
that a stopped run goes on.

A result is a file of its own, named after its job and the version of this library's
source: a job is done again when the source has changed, and never otherwise. Results do
not depend on who does the job, or in which order.
"""

import hashlib
import json
import logging
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache
from multiprocessing import active_children, get_context
from pathlib import Path

import hefting
from hefting.core.errors import HeftingError, InputError, MissingDependencyError
from hefting.core.files import write_atomically
from hefting.reproduction.experiment import Experiment, Job, Result

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
ATTEMPTS = 5
"""How often a job is begun whose worker dies."""

Progress = Callable[[str, int, int], None]
"""Called with an experiment's name, how many of its jobs are done, and how many there
are."""


def run_experiments(
    experiments: Iterable[Experiment],
    folder: Path,
    quick: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda name, done, total: None,
) -> dict[str, list[tuple[Job, Result]]]:
    """All results by experiment, each with its job, in the order of the experiment's
    `jobs`.

    Parameters
    ----------
    folder : where results are kept, below ``results``; those found there are not
        computed again.
    workers : local processes, by default one a core.
    scheduler : address of a Dask scheduler to use instead (extra ``batch``).

    Raises `InputError` when `folder` cannot be written or the scheduler cannot be
    reached, `HeftingError` when it is lost or its workers have another source, and
    whatever a job raises.
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
    done = (
        _on_cluster(tasks, scheduler)
        if scheduler
        else _on_processes(tasks, workers or os.cpu_count() or 1)
    )
    for k, result in done:
        name, i = missing[k]
        found[name][i] = result
        path = _path(folder, name, wanted[name][i])
        make_folder(path.parent)
        write_atomically(path, json.dumps({"job": wanted[name][i], "result": result}))
        progress(name, sum(r is not None for r in found[name]), len(found[name]))
    return {name: list(zip(wanted[name], found[name], strict=True)) for name in wanted}  # type: ignore[arg-type]


def make_folder(path: Path) -> None:
    """Make a folder and those above it; `InputError` when that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made ({error.strerror})", where=path) from error


def do(name: str, job: Job, source: str | None = None) -> Result:
    """Do one job of the experiment called `name`, in whichever process.

    `HeftingError` when a `source` is given that is not this process's: its result would
    pass for one of that source.
    """
    from hefting.reproduction.experiments import EXPERIMENTS

    if source not in (None, source_version()):
        raise HeftingError(
            "a worker of the cluster has another version of hefting; install the same on all"
        )
    # the same as when read back from a file
    return json.loads(json.dumps(EXPERIMENTS[name].run(job)))


def _on_processes(
    tasks: list[tuple[str, Job]], workers: int
) -> Iterator[tuple[int, Result]]:
    """Each task's number and result, as they come. A worker that is killed costs its
    jobs' time and nothing else."""
    left, attempt = dict(enumerate(tasks)), 0
    while left:
        with _OneThreadEach(), _deaf_to_interrupts():
            pool = ProcessPoolExecutor(
                min(workers, len(left)), mp_context=get_context("spawn")
            )
            futures = {pool.submit(do, *task): k for k, task in left.items()}
        try:
            for future in as_completed(futures):
                result = future.result()
                yield futures[future], result
                del left[futures[future]]
        except BrokenProcessPool:
            attempt += 1
            if attempt == ATTEMPTS:
                raise HeftingError(
                    f"workers died {ATTEMPTS} times; is there memory enough? try --jobs 1"
                ) from None
        except KeyboardInterrupt:
            for worker in active_children():
                worker.terminate()
            raise
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Processes that begin meanwhile ignore Ctrl-C, which reaches them too: this one
    ends them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _on_cluster(
    tasks: list[tuple[str, Job]], address: str
) -> Iterator[tuple[int, Result]]:
    """The same on a Dask cluster."""
    try:
        from distributed import Client, KilledWorker
        from distributed import as_completed as dask_completed
    except ImportError:
        raise MissingDependencyError("distributed", "batch") from None
    try:
        client = Client(address, timeout="10s")
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"no Dask scheduler answers ({error})", address, "start one: dask scheduler"
        ) from error
    log = logging.getLogger("distributed.client")
    level = log.level
    log.setLevel(logging.CRITICAL)  # what is wrong is said once, below
    try:
        with client:
            futures = [
                client.submit(do, *task, source_version(), pure=False, retries=ATTEMPTS)
                for task in tasks
            ]
            numbers = {future.key: k for k, future in enumerate(futures)}
            for future in dask_completed(futures):
                yield numbers[future.key], future.result()
    except (CancelledError, OSError) as error:
        raise HeftingError(
            f"{address}: the Dask scheduler was lost; the same command goes on"
        ) from error
    except KilledWorker as error:
        raise HeftingError(
            f"{address}: workers died at one job again and again; have they memory enough?"
        ) from error
    finally:
        log.setLevel(level)


class _OneThreadEach:
    """Workers begun inside compute on one thread each: no faster with more, and the
    same to the last bit."""

    def __enter__(self) -> None:
        self.before = {name: os.environ.get(name) for name in THREADS}
        os.environ.update(dict.fromkeys(THREADS, "1"))

    def __exit__(self, *_: object) -> None:
        for name, value in self.before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _path(folder: Path, name: str, job: Job) -> Path:
    key = hashlib.sha256(
        json.dumps([source_version(), job], sort_keys=True).encode()
    ).hexdigest()[:24]
    return folder / "results" / name / f"{key}.json"


def _kept(folder: Path, name: str, job: Job) -> Result | None:
    path = _path(folder, name, job)
    if not path.exists():
        return None
    try:
        return json.loads(path.read_text())["result"]
    except (OSError, ValueError, KeyError, TypeError):
        return None  # not whole: done again


@cache
def source_version() -> str:
    """A hash of this library's source: results of another source are not comparable."""
    root = Path(hefting.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()

"""Tasks on a Dask cluster."""

import logging
import time
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from itertools import islice
from typing import Any

from hefting.core.errors import HeftingError, InputError, MissingDependencyError
from hefting.jobs.outcome import Died, Task
from hefting.jobs.source import source_version

PATIENCE = "10s"
"""How long a scheduler may take to answer."""

SILENCE = "12s"
"""How long a network may be broken; Dask takes no less."""

RECOUNT = 5.0
"""After how long the workers are counted again, which come and go [s]."""


class Cluster:
    """Workers of the Dask scheduler at `address`. One that dies is replaced by others.

    Raises `InputError` when no scheduler answers, `MissingDependencyError` without
    ``distributed`` (extra ``batch``).
    """

    def __init__(self, address: str) -> None:
        try:
            from dask import config
            from distributed import Client
        except ImportError:
            raise MissingDependencyError("distributed", "batch") from None
        self.address = address
        self.counted: tuple[float, int] | None = None
        """When the threads of all workers were counted [s], and how many they were."""
        with ExitStack() as stack:
            stack.enter_context(_silent("distributed.client"))
            try:
                with config.set({"distributed.comm.timeouts.tcp": SILENCE}):
                    self.client = Client(
                        address, timeout=PATIENCE, set_as_default=False
                    )
            except (OSError, TimeoutError, ValueError) as error:
                raise InputError(
                    f"no Dask scheduler answers ({error})",
                    address,
                    "start one: dask scheduler",
                ) from error
            stack.callback(self.client.close)
            self.stack = stack.pop_all()

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task, as it comes, and its result or `Died`.

        Raises `HeftingError` when the scheduler is lost or a worker has another source,
        and what `function` raises.
        """
        from distributed import as_completed

        done = as_completed(
            loop=self.client.loop, with_results=True, raise_errors=False
        )
        held: dict[str, Task] = {}
        while True:
            for task in islice(tasks, max(0, window * self._threads() - len(held))):
                future = self._submit(function, task)
                held[future.key] = task
                done.add(future)
            if not held:
                return
            future, result = next(done)
            yield held.pop(future.key), self._result(future.status, result)

    def run_alone(self, function: Callable[[Any], Any], task: Task) -> Any:
        """Result of a task while this run does no other; or `Died` when as many workers
        died as the scheduler allows."""
        [(_, result)] = self.run(function, iter([task]), 1)
        return result

    def close(self) -> None:
        """Leave the cluster, whose workers stay."""
        self.stack.close()

    def _submit(self, function: Callable[[Any], Any], task: Task) -> Any:
        try:
            return self.client.submit(
                _do, function, task.argument, source_version(), pure=False
            )
        except OSError as error:
            raise self._lost() from error

    def _result(self, status: str, result: Any) -> Any:
        """A result, or `Died`; what else came of a future is raised."""
        from distributed import KilledWorker

        if status == "finished":
            return result
        if isinstance(result, CancelledError):
            raise self._lost() from result
        error = result[1]
        if isinstance(error, KilledWorker):
            return Died(
                f"workers died {error.allowed_failures + 1} times; "
                "have they memory enough?"
            )
        raise error

    def _threads(self) -> int:
        """Threads of all workers, one at least: more workers come for what waits."""
        now = time.monotonic()
        if self.counted is None or now > self.counted[0] + RECOUNT:
            try:
                self.counted = now, sum(self.client.nthreads().values())
            except (OSError, AttributeError) as error:
                raise self._lost() from error
        return max(1, self.counted[1])

    def _lost(self) -> HeftingError:
        return HeftingError(
            f"{self.address}: the Dask scheduler was lost; the same command goes on"
        )


def _do(function: Callable[[Any], Any], argument: Any, source: str) -> Any:
    """Do a task, on a worker. Its result would pass for one of `source`."""
    if source != source_version():
        raise HeftingError(
            "a worker of the cluster has another version of hefting; "
            "install the same on all"
        )
    return function(argument)


@contextmanager
def _silent(name: str) -> Iterator[None]:
    """No log of that name, which would say once more what an error says."""
    log = logging.getLogger(name)
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(level)

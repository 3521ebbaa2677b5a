"""Tasks on a Dask cluster."""

import logging
import time
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError
from itertools import islice
from typing import Any

from hefting.core.errors import HeftingError, InputError, MissingDependencyError
from hefting.jobs.outcome import Died, Task
from hefting.jobs.source import source_version

PATIENCE = "10s"
"""How long a scheduler may take to answer, or be silent on a broken connection."""

RECOUNT = 5.0
"""After how long the workers are counted again, which come and go [s]."""


class Cluster:
    """Workers of the Dask scheduler at `address`. One that dies is replaced by others.

    Raises `InputError` when no scheduler answers, `MissingDependencyError` without
    ``distributed`` (extra ``batch``).
    """

    attempts = 1  # the scheduler itself begins a task several times

    def __init__(self, address: str) -> None:
        try:
            from dask import config
            from distributed import Client
        except ImportError:
            raise MissingDependencyError("distributed", "batch") from None
        self.address = address
        self.log = logging.getLogger("distributed.client")
        self.level = self.log.level
        self.log.setLevel(logging.CRITICAL)  # what is wrong is said once, by `_lost`
        self.counted: tuple[float, int] | None = None
        """When the threads of all workers were counted [s], and how many they were."""
        try:
            with config.set({"distributed.comm.timeouts.tcp": PATIENCE}):
                self.client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            self.log.setLevel(self.level)
            raise InputError(
                f"no Dask scheduler answers ({error})",
                address,
                "start one: dask scheduler",
            ) from error

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

    def close(self) -> None:
        """Leave the cluster, whose workers stay."""
        try:
            self.client.close()
        finally:
            self.log.setLevel(self.level)

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
            return Died("died, and others after it")
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

"""Tasks on a Dask cluster."""

import logging
import pickle
import re
import time
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from itertools import islice
from typing import Any
from uuid import uuid4

from hefting.core.errors import HeftingError, InputError, needing
from hefting.jobs.worker import Died, Task, source_version

PATIENCE = "10s"
"""Longest wait for a scheduler's answer."""

SILENCE = "12s"
"""Longest interruption of the network; Dask takes no shorter one."""

RECOUNT = 5.0
"""[s] Time after which the workers, whose number changes, are counted again."""

HERE = ("hefting", "hefting.jobs", "hefting.jobs.cluster")
"""Modules that a worker without hefting, or with an old version, cannot import."""

OTHER_VERSION = "a worker of the cluster has another version of hefting, or none; install the same on all"


class Cluster:
    """Workers of the Dask scheduler at `address`. One that dies is replaced by others.

    Raises `InputError` when no scheduler answers, `MissingDependencyError` without
    ``distributed`` (extra ``batch``).
    """

    def __init__(self, address: str) -> None:
        with needing("distributed", "batch"):
            from dask import config
            from distributed import Client
        if not re.search(r":\d+/?$|^inproc:", address):
            raise InputError("has no port", address, "give it, as in tcp://host:8786")
        self.address = address
        self.counted: tuple[float, int] | None = None
        """time of the last count [s], and the number of all workers' threads then"""
        with ExitStack() as stack:
            for name in ("distributed", "distributed.client"):
                stack.enter_context(_silent(name))
            try:
                with config.set({"distributed.comm.timeouts.tcp": SILENCE}):
                    self.client: Any = Client(
                        address, timeout=PATIENCE, set_as_default=False
                    )
            except (OSError, TimeoutError, ValueError) as error:
                what = f"no Dask scheduler answers ({error})"
                raise InputError(what, address, "start one: dask scheduler") from error
            stack.callback(self.client.close)
            self.stack = stack.pop_all()

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task and its result or `Died`, as they finish.

        Raises `HeftingError` when the scheduler is lost or a worker has another source,
        and what `function` raises.
        """
        from distributed import as_completed

        done = as_completed(loop=self.client.loop)
        held: dict[Any, Task] = {}
        while True:
            for task in islice(tasks, max(0, window * self._threads() - len(held))):
                future = self._submit(function, task)
                held[future] = task
                done.add(future)
            if not held:
                return
            for future, result in self._results(done.next_batch()):
                yield held.pop(future), result

    def run_alone(self, function: Callable[[Any], Any], task: Task) -> Any:
        """Result of a task without others of this run; `Died` when as many workers died
        as the scheduler allows."""
        [(_, result)] = self.run(function, iter([task]), 1)
        return result

    def close(self) -> None:
        """Leave the cluster, whose workers stay."""
        self.stack.close()

    def _submit(self, function: Callable[[Any], Any], task: Task) -> Any:
        from cloudpickle import dumps  # which Dask needs

        call = _Call(dumps((function, task.argument)), source_version())
        try:
            # a unique name, which Dask's dashboard shows
            name = f"hefting-{uuid4()}"
            return self.client.submit(pickle.loads, dumps(call), key=name)
        except OSError as error:
            raise self._lost() from error

    def _results(self, futures: list[Any]) -> Iterator[tuple[Any, Any]]:
        try:
            results = self.client.gather(futures)
        except Exception:
            results = map(self._result, futures)
        return zip(futures, results, strict=True)

    def _result(self, future: Any) -> Any:
        from distributed import KilledWorker

        try:
            return future.result()
        except KilledWorker as error:
            return Died(
                f"workers died {error.allowed_failures + 1} times; "
                "have they memory enough?"
            )
        except (CancelledError, OSError) as error:
            if future.status == "error":
                raise  # an error of the function
            raise self._lost() from error
        except ImportError as error:
            if error.name in HERE:
                raise HeftingError(OTHER_VERSION) from error
            raise

    def _threads(self) -> int:
        """Number of all workers' threads, at least one, as waiting tasks may make the
        scheduler start workers."""
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


class _Call:
    """A call of `_do`, made when it is unpickled by the task itself. The scheduler does
    not unpickle it, and needs no hefting; a worker without hefting fails at the task
    and does not end, as it would when it cannot read the message with the task."""

    def __init__(self, *arguments: Any) -> None:
        self.arguments = arguments

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        return _do, self.arguments


def _do(message: bytes, source: str) -> Any:
    """Call a pickled function with its argument, on a worker; `HeftingError` where its
    version is not `source`, to which the result would be attributed."""
    if source != source_version():
        raise HeftingError(OTHER_VERSION)
    function, argument = pickle.loads(message)
    return function(argument)


@contextmanager
def _silent(name: str) -> Iterator[None]:
    """Silence the log of that name, which repeats what an error says."""
    log = logging.getLogger(name)
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        log.setLevel(level)

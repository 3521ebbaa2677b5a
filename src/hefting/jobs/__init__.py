"""Jobs: many independent tasks on local processes or on a Dask cluster, none stopped by
another.

Neither which process does a task nor the order matters to its result. A task by which
every worker dies costs the others time and nothing else.
"""

import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from multiprocessing.connection import wait
from types import TracebackType
from typing import Any, TypeVar

from hefting.core.errors import HeftingError, InputError
from hefting.jobs.cluster import Cluster
from hefting.jobs.worker import Died, Lost, Task, Worker, Workers, source_version

__all__ = ["Jobs", "Lost", "source_version"]

T = TypeVar("T")
R = TypeVar("R")

WINDOW = 4
"""Tasks that a worker holds at once where the caller does not say: enough for it never
to wait while the caller takes its time with a result."""


def check_workers(count: int | None) -> None:
    """`InputError` for fewer local processes than one; None is one a core."""
    if count is not None and count < 1:
        what = f"at least one process is needed, not {count}"
        raise InputError(what, fix="give `jobs` of 1 or more")


class Jobs:
    """Workers for as many runs as are wanted, one after the other.

    Parameters
    ----------
    workers : local processes at most, by default one a core. They are begun as tasks
        come, and end with the ``with`` block, with this process, and where a run is
        left before its end. One is a process of its own too: what kills it does not
        end the run, and it computes on one thread, as all do.
    scheduler : address of a Dask scheduler to use instead (extra ``batch``).

    Raises `InputError` for less than one process, or when the scheduler does not
    answer.

    Examples
    --------
    >>> from hefting.jobs import Jobs
    >>> with Jobs(workers=2) as jobs:
    ...     print(sorted(jobs.run(abs, [-3, 4])))
    [(0, 3), (1, 4)]
    """

    def __init__(
        self, workers: int | None = None, scheduler: str | None = None
    ) -> None:
        check_workers(workers)
        self._workers: Workers = (
            Cluster(scheduler)
            if scheduler
            else Processes(workers or os.cpu_count() or 1)
        )

    def __enter__(self) -> "Jobs":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        self._workers.close()

    def run(
        self, function: Callable[[T], R], tasks: Iterable[T], window: int | None = None
    ) -> Generator[tuple[int, R | Lost], None, None]:
        """Each task's number and what `function` returns for it, as they come.

        Parameters
        ----------
        function : of a module that the workers can import; what it returns can be
            pickled.
        tasks : taken as workers get free, never more than `window` a worker ahead.
        window : tasks that a worker holds at once, that it is at included. One for long
            tasks of different lengths: a worker that is done does not help out another.

        Returns
        -------
        `Lost` in place of the result of a task that no worker survives: each whose
        worker died is done again at the end, by itself.

        Raises `HeftingError` when the scheduler is lost (after what had come), when a
        worker has another version of the source, or when no process can be begun; and
        what `function` raises.
        """
        window = WINDOW if window is None else window
        numbered = (Task(k, task) for k, task in enumerate(tasks))
        suspects: list[Task] = []
        with closing(self._workers.run(function, numbered, window)) as answers:
            for task, result in answers:
                if isinstance(result, Died):
                    suspects.append(task)
                else:
                    yield task.number, result
        for task in suspects:
            result = self._workers.run_alone(function, task)
            lost = isinstance(result, Died)
            yield task.number, Lost(result.reason) if lost else result


ATTEMPTS = 3
"""How often a task is begun alone before it is given up, or a process in succession."""


class Processes:
    """Up to `size` local processes, begun as tasks come. One that dies is replaced."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.workers: list[Worker] = []
        self.again: deque[Task] = deque()
        """Tasks of processes that died before they were at them."""
        self.stillborn = 0
        """How many processes died in succession before they were ready."""

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task, as it comes, and its result or `Died`.

        Raises `HeftingError` when no process can be begun, and what `function` raises.
        """
        try:
            self._fill(function, tasks, window)
            while busy := [worker for worker in self.workers if worker.held]:
                ready = wait([worker.connection for worker in busy])
                for worker in busy:
                    if worker.connection not in ready:
                        continue
                    answer = self._answer(worker)
                    # the worker goes on while the caller uses the answer
                    self._fill(function, tasks, window)
                    if answer is not None:
                        yield answer
        finally:
            self.again.clear()
            self._end([worker for worker in self.workers if worker.held])

    def run_alone(self, function: Callable[[Any], Any], task: Task) -> Any:
        """Result of a task while no other process is there to take its memory; or
        `Died` when it was so each of `ATTEMPTS` times."""
        result: Any = None
        for _ in range(ATTEMPTS):
            self.close()
            [(_, result)] = self.run(function, iter([task]), 1)
            if not isinstance(result, Died):
                return result
        return Died(f"{result.reason}, {ATTEMPTS} times; has it memory enough?")

    def close(self) -> None:
        """End all processes."""
        self._end(list(self.workers))

    def _fill(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> None:
        """Give tasks to whoever holds fewest, until each holds `window` of them."""
        while (room := self._room(window)) is not None:
            task = self.again.popleft() if self.again else next(tasks, None)
            if task is None:
                return
            room().give(function, task)

    def _room(self, window: int) -> Callable[[], Worker] | None:
        """How to get the worker for the next task, begun if need be; else None."""
        least = min(self.workers, key=lambda worker: len(worker.held), default=None)
        if len(self.workers) < self.size and (least is None or least.held):
            return self._begin
        return None if least is None or len(least.held) >= window else lambda: least

    def _begin(self) -> Worker:
        try:
            self.workers.append(Worker())
        except OSError as error:
            raise HeftingError(
                f"no worker process can be begun ({error.strerror})"
            ) from error
        return self.workers[-1]

    def _answer(self, worker: Worker) -> tuple[Task, Any] | None:
        """What it says: a task and its result, or `Died`; None when it is of no task.
        Tasks of a dead one that it was not at are done again."""
        try:
            answer = worker.answer()
        except EOFError:
            return self._bury(worker)
        self.stillborn = 0
        return answer

    def _bury(self, worker: Worker) -> tuple[Task, Any] | None:
        how = worker.cause_of_death()
        self._end([worker])
        suspect = worker.held.popleft() if worker.ready else None
        self.again.extendleft(reversed(worker.held))
        if suspect is not None:
            return suspect, Died(f"its worker {how}")
        self.stillborn += 1
        if self.stillborn == ATTEMPTS:
            raise HeftingError(
                f"{ATTEMPTS} worker processes died before they began, the last {how}; "
                'a script that uses them needs if __name__ == "__main__":'
            )
        return None

    def _end(self, workers: list[Worker]) -> None:
        self.workers = [w for w in self.workers if w not in workers]
        for worker in workers:
            worker.end()

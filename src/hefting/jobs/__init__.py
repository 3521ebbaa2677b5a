"""Jobs: many independent tasks on local processes or on a Dask cluster.

A result depends neither on the process nor on the order. A task that kills its workers
delays the others, and does not stop them.
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
"""Default number of tasks that a worker holds at once, so that it does not wait while
the caller uses a result."""


def check_workers(count: int | None) -> None:
    """`InputError` for fewer local processes than one; None stands for one per core."""
    if count is not None and count < 1:
        what = f"at least one process is needed, not {count}"
        raise InputError(what, fix="give `jobs` of 1 or more")


class Jobs:
    """Workers for any number of runs, one after the other.

    Parameters
    ----------
    workers : largest number of local processes, by default one per core. They start
        as tasks come, and end with the ``with`` block, with this process, and when a
        run is left before its end. A single worker is a separate process too, so that
        its death does not end the run. Each computes on one thread.
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
        """Number and result of each task, in the order in which they finish.

        Parameters
        ----------
        function : of a module that the workers can import; its result can be pickled.
        tasks : taken as workers become free.
        window : largest number of tasks that a worker holds at once, with that which it
            runs. Give 1 for long tasks of different lengths, as workers do not take
            over each other's tasks.

        Returns
        -------
        The result is `Lost` for a task at which every worker died. A task whose worker
        died is run again at the end, without others.

        Raises `HeftingError` when the scheduler is lost (after the finished results),
        when a worker has another version of the source, or when no process can be
        started; and what `function` raises.
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
"""Number of times that a task is started alone, or a process in succession, before it
is given up."""


class Processes:
    """Up to `size` local processes, started as tasks come. One that dies is replaced."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.workers: list[Worker] = []
        self.again: deque[Task] = deque()
        """tasks that processes which died had not started"""
        self.stillborn = 0
        """number of processes in succession that died before they were ready"""

    def run(
        self, function: Callable[[Any], Any], tasks: Iterator[Task], window: int
    ) -> Generator[tuple[Task, Any], None, None]:
        """Each task and its result or `Died`, as they finish.

        Raises `HeftingError` when no process can be started, and what `function`
        raises.
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
        """Result of a task without other processes, which take memory; `Died` when its
        process died each of `ATTEMPTS` times."""
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
        """Give tasks to the worker that holds fewest, until each holds `window`."""
        while (room := self._room(window)) is not None:
            task = self.again.popleft() if self.again else next(tasks, None)
            if task is None:
                return
            room().give(function, task)

    def _room(self, window: int) -> Callable[[], Worker] | None:
        """A function that returns, or starts, the worker for the next task; None when
        all hold `window` tasks."""
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
        """A task and its result or `Died`; None when no task is finished. Tasks that a
        dead worker had not started are run again."""
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

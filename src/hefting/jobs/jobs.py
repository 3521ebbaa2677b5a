"""Many independent tasks on local processes or on a Dask cluster.

Neither which process does a task nor the order matters to its result. A task by which
every worker dies costs the others time and nothing else.
"""

import os
from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from types import TracebackType
from typing import TypeVar

from hefting.core.errors import InputError
from hefting.jobs.cluster import Cluster
from hefting.jobs.outcome import Died, Lost, Task, Workers
from hefting.jobs.processes import Processes

T = TypeVar("T")
R = TypeVar("R")

WINDOW = 4
"""Tasks that a worker holds at once where the caller does not say: enough for it never
to wait while the caller takes its time with a result."""


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
        if workers is not None and workers < 1:
            raise InputError(f"at least one process is needed, not {workers}")
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

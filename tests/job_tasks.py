"""What the tests of jobs have done by workers, which import it from here."""

import os
import signal
import sys
import time
from contextlib import closing
from pathlib import Path

from hefting.core.errors import MissingDependencyError
from hefting.jobs import Jobs

POISON = -1


def square(x):
    """What nothing is wrong with; a worker dies at `POISON`."""
    if x == POISON:
        os._exit(3)
    return x * x


def slow_square(x):
    """The same in a while."""
    time.sleep(0.05)
    return square(x)


def begun(task):
    """Leave a mark in a folder, one each time; the worker dies if the number is
    `POISON`."""
    folder, x = task
    Path(folder, f"{x} {time.monotonic_ns()}").touch()
    return square(x)


def inverse(x):
    return 1 / x


def missing(x):
    raise MissingDependencyError("thing", "extra")


class Unreadable(Exception):
    """Cannot be unpickled."""

    def __init__(self, one, two):
        super().__init__(one)


def unreadable(x):
    raise Unreadable("what is wrong", 2)


def unpicklable(x):
    return lambda: x


def threads(x):
    return os.environ["OMP_NUM_THREADS"]


def interrupt_oneself(x):
    """What Ctrl-C does to a worker."""
    os.kill(os.getpid(), signal.SIGINT)
    return x


def large(x):
    """A result larger than a pipe holds."""
    return bytes(x)


def process(x):
    return os.getpid()


def leave(connection):
    """In place of what a worker does."""
    os._exit(1)


def sleep_for_ever(folder):
    """Say in a folder which process does it, and never end."""
    Path(folder, str(os.getpid())).touch()
    while True:
        time.sleep(1)


def compute_for_ever(folder):
    """The same, busy in Python."""
    Path(folder, str(os.getpid())).touch()
    while True:
        sum(range(1000))


def run_jobs(function, tasks, workers=None, scheduler=None, window=None):
    """One run of `Jobs`."""
    with (
        Jobs(workers, scheduler) as jobs,
        closing(jobs.run(function, tasks, window)) as results,
    ):
        yield from results


if __name__ == "__main__":
    endless, folder = sys.argv[1:]
    try:
        list(run_jobs(globals()[endless], [folder, folder], workers=2))
    except KeyboardInterrupt:
        print("interrupted")

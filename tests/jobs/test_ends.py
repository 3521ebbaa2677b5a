"""No process is left, however a run ends."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import job_tasks
from hefting.jobs import Jobs

SECONDS = 20
"""In which processes have ended; they take some hundredths [s]."""


def alive(pid: int) -> bool:
    """Whether a process runs; not one that has ended and is not waited for yet."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")")[-1].split()[0] != "Z"
    except OSError:
        return False


def within(condition) -> bool:
    """Whether a condition comes true in time."""
    end = time.monotonic() + SECONDS
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


@pytest.fixture(params=["sleep_for_ever", "compute_for_ever"])
def endless(request, tmp_path):
    """A process that runs two endless tasks, and the ids of its workers."""
    run = subprocess.Popen(
        [sys.executable, job_tasks.__file__, request.param, tmp_path],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert within(lambda: len(list(tmp_path.iterdir())) == 2)
    workers = [int(path.name) for path in tmp_path.iterdir()]
    assert all(map(alive, workers))
    yield run, workers
    if run.poll() is None:
        os.killpg(run.pid, signal.SIGKILL)
        run.communicate()


linux = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")


@linux
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_workers_end_with_the_process_that_began_them(endless, how):
    run, workers = endless
    run.send_signal(how)
    out, err = run.communicate(timeout=SECONDS)
    assert within(lambda: not any(map(alive, workers)))
    assert (out, "Traceback" in err) == ("", False)


@linux
def test_ctrl_c_ends_all_and_says_nothing_of_workers(endless):
    """The terminal sends it to workers as well."""
    run, workers = endless
    os.killpg(run.pid, signal.SIGINT)
    out, err = run.communicate(timeout=SECONDS)
    assert within(lambda: not any(map(alive, workers)))
    assert (out, err, run.returncode) == ("interrupted\n", "", 0)


def test_a_run_that_is_left_ends_its_workers():
    results = job_tasks.run_jobs(job_tasks.slow_square, range(100), 2)
    next(results)
    assert multiprocessing.active_children()
    results.close()
    assert multiprocessing.active_children() == []


def test_a_caller_that_fails_ends_its_workers():
    def fail():
        with Jobs(2) as jobs:
            for k, _ in jobs.run(job_tasks.slow_square, range(100)):
                raise KeyError(k)

    with pytest.raises(KeyError):
        fail()
    assert multiprocessing.active_children() == []


def test_a_task_that_fails_ends_the_workers():
    with pytest.raises(ZeroDivisionError):
        list(job_tasks.run_jobs(job_tasks.inverse, [1, 1, 0, 1], 2))
    assert multiprocessing.active_children() == []

"""Tasks on a Dask cluster: the same results, whatever becomes of it."""

import logging
import os
import pickle
import signal
import subprocess
import sys
import time
from importlib.util import find_spec

import pytest

import job_tasks
from clusters import local_cluster
from hefting.core.errors import HeftingError, InputError, MissingDependencyError
from hefting.jobs import Jobs, Lost
from hefting.jobs.cluster import _do
from hefting.jobs.worker import source_version
from job_tasks import POISON

pytestmark = pytest.mark.skipif(
    find_spec("distributed") is None, reason="distributed is not installed"
)

SECONDS = 30
"""In which a lost scheduler is said; it takes some tenths. Dask would try for half a
minute to connect, and again [s]."""


@pytest.fixture(scope="module")
def cluster():
    with local_cluster(2) as cluster:
        yield cluster


@pytest.fixture
def jobs(cluster):
    with Jobs(scheduler=cluster.scheduler_address) as jobs:
        yield jobs


@pytest.mark.parametrize("window", [None, 1])
def test_the_same_results_as_local_processes(jobs, window):
    """Which test_processes.py holds to the same."""
    found = list(jobs.run(job_tasks.square, range(50), window))
    assert sorted(found) == [(k, k * k) for k in range(50)]
    assert list(jobs.run(job_tasks.square, [])) == []


def test_tasks_are_taken_as_they_are_needed(jobs):
    taken = []
    tasks = (taken.append(k) or k for k in range(100))
    ahead = 0
    for done, _ in enumerate(jobs.run(abs, tasks, window=3), start=1):
        ahead = max(ahead, len(taken) - done)
    assert done == 100
    assert 0 < ahead <= 2 * 3


def test_workers_that_are_killed_cost_time_only(cluster, jobs):
    found = {}
    for k, result in jobs.run(job_tasks.slow_square, range(20)):
        found[k] = result
        if len(found) == 5:
            os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
    assert found == {k: k * k for k in range(20)}


def test_a_task_that_kills_its_workers_is_lost_alone(cluster, jobs, monkeypatch):
    """By default after four workers; here after two."""
    monkeypatch.setattr(cluster.scheduler, "allowed_failures", 1)
    tasks = [*range(10), POISON, *range(11, 20)]
    found = dict(jobs.run(job_tasks.square, tasks))
    lost = found.pop(10)
    assert isinstance(lost, Lost)
    assert lost.reason == "workers died 2 times; have they memory enough?"
    assert found == {k: k * k for k in range(20) if k != 10}


def test_an_error_comes_as_it_was_raised(jobs):
    with pytest.raises(ZeroDivisionError, match="division by zero"):
        list(jobs.run(job_tasks.inverse, [1, 2, 0, 4]))
    with pytest.raises(MissingDependencyError, match=r"^thing is not installed"):
        list(jobs.run(job_tasks.missing, [1]))
    with pytest.raises(FileNotFoundError):  # no sign of a lost scheduler
        list(jobs.run(os.listdir, ["/no/such/folder"]))


def test_another_source_is_refused():
    assert _do(pickle.dumps((abs, -1)), source_version()) == 1
    with pytest.raises(HeftingError, match="another version of hefting"):
        _do(b"of another version, not read", "another")


def free_port() -> int:
    import socket

    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@pytest.fixture
def dask(tmp_path):
    """A scheduler in a process of its own whose Python finds no hefting, and a function
    that adds a worker to it."""
    hidden = tmp_path / "hidden" / "hefting"
    hidden.mkdir(parents=True)
    (hidden / "__init__.py").write_text("")
    without = str(hidden.parent)
    begun = []

    def begin(*words: object, path: str) -> subprocess.Popen:
        begun.append(
            subprocess.Popen(
                [sys.executable, "-m", "dask", *map(str, words), "--no-dashboard"],
                env={**os.environ, "PYTHONPATH": path},
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        )
        return begun[-1]

    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    scheduler = begin("scheduler", "--host", "127.0.0.1", "--port", port, path=without)

    def add_worker(path: str = os.pathsep.join(sys.path)) -> None:
        begin("worker", address, "--nthreads", 1, path=path)

    yield address, scheduler, add_worker, without
    for process in begun:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def test_a_worker_without_hefting_is_said(dask):
    address, _, add_worker, without = dask
    add_worker(without)
    with pytest.raises(HeftingError, match="has another version of hefting, or none"):
        list(job_tasks.run_jobs(abs, range(9), scheduler=address))


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_lost_scheduler_is_said_and_what_had_come_is_there(dask, how, capfd):
    address, scheduler, add_worker, _ = dask
    add_worker()
    found = {}
    lost = f"{address}: the Dask scheduler was lost; the same command goes on"
    begin = 0.0

    def run_and_kill():
        nonlocal begin
        for k, result in job_tasks.run_jobs(
            job_tasks.slow_square, range(500), scheduler=address
        ):
            found[k] = result
            if len(found) == 10:
                scheduler.send_signal(how)
                begin = time.monotonic()

    with pytest.raises(HeftingError) as caught:
        run_and_kill()
    assert time.monotonic() - begin < SECONDS
    assert str(caught.value) == lost
    assert len(found) >= 10
    assert found == {k: k * k for k in found}
    assert capfd.readouterr().err == ""


def test_a_scheduler_that_does_not_answer(monkeypatch):
    monkeypatch.setattr("hefting.jobs.cluster.PATIENCE", "0.3s")
    level = logging.getLogger("distributed").level
    address = f"tcp://127.0.0.1:{free_port()}"
    with pytest.raises(InputError, match=f"^{address}: no Dask scheduler answers"):
        Jobs(scheduler=address)
    # before a client is made, which would end in a traceback of its own
    for name in ("foo", "no address:at all"):
        with pytest.raises(InputError, match=f"^{name}: has no port"):
            Jobs(scheduler=name)
    assert logging.getLogger("distributed").level == level


def test_without_dask(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingDependencyError, match=r"hefting\[batch\]"):
        Jobs(scheduler="tcp://127.0.0.1:1")

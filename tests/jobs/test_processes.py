"""Tasks on local processes: every result, whatever becomes of the processes."""

import multiprocessing
import os
import signal
from collections import Counter

import pytest

import job_tasks
from hefting.core.errors import HeftingError, InputError, MissingDependencyError
from hefting.jobs import ATTEMPTS, Jobs, Lost, Processes
from job_tasks import POISON


@pytest.fixture(scope="module")
def jobs():
    with Jobs(workers=2) as jobs:
        yield jobs


@pytest.mark.parametrize(("workers", "window"), [(1, 1), (2, None), (3, 3), (3, 1)])
def test_every_task_has_its_result(workers, window):
    found = list(
        job_tasks.run_jobs(job_tasks.square, range(50), workers, window=window)
    )
    assert sorted(found) == [(k, k * k) for k in range(50)]


def test_no_tasks_no_processes():
    with Jobs(workers=2) as jobs:
        assert list(jobs.run(job_tasks.square, [])) == []
        assert multiprocessing.active_children() == []


def test_processes_are_kept_from_one_run_to_the_next(jobs):
    seen = [set(dict(jobs.run(job_tasks.process, range(20))).values()) for _ in "ab"]
    assert len(seen[0] | seen[1]) <= 2
    assert os.getpid() not in seen[0] | seen[1]


@pytest.mark.parametrize("window", [1, 3])
def test_tasks_are_taken_as_they_are_needed(jobs, window):
    """Never more than the window of each worker beyond what has come back."""
    taken = []
    tasks = (taken.append(k) or k for k in range(1000))
    ahead = 0
    for done, _ in enumerate(jobs.run(abs, tasks, window), start=1):
        now = len(taken)
        ahead = max(ahead, now - done)
    assert done == 1000
    assert 0 < ahead <= 2 * window


@pytest.mark.parametrize(("place", "workers"), [(7, 1), (0, 2), (19, 2)])
def test_a_task_that_kills_its_worker_is_lost_alone(place, workers):
    tasks = [*range(20)]
    tasks[place] = POISON
    found = dict(job_tasks.run_jobs(job_tasks.square, tasks, workers, window=3))
    lost = found.pop(place)
    assert lost == Lost(
        f"its worker ended with status 3, {ATTEMPTS} times; has it memory enough?"
    )
    assert found == {k: k * k for k in range(20) if k != place}


def test_how_often_a_task_is_begun(tmp_path):
    """The others once, so that nothing is done in vain; the guilty one in company and
    then alone."""
    tasks = [(str(tmp_path), x) for x in (0, 1, POISON, 3, 4, POISON, 6, 7)]
    results = dict(job_tasks.run_jobs(job_tasks.begun, tasks, 2))
    assert {k for k, result in results.items() if isinstance(result, Lost)} == {2, 5}
    begun = Counter(int(path.name.split()[0]) for path in tmp_path.iterdir())
    assert begun == {0: 1, 1: 1, 3: 1, 4: 1, 6: 1, 7: 1, POISON: 2 * (1 + ATTEMPTS)}


def test_nothing_is_lost_by_workers_that_are_killed():
    """By another than the task: each time a result comes, for a while."""
    found = {}
    for k, result in job_tasks.run_jobs(job_tasks.slow_square, range(25), 2):
        found[k] = result
        if len(found) % 5 == 0 and len(found) < 20:
            os.kill(multiprocessing.active_children()[0].pid, signal.SIGKILL)
    assert found == {k: k * k for k in range(25)}


def test_an_error_comes_as_it_was_raised(jobs):
    with pytest.raises(ZeroDivisionError) as caught:
        list(jobs.run(job_tasks.inverse, [1, 2, 0, 4]))
    assert str(caught.value) == "division by zero"
    assert "return 1 / x" in "".join(caught.value.__notes__)
    with pytest.raises(MissingDependencyError, match=r"^thing is not installed"):
        list(jobs.run(job_tasks.missing, [1]))
    # what cannot be sent says what it said
    with pytest.raises(RuntimeError, match=r"^Unreadable: what is wrong"):
        list(jobs.run(job_tasks.unreadable, [1]))
    with pytest.raises((AttributeError, TypeError), match=r"(?i)pickle"):
        list(jobs.run(job_tasks.unpicklable, [1]))
    # and the next run goes on
    assert sorted(jobs.run(job_tasks.square, range(4))) == [
        (k, k * k) for k in range(4)
    ]


def test_an_error_of_the_tasks_themselves(jobs):
    def tasks():
        yield 1
        raise OSError("no more of them")

    with pytest.raises(OSError, match="no more of them"):
        list(jobs.run(job_tasks.square, tasks()))
    assert list(jobs.run(job_tasks.square, [2])) == [(0, 4)]


def test_a_run_that_is_left_does_not_speak_in_the_next(jobs):
    for _ in jobs.run(job_tasks.slow_square, range(100, 200)):
        break
    assert sorted(jobs.run(job_tasks.square, range(4))) == [
        (k, k * k) for k in range(4)
    ]


def test_large_tasks_and_results_while_the_caller_is_busy(jobs):
    """Neither side waits for the other to read what no pipe can hold."""
    sizes = [3_000_000] * 12
    tasks = (bytes(size) for size in sizes)
    assert sum(n for _, n in jobs.run(len, tasks, window=4)) == sum(sizes)
    results = jobs.run(job_tasks.large, sizes, window=4)
    assert sum(len(result) for _, result in results) == sum(sizes)


def test_one_thread_each(jobs, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert [*job_tasks.run_jobs(job_tasks.threads, [0], 1)] == [(0, "1")]
    assert os.environ["OMP_NUM_THREADS"] == "3"


def test_workers_do_not_hear_ctrl_c(jobs):
    found = list(jobs.run(job_tasks.interrupt_oneself, range(4)))
    assert sorted(found) == [(k, k) for k in range(4)]


def test_processes_that_cannot_begin_are_said(monkeypatch):
    """As when the main module of a script cannot be imported again."""
    import hefting.jobs.worker as worker

    monkeypatch.setattr(worker, "_serve", job_tasks.leave)
    with pytest.raises(HeftingError, match="3 worker processes died before they began"):
        list(job_tasks.run_jobs(job_tasks.square, range(100), 2))
    monkeypatch.setattr(
        "hefting.jobs.Worker",
        lambda: (_ for _ in ()).throw(OSError(11, "no")),
    )
    with pytest.raises(HeftingError, match=r"no worker process can be begun \(no\)"):
        list(job_tasks.run_jobs(job_tasks.square, [1], 1))


def test_idle_processes_that_were_killed_are_not_blamed_on_a_task():
    """Were each taken for a death by the task, they would be enough to give it up."""
    processes = Processes(1 + ATTEMPTS)
    with Jobs() as jobs:
        jobs._workers = processes
        list(jobs.run(job_tasks.slow_square, range(16)))
        assert len(processes.workers) == 1 + ATTEMPTS
        for worker in processes.workers:
            os.kill(worker.process.pid, signal.SIGKILL)
        assert list(jobs.run(job_tasks.square, [5])) == [(0, 25)]


def test_at_least_one_process():
    with pytest.raises(InputError, match=r"at least one process.*; give `jobs`"):
        Jobs(workers=0)

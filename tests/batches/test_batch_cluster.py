"""Batches on a Dask cluster: the same table, whatever becomes of workers and
scheduler."""

import json
import os
import signal
import subprocess
import sys
import time
from importlib.util import find_spec

import pytest
from recorded import recorded

from clusters import local_cluster
from hefting.batches import batch
from hefting.core.errors import HeftingError
from jobs_here import do_jobs_here

pytestmark = pytest.mark.skipif(
    find_spec("distributed") is None, reason="distributed is not installed"
)


@pytest.fixture(scope="module")
def local(tmp_path_factory):
    """A table made in this process, and what it was made of."""
    folder = tmp_path_factory.mktemp("local")
    data = recorded(folder)
    logs = data.logs
    with pytest.MonkeyPatch.context() as monkeypatch:
        do_jobs_here(monkeypatch)
        return logs, data.shared, batch(logs, folder / "results", **data.shared)


@pytest.fixture
def cluster():
    """With one worker, replaced when it is killed: it is at a recording then."""
    with local_cluster(1) as cluster:
        yield cluster


def rows(found):
    return found.table().drop(["seconds"])


def started(what, *words):
    """A scheduler or a worker, as one starts them in a shell."""
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{what}", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def test_the_same_table_also_when_a_worker_is_killed(cluster, local, tmp_path):
    logs, shared, alone = local
    killed = []

    def kill_one(progress):
        if progress.done == 2 and not killed:
            killed.append(next(iter(cluster.workers.values())).pid)
            os.kill(killed[0], signal.SIGKILL)

    scheduler = cluster.scheduler_address
    found = batch(
        logs, tmp_path / "r", scheduler=scheduler, progress=kill_one, **shared
    )
    assert killed
    assert rows(found).equals(rows(alone))


def test_a_scheduler_that_dies_is_said_and_nothing_is_lost(
    local, tmp_path, monkeypatch
):
    do_jobs_here(monkeypatch)  # what is left
    logs, shared, alone = local
    told = tmp_path / "scheduler.json"
    alone_here = ("--host", "127.0.0.1", "--no-dashboard")
    scheduler = started(
        "scheduler", "--port", "0", "--scheduler-file", told, *alone_here
    )
    while not told.exists() or not told.read_text().endswith("}"):  # or half written
        time.sleep(0.1)
    address = json.loads(told.read_text())["address"]
    worker = started("worker", address, "--nthreads", "1", "--no-dashboard")

    def kill(progress):
        if progress.done == 3:
            scheduler.kill()

    try:
        with pytest.raises(HeftingError, match="the Dask scheduler was lost"):
            batch(logs, tmp_path / "r", scheduler=address, progress=kill, **shared)
    finally:
        for process in (scheduler, worker):
            process.kill()
            process.wait()
    again = batch(logs, tmp_path / "r", jobs=1, resume=True, **shared)
    assert again.progress.kept >= 3
    assert rows(again).equals(rows(alone))

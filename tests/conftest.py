"""Fixtures that several files share."""

import gc
import os
import sys
import tempfile
from functools import partial
from importlib import import_module
from shutil import disk_usage

import pytest

from browser import chromium
from computed_once import (
    CONDITIONING,
    INGESTING,
    JUDGING,
    MOVING,
    OF_RUNS,
    SAMPLING,
    SMOOTHING,
    computed_once,
)
from hefting.cli import main

LONG = (
    "project/test_site.py",
    "torques/test_torque_suspects.py",
    "page/test_report_browser.py",
    "cli/test_torques.py",
    "ingest/test_rivals.py",
    "online/test_pipeline.py",
    "ingest/test_rival_poses.py",
    "identification/test_recorded.py",
    "ingest/test_two_mistakes.py",
    "reference/test_reference_ingest.py",
    "benchmarks/test_fuzz.py",
    "ingest/test_rival_wrenches.py",
    "planning/test_plan.py",
    "benchmarks/test_benchmarks.py",
    "cli/test_live_command.py",
    "project/test_docs_commands.py",
    "ingest/test_changes.py",
    "project/test_examples.py",
    "reproduction/test_evaluation.py",
    "sources/test_transports.py",
    "project/test_package.py",
    "jobs/test_cluster.py",
    "identification/test_stopping.py",
    "ingest/test_short_drift.py",
    "ingest/test_weights.py",
    "viewer/test_pages.py",
    "benchmarks/test_injection.py",
    "cli/test_cli_predict.py",
    "torques/test_torque_fits.py",
    "ingest/test_response.py",
    "batches/test_batch.py",
    "cli/test_cli_plan.py",
    "plots/test_plotting.py",
    "planning/test_joint_torques.py",
    "ingest/test_robust.py",
    "cli/test_outputs.py",
    "cli/test_pictures.py",
    "shapes/test_hull.py",
    "online/test_identifier.py",
    "cli/test_terminal.py",
    "benchmarks/test_mutants.py",
    "estimators/test_point_intervals.py",
    "notebook/test_notebook.py",
    "estimators/test_bayes_warm.py",
    "project/test_docs.py",
    "cli/test_cli.py",
    "reference/test_reference_rivals.py",
    "batches/test_batch_cluster.py",
    "estimators/test_bayes_prior.py",
    "estimators/test_bayes_streamed.py",
    "identification/test_several.py",
    "reference/test_reference_changes.py",
    "batches/test_groups.py",
    "reproduction/test_evaluation_parameters.py",
    "benchmarks/test_benchmark_against.py",
    "viewer/test_live_view.py",
    "identification/test_partials.py",
    "benchmarks/test_benchmark_accuracy.py",
    "cli/test_transcripts.py",
    "benchmarks/test_benchmark_mistakes.py",
    "project/test_conventions.py",
    "benchmarks/test_benchmark_sensor_accuracy.py",
    "jobs/test_processes.py",
    "ingest/test_rival_objects.py",
    "viewer/test_session.py",
    "logs/test_text_files.py",
)
"""Files that take longest: they come first, so that no process ends long after the
others."""

INPUTS: dict[bytes, object] = {}
"""What `same_inputs` keeps from file to file."""


MEMORY = "/dev/shm"
"""Where Linux has files in memory: to make and remove the ten thousand files of a run
there costs next to nothing, on a disk half a minute of waiting."""


def write_to_memory():
    """Tests write their files to memory where there is room and nobody chose a place."""
    if "TMPDIR" in os.environ or not os.access(MEMORY, os.W_OK | os.X_OK):
        return
    if disk_usage(MEMORY).free > 4e9:
        tempfile.tempdir = os.environ["TMPDIR"] = MEMORY


write_to_memory()


gc.disable()
"""Until tests are collected: modules and tests stay, and to look through them for garbage
takes a fifth of the time."""


def pytest_collection_finish():
    """What was collected is not looked through later either."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items):
    """The files of `LONG` first; else in the order in which they were found."""

    def place(item):
        name = item.nodeid.split("::")[0].removeprefix("tests/")
        return LONG.index(name) if name in LONG else len(LONG)

    items.sort(key=place)


@pytest.fixture(scope="module")
def browser():
    """A headless browser for the tests of a file."""
    with chromium() as browser:
        yield browser


@pytest.fixture(scope="module", autouse=True)
def same_inputs(request):
    """The same simulated motions and points of the same shapes serve many files, but for
    tests of themselves."""
    if request.path.parent.name in ("shapes", "simulation"):
        yield
    else:
        with computed_once(MOVING, SAMPLING, known=INPUTS):
            yield


@pytest.fixture(scope="module")
def same_poses():
    """Poses that recordings of a file share are smoothed once."""
    with computed_once(SMOOTHING):
        yield


@pytest.fixture(scope="module")
def same_recordings():
    """A recording that a file identifies in several ways is conditioned, and mistakes in
    it are looked for, once."""
    with computed_once(SMOOTHING, CONDITIONING, JUDGING):
        yield


@pytest.fixture
def nothing_looked_for(monkeypatch):
    """Neither changes of the object nor mistakes are looked for: for statistics of many
    recordings that have none. The search for changes alters no other number
    (`ingest/test_changes.py`); a mistake that is named widens intervals."""
    ingest = import_module("hefting.ingest.ingest")
    monkeypatch.setattr(ingest, "condition", partial(ingest.condition, changes=False))
    part = import_module("hefting.ingest.chosen_part")
    monkeypatch.setattr(part, "doubt_of", lambda case, **_: None)


@pytest.fixture(scope="module")
def same_commands():
    """A recording that commands of a file identify is understood once, and so are runs
    of joint torques."""
    with computed_once(SMOOTHING, INGESTING, *OF_RUNS):
        yield


@pytest.fixture
def run(monkeypatch, capsys):
    """Run a command in this process: exit status, standard output, standard error."""

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["hefting", *map(str, words)])
        status = 0
        try:
            main()
        except SystemExit as stop:
            status = stop.code
        out, err = capsys.readouterr()
        return status, out, err

    return run

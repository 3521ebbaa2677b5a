"""Fixtures that several files share."""

import sys
from functools import partial
from importlib import import_module

import pytest

from browser import chromium
from computed_once import (
    CONDITIONING,
    INGESTING,
    MOVING,
    OF_RUNS,
    SAMPLING,
    SMOOTHING,
    computed_once,
)
from hefting.cli import main

LONG = (
    "page/test_report_browser.py",
    "ingest/test_rivals.py",
    "ingest/test_rival_poses.py",
    "ingest/test_rival_wrenches.py",
    "viewer/test_pages.py",
    "cli/test_torques.py",
    "project/test_site.py",
    "planning/test_plan.py",
    "project/test_docs_commands.py",
    "benchmarks/test_fuzz.py",
    "reproduction/test_evaluation.py",
    "benchmarks/test_benchmarks.py",
    "torques/test_torque_fits.py",
    "sources/test_transports.py",
    "reference/test_reference_ingest.py",
    "project/test_examples.py",
    "cli/test_cli_plan.py",
    "project/test_package.py",
    "notebook/test_notebook.py",
    "jobs/test_cluster.py",
    "online/test_pipeline.py",
    "batches/test_batch_cluster.py",
    "project/test_docs.py",
    "ingest/test_robust.py",
    "cli/test_live_command.py",
    "online/test_identifier.py",
    "estimators/test_point_intervals.py",
    "cli/test_pictures.py",
    "shapes/test_hull.py",
    "benchmarks/test_mutants.py",
    "planning/test_joint_torques.py",
    "batches/test_batch.py",
    "ingest/test_response.py",
    "ingest/test_changes.py",
    "plots/test_plotting.py",
    "cli/test_transcripts.py",
)
"""Files that take longest: they come first, so that no process ends long after the
others."""

INPUTS: dict[bytes, object] = {}
"""What `same_inputs` keeps from file to file."""


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
    """A recording that a file identifies in several ways is conditioned once."""
    with computed_once(SMOOTHING, CONDITIONING):
        yield


@pytest.fixture
def nothing_looked_for(monkeypatch):
    """Neither changes of the object nor mistakes are looked for: for statistics of many
    recordings that have none. The search for changes alters no other number
    (`ingest/test_changes.py`); a mistake that is named widens intervals."""
    ingest = import_module("hefting.ingest.ingest")
    monkeypatch.setattr(ingest, "condition", partial(ingest.condition, changes=False))
    part = import_module("hefting.ingest.left_out")
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

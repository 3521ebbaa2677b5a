"""The benchmarks run, print their table, and find Hefting faster than what one would use instead."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def quick_run(tmp_path_factory):
    """Printed table and JSON report of one quick run."""
    for module in ("cvxpy", "clarabel", "pinocchio"):
        pytest.importorskip(module, reason=f"{module} is not installed")
    file = tmp_path_factory.mktemp("benchmarks") / "report.json"
    command = [sys.executable, "-m", "benchmarks", "--quick", "--json", str(file)]
    done = subprocess.run(command, cwd=ROOT, env=dict(os.environ), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout, json.loads(file.read_text())


def rows(report: dict, title: str) -> list[dict]:
    found = [row for section in report["sections"] if title in section["title"] for row in section["rows"]]
    assert found, f"no section '{title}'"
    return found


def test_every_section_is_printed(quick_run):
    table, report = quick_run
    assert len(report["sections"]) == 18
    for section in report["sections"]:
        assert section["title"].split(",")[0] in table
        for row in section["rows"]:
            assert row["seconds"] is not None or row["figure"] is not None


def test_ratios_are_above_one(quick_run):
    """Hundreds against the conic solver, about ten against Pinocchio: 1 leaves room for a busy machine."""
    _, report = quick_run
    every = [row for section in report["sections"] for row in section["rows"]]
    ratios = [row["figure"] for row in every if row["unit"] == "x"]
    assert len(ratios) == 29
    assert min(ratios) > 1.0


def test_both_parties_solve_the_same_problem(quick_run):
    """Equal to Clarabel's default tolerance of 1e-8, with room; Hefting's own is 1e-7 at the worst."""
    _, report = quick_run
    differences = [row["figure"] for row in rows(report, "150 samples") if "difference" in row["what"]]
    assert abs(differences[0]) < 1e-6
    parameters = next(row for row in rows(report, "OLS") if "difference" in row["what"])
    assert parameters["figure"] < 1e-9  # both are exact least squares: rounding alone


@pytest.mark.parametrize("title", ["GEO, known noise, 1,000", "GEO, unknown noise, 1,000", "LMI, constraint"])
def test_geo_and_lmi_solve_the_problem_as_stated(quick_run, title):
    """Clarabel's default tolerance is 1e-8, relative to the objective; both do better than 1e-8 here."""
    _, report = quick_run
    differences = [row["figure"] for row in rows(report, title) if "difference" in row["what"]]
    assert differences
    assert max(differences) < 1e-6


def test_the_constraint_of_lmi_is_active_where_it_is_said_to_be(quick_run):
    _, report = quick_run
    for title, sign in (("constraint active, 1,000", -1.0), ("constraint inactive", 1.0)):
        margin = next(row["figure"] for row in rows(report, title) if "margin" in row["what"])
        assert sign * margin > 0.0


def test_memory_does_not_grow(quick_run):
    """A copy of the samples would take 34 MB here: 200,000 of 21 doubles."""
    _, report = quick_run
    rise = next(row for row in rows(report, "Folding") if row["unit"] == "MiB")
    assert rise["figure"] < 8.0


def test_a_long_recording_takes_bounded_memory(quick_run):
    """50,000 rows take 490 MiB, a million 870: what is worked on does not grow beyond 50,000 samples."""
    _, report = quick_run
    found = {row["what"]: row["figure"] for row in rows(report, "poses and wrench as CSV")}
    assert found["peak memory"] < 650.0
    assert found["error of the mass"] < 0.1  # ten times its standard deviation

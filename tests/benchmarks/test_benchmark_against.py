"""`benchmarks.against`: every party is set up rightly, and what is said of it is what
was measured."""

import importlib
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from importlib.metadata import version
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

for module in ("cvxpy", "clarabel", "pinocchio", "mujoco", "absl", "tabulate"):
    pytest.importorskip(module, reason=f"{module} is not installed")

from benchmarks.against import tables, versions  # noqa: E402
from benchmarks.against.__main__ import replaced  # noqa: E402
from benchmarks.against.cost import slope  # noqa: E402
from benchmarks.against.measure import goals  # noqa: E402
from benchmarks.against.ours import BARE  # noqa: E402
from benchmarks.against.parties import parties  # noqa: E402
from benchmarks.against.party import Answer, NoAnswerError, Party  # noqa: E402
from benchmarks.against.recordings import random_tool  # noqa: E402
from benchmarks.against.runs import Outcome, measured  # noqa: E402
from benchmarks.report import Row, Section  # noqa: E402

from hefting.core.accuracy import errors_between  # noqa: E402

PARTIES = {party.name: party for party in parties()}
PEERS = [name for name, party in PARTIES.items() if party.peer]


@cache
def answer(name, recorded):
    party = PARTIES[name]
    return party.identify(recorded.task, party.prepare(recorded.task))


@pytest.fixture(scope="module")
def noisy():
    return random_tool("hammer", 1, 150)


@pytest.fixture(scope="module")
def exact():
    return random_tool("drill", 2, 150, noisy=False)


@pytest.fixture(scope="module")
def quick_run(tmp_path_factory):
    """What was printed and said, the JSON and the figure of a quick run, in this
    process: what it loads is loaded already."""
    folder = tmp_path_factory.mktemp("against")
    words = ("--quick", "--json", folder / "a.json", "--figure", folder / "a.svg")
    with (
        pytest.MonkeyPatch.context() as monkeypatch,
        redirect_stdout(StringIO()) as out,
        redirect_stderr(StringIO()) as err,
    ):
        monkeypatch.setenv("HEFTING_DATA", "")
        for library in ("OMP", "OPENBLAS", "MKL", "RAYON"):
            monkeypatch.setenv(f"{library}_NUM_THREADS", "1")  # as it sets them
        monkeypatch.setattr(sys, "argv", ["against", *map(str, words)])
        importlib.import_module("benchmarks.against.__main__").main()
    values = json.loads((folder / "a.json").read_text())
    return out.getvalue(), err.getvalue(), values, (folder / "a.svg").read_text()


# the parties


@pytest.mark.parametrize(
    "name", [n for n in PEERS if not any(m in n for m in ("PMD", "GEO", "mass and"))]
)
def test_peers_without_a_prior_find_the_body_of_exact_measurements(name, exact):
    """In percent. Least squares are exact but for rounding; conic solvers stop at
    1e-8 of objectives that are squares, mujoco.sysid at steps of 1e-5."""
    tolerance = 1e-6 if "lstsq" in name else 0.3
    assert max(exact.errors(answer(name, exact).body)) < tolerance


@pytest.mark.parametrize("name", [name for name in PEERS if "sysid" not in name])
def test_peers_solve_the_problem_of_the_method_beside_them(name, noisy):
    """Differences in percent of mass, size and inertia: an objective to 1e-8 leaves
    1e-4 of what it is flat in, which the inertia is at 1 rad/s."""
    theirs = answer(name, noisy).body
    ours = answer(PARTIES[name].beside, noisy).body
    apart = errors_between(theirs, ours, noisy.extents, noisy.axes)
    assert apart.mass < 0.01
    assert apart.center_of_mass < 0.01
    assert apart.inertia_at_origin < 0.5


def test_mujoco_has_the_inertia_of_the_shape_or_that_of_least_squares(noisy):
    """The first scales the inertia of the shape; the second explains the wrench as
    least squares over all bodies does, but for its bounds."""
    four = answer("mujoco.sysid, mass and COM", noisy).body
    even = noisy.task.shape.homogeneous
    np.testing.assert_allclose(
        four.inertia_at_com / four.mass, even.inertia_at_com, rtol=1e-9, atol=1e-12
    )
    ten = answer("mujoco.sysid, ten parameters", noisy).body
    lmi = answer(f"Hefting LMI{BARE}", noisy).body
    apart = errors_between(ten, lmi, noisy.extents, noisy.axes)
    # an eighth of the bound's box at most; standard deviations are 0.2 %
    assert apart.mass < 0.05
    assert apart.center_of_mass < 0.2


def test_only_some_numbers_have_intervals(noisy):
    said = {name: answer(name, noisy) for name in PEERS}
    intervals = {n: a for n, a in said.items() if a.low is not None}
    assert set(intervals) == {name for name in PEERS if "sysid" in name}
    known = {name: np.isfinite(a.low).sum() for name, a in intervals.items()}
    assert known["mujoco.sysid, mass and COM"] == 4
    assert known["mujoco.sysid, ten parameters"] == 10


def test_the_motion_of_the_peers_is_not_marked_with_its_noise(noisy):
    """What only Hefting could read is told to all of them as the task's noise."""
    z = noisy.task.z
    assert z.noise is None
    assert z.motion_noise is None
    assert z.weights is None


# what is said of them


def test_answers_are_put_beside_the_truth(exact):
    """Of two recordings one is answered, with the truth, and one interval that holds
    it."""
    none = np.full(10, np.nan)
    low, high = none.copy(), none.copy()
    low[0], high[0] = 0.0, 2.0 * exact.truth.mass
    outcome = Outcome(Party("a", lambda task, _: None))
    outcome.judge(Answer(exact.truth, low, high), exact)
    outcome.judge(None, exact)
    outcome.records = [(1.0, 1.0, None), (3.0, 3.0, None)]
    said = outcome.to_dict()
    assert said["unanswered"] == 1
    assert said["consistent"] == 50.0
    assert said["held"] == 100.0
    assert said["intervals"] == 1
    assert said["seconds"] == 2.0
    assert said["errors"]["mass"] is None  # the median of nothing and infinity


def test_a_solver_that_fails_is_counted(noisy):
    def fails(task, _):
        raise NoAnswerError("no")

    (outcome,) = measured([Party("fails", fails, calls=2)], [noisy])
    assert outcome.to_dict()["unanswered"] == 1
    assert len(outcome.records) == 2


def test_goals_say_what_is_missed():
    section = Section(
        "against peers, tools, 150 samples",
        (
            Row("peer"),
            Row("  ours", figure=99.0, unit="x", at_least=100.0),
            Row("error", figure=0.5, unit="of best", at_most=1.0),
        ),
    )
    found = goals([section])
    assert [goal["met"] for goal in found] == [False, True]
    by_set, of_cost = tables.goals({"goals": found})
    assert by_set.columns[2:] == ("tools, 150 samples",)
    assert by_set.rows == (
        ("ours, against peer", "≥ 100", "99 **missed**"),
        ("error", "≤ 1", "0.5"),
    )
    assert of_cost.rows == ()


def test_the_slope_is_that_of_the_last_decade():
    curve = {"at": [10, 100, 1000], "seconds": [5.0, 1.0, 10.0**1.5]}
    assert slope(curve) == pytest.approx(1.5)


def test_versions_that_differ_from_the_locked_are_told():
    pinned = versions.locked()
    assert set(pinned) == set(versions.PEERS)
    assert versions.differences(pinned, pinned) == []
    (line,) = versions.differences(pinned | {"mujoco": "0.1"}, pinned)
    assert "mujoco is 0.1" in line
    assert pinned["mujoco"] in line


def test_ratios_of_peers_are_kept_in_place_of_the_earlier_ones():
    before = {"f": {"peers, a": 1.0, "PMD": 2.0}, "s": {"peers, b": 3.0}}
    now = {"f": {"peers, c": 4.0}, "s": {}}
    assert replaced(before, now) == {"f": {"PMD": 2.0, "peers, c": 4.0}, "s": {}}


# the command


def test_a_quick_run_compares_all(quick_run):
    out, err, values, picture = quick_run
    names = [each["party"] for each in values["sets"][0]["parties"]]
    assert names == list(PARTIES)
    assert values["versions"] == {name: version(name) for name in versions.PEERS}
    for line in versions.differences():
        assert line in err
    for name in PEERS:
        assert name in out
    assert {row["source"] for row in values["published"]} == {
        "published",
        "warm",
        "cold",
    }
    assert set(values["cost"]) == {"samples", "points", "recordings"}
    assert picture.startswith("<?xml")


def test_a_quick_run_is_not_kept():
    """Said by a process of its own, before anything is loaded."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.against", "--quick", "--keep"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "a quick run is not kept" in done.stderr

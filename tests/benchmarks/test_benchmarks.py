"""The benchmarks run, print their table, and find Hefting faster than what one would
use instead."""

import ast
import importlib
import json
import re
import runpy
import sys
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from benchmarks.__main__ import every  # noqa: E402
from benchmarks.against.__main__ import PART  # noqa: E402
from benchmarks.parties import NOW, MissingError, before  # noqa: E402
from benchmarks.report import Row, Section  # noqa: E402

from benchmarks import ratios  # noqa: E402


@contextmanager
def started(module, *arguments):
    """As if Python had been started with a benchmark, without others' recordings, to be
    quick."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("HEFTING_DATA", "")
        for library in ("OMP", "OPENBLAS", "MKL", "RAYON"):
            patch.setenv(f"{library}_NUM_THREADS", "1")  # as it would for good
        patch.setattr(sys, "argv", [module, *map(str, arguments)])
        yield importlib.import_module(module).main


@pytest.fixture
def run_here(capsys):
    """Run a benchmark in this process: what it exits with, standard output, standard
    error."""

    def run_here(module, *arguments):
        status = 0
        try:
            with started(module, *arguments) as main:
                main()
        except SystemExit as stop:
            status = stop.code or 0
        return status, *capsys.readouterr()

    return run_here


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("benchmarks")


STAND_IN = """
from dataclasses import dataclass
from unittest.mock import MagicMock

@dataclass
class PMD:
    shape: object
    def start(self): pass
    def update(self, state, samples): pass
    def estimate(self, state, start=None): pass

def __getattr__(name):
    return MagicMock()
"""
"""In place of the code before: has the names that are asked of it and does nothing, so
that every process of it is over sooner than ours, which tells which of them is which.
"""


@pytest.fixture(scope="module")
def stand_in(folder):
    """A checkout of a package that does nothing."""
    package = folder / "stand-in" / "src" / "hefting"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text(STAND_IN)
    (package / "simulation.py").write_text(STAND_IN)
    (package / "__main__.py").write_text("")
    return folder / "stand-in"


@pytest.fixture(scope="module")
def quick_run(folder, stand_in):
    """Printed table and JSON report of one quick run, which keeps its ratios."""
    for module in ("cvxpy", "clarabel", "pinocchio"):
        pytest.importorskip(module, reason=f"{module} is not installed")
    file, kept = folder / "report.json", folder / "ratios.json"
    words = ["--quick", "--json", file, "--ratios", kept, "--keep"]
    table = StringIO()
    with (
        started("benchmarks.__main__", *words, "--before", stand_in) as main,
        redirect_stdout(table),
    ):
        main()
    return table.getvalue(), json.loads(file.read_text())


def rows(report: dict, title: str) -> list[dict]:
    found = [
        row
        for section in report["sections"]
        if title in section["title"]
        for row in section["rows"]
    ]
    assert found, f"no section '{title}'"
    return found


PARTS = {"long_recording", "memory", "peers"}
"""Run by other benchmarks, as processes of their own."""


def test_every_benchmark_has_help():
    files = (ROOT / "benchmarks").glob("*.py")
    scripts = {f.stem: f.read_text() for f in files if "__main__" in f.read_text()}
    asks = ("ArgumentParser", "asked(")
    silent = {
        name for name, text in scripts.items() if not any(word in text for word in asks)
    }
    assert silent == PARTS


OURS = {path.stem: path for path in (ROOT / "tests").rglob("*.py")}


def names_in(module: str) -> tuple[Path, set[str]] | None:
    """File of a module of the library, the benchmarks or the tests, and the names that
    are bound at its top; None for others."""
    below = (
        ROOT
        / ("src" if module.startswith("hefting") else "")
        / module.replace(".", "/")
    )
    places = (below.with_suffix(".py"), below / "__init__.py", OURS.get(module))
    file = next((p for p in places if p is not None and p.is_file()), None)
    if file is None:
        return None
    bound = (
        {path.stem for path in file.parent.iterdir()}
        if file.stem == "__init__"
        else set()
    )
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            bound.add(node.name)
        elif isinstance(node, ast.alias):
            bound.add(node.asname or node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            bound.add(node.id)
    return file, bound


def test_what_benchmarks_import_is_there():
    """Also within functions, which no other test may call, and from the tests' folders
    that a benchmark makes importable."""
    known, missing = {}, []
    for script in sorted((ROOT / "benchmarks").rglob("*.py")):
        text = script.read_text()
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.ImportFrom):
                continue
            module = str(node.module)
            if module not in known:
                known[module] = names_in(module)
            if known[module] is None:
                if module.partition(".")[0] in ("hefting", "benchmarks"):
                    missing.append(f"{script.name}: {module}")
                continue
            file, bound = known[module]
            folder = (
                file.parent.relative_to(ROOT / "tests").name if module in OURS else ""
            )
            if folder and f'"{folder}"' not in text:
                missing.append(f"{script.name}: {module}, in {folder}")
            lazy = (
                dir(importlib.import_module(module)) if "__getattr__" in bound else ()
            )
            missing += [
                f"{script.name}: {module}.{each.name}"
                for each in node.names
                if each.name not in bound and each.name not in lazy
            ]
    assert missing == ["problem.py: hefting.PointMasses"]  # of the code before


def test_every_section_is_printed(quick_run):
    table, report = quick_run
    assert len(report["sections"]) == 29
    for section in report["sections"]:
        assert section["title"].split(",")[0] in table
        for row in section["rows"]:
            assert row["seconds"] is not None or row["figure"] is not None


def test_ratios_are_above_one(quick_run):
    """Hundreds against the conic solver, about ten against Pinocchio: 1 leaves room for
    a busy machine."""
    _, report = quick_run
    every = [row for section in report["sections"] for row in section["rows"]]
    ratios = [row["figure"] for row in every if row["unit"] == "x"]
    assert len(ratios) == 29
    assert min(ratios) > 1.0


def test_both_parties_solve_the_same_problem(quick_run):
    """Equal to Clarabel's default tolerance of 1e-8, with room; Hefting's own is 1e-7
    at the worst."""
    _, report = quick_run
    differences = [
        row["figure"]
        for row in rows(report, "150 samples")
        if "difference" in row["what"]
    ]
    assert abs(differences[0]) < 1e-6
    parameters = next(row for row in rows(report, "OLS") if "difference" in row["what"])
    assert parameters["figure"] < 1e-9  # both are exact least squares: rounding alone


@pytest.mark.parametrize(
    "title", ["GEO, known noise, 1,000", "GEO, unknown noise, 1,000", "LMI, constraint"]
)
def test_geo_and_lmi_solve_the_problem_as_stated(quick_run, title):
    """Clarabel's default tolerance is 1e-8, relative to the objective; both do better
    than 1e-8 here."""
    _, report = quick_run
    differences = [
        row["figure"] for row in rows(report, title) if "difference" in row["what"]
    ]
    assert differences
    assert max(differences) < 1e-6


def test_the_constraint_of_lmi_is_active_where_it_is_said_to_be(quick_run):
    _, report = quick_run
    for title, sign in (
        ("constraint active, 1,000", -1.0),
        ("constraint inactive", 1.0),
    ):
        margin = next(
            row["figure"] for row in rows(report, title) if "margin" in row["what"]
        )
        assert sign * margin > 0.0


def test_peers_are_a_part_of_whole_runs(folder):
    """Their quick run is a command of its own."""
    assert PART in dict(every(folder, ROOT, quick=False))
    assert PART not in dict(every(folder, ROOT, quick=True))


def test_memory_does_not_grow(quick_run):
    """A copy of the samples would take 34 MB here: 200,000 of 21 doubles."""
    _, report = quick_run
    rise = next(row for row in rows(report, "Folding") if row["unit"] == "MiB")
    assert rise["figure"] < 8.0


def test_a_long_recording_takes_bounded_memory(quick_run):
    """20,000 rows take 130 MiB, 50,000 take 155, and the process alone some 100; room
    for other libraries."""
    _, report = quick_run
    found = {
        row["what"]: row["figure"] for row in rows(report, "poses and wrench as CSV")
    }
    assert found["peak memory"] < 200.0
    assert found["error of the mass"] < 0.1  # ten times its standard deviation


def test_whole_processes_are_compared(quick_run, folder):
    """With code that does nothing, in place of the code before, so that ours takes more
    of everything; without others' recordings."""
    kept = ratios.read(folder / "ratios.json", quick=True)
    shares = kept[ratios.SHARE]
    assert {name.rpartition("/")[2] for name in shares} == {
        "before",
        "before's second",
        "1 kg",
    }
    assert len(shares) == 9
    assert all(np.isfinite(share) and share > 0.0 for share in shares.values())
    # the others are one of ours over another, and a step of 0.3 ms
    ours = {name for name in shares if name.endswith(("/before", "/before's second"))}
    ours -= {"second identify, demo, its mesh/before", "one streamed sample/before"}
    assert len(ours) == 6
    assert min(shares[name] for name in ours) > 1.0
    assert (
        shares["second identify, demo, its mesh/before"]
        < shares["identify, demo, its mesh/before"]
    )


def test_ratios_are_kept_under_stable_names(quick_run, folder):
    """Every "x" of the report; the number of points is not in the name, which the
    shapes decide."""
    _, report = quick_run
    faster = ratios.read(folder / "ratios.json", quick=True)[ratios.FASTER]
    assert len(faster) == sum(
        row["unit"] == "x" for section in report["sections"] for row in section["rows"]
    )
    assert (
        "PMD, 150 samples, Hefting, from the moments, against Clarabel itself" in faster
    )
    # of the full setting
    assert not ratios.read(folder / "ratios.json", quick=False)[ratios.FASTER]


@pytest.mark.parametrize(
    ("factor", "names"), [(1.29, set()), (1.31, {"a/b", "S, ours"})]
)
def test_a_ratio_that_is_worse_by_a_third_fails(factor, names):
    kept = ratios.ratios_of(
        [
            Section(
                "S", (Row("share", figure=0.5, unit="of b", name="a/b"), speedup(8.0))
            )
        ]
    )
    worse = [
        Section(
            "S",
            (
                Row("share", figure=0.5 * factor, unit="of b", name="a/b"),
                speedup(8.0 / factor),
            ),
        )
    ]
    assert {
        change.name for change in ratios.failures(kept, ratios.ratios_of(worse))
    } == names
    assert not ratios.failures(ratios.ratios_of(worse), kept)  # better is no failure
    best = ratios.better(ratios.ratios_of(worse), kept)
    assert not ratios.failures(kept, best)  # it was worse once only


def speedup(figure):
    return Row("ours", figure=figure, unit="x")


def test_a_ratio_that_is_not_measured_does_not_fail():
    kept = ratios.ratios_of([Section("S", (speedup(8.0),))])
    assert not ratios.failures(kept, ratios.ratios_of([]))
    assert not ratios.failures(ratios.ratios_of([]), kept)


def test_two_ratios_of_one_name_are_refused():
    with pytest.raises(ValueError, match="two ratios"):
        ratios.ratios_of([Section("S", (speedup(8.0), speedup(9.0)))])


def test_the_command_ends_with_an_error_that_names_what_is_worse(tmp_path, run_here):
    """OLS about ten times as fast as Pinocchio; said to have been a million times."""
    pytest.importorskip("pinocchio", reason="pinocchio is not installed")
    pytest.importorskip("cvxpy", reason="cvxpy is not installed")
    name = "OLS, 1,000 samples, Hefting: OLS().fit(Measurements(...))"
    file = tmp_path / "ratios.json"
    ratios.keep(file, True, {ratios.FASTER: {name: 1e6}, ratios.SHARE: {}})
    words = ("--quick", "--only", "OLS", "--ratios", file)
    status, _, err = run_here("benchmarks.__main__", *words)
    assert isinstance(status, str)  # printed by Python, which then ends with 1
    assert name in status
    assert "OLS, once more" in err
    ratios.keep(file, True, {ratios.FASTER: {name: 1e-3}, ratios.SHARE: {}})
    assert run_here("benchmarks.__main__", *words)[0] == 0


def test_the_code_before_is_taken_from_the_history(tmp_path):
    try:
        party = before(tmp_path / "before")
    except MissingError as missing:
        pytest.skip(str(missing))
    party.warm_up()  # it is that code which runs
    assert (party.source / "hefting" / "identification.py").is_file()


def test_a_checkout_without_the_package_is_refused(tmp_path):
    with pytest.raises(MissingError, match="holds no src/hefting"):
        before(tmp_path, tmp_path)


def test_what_a_process_takes():
    """A tenth of a second of work, and 80 MiB; the memory of this process does not
    count."""
    held = np.ones(30_000_000)  # 240 MB here
    work = "x = b'1' * (80 << 20)\nimport time\nwhile time.process_time() < 0.1: pass\nprint('done')"
    took = NOW.run("-S", "-c", work)
    assert took.said.strip() == "done"
    assert 0.1 <= took.cpu < 10.0
    assert 80 << 20 <= took.peak < 160 << 20
    assert held.size
    with pytest.raises(RuntimeError, match="no such thing"):
        NOW.run("-c", "raise SystemExit('no such thing')")


def test_the_naive_script_finds_a_mass(tmp_path, monkeypatch, capsys):
    """An honest rival: exact motion and wrench, so it must be right but for what
    smoothing takes."""
    for module in ("pandas", "pinocchio"):
        pytest.importorskip(module, reason=f"{module} is not installed")
    from hefting import write_log
    from hefting.simulation import UR5, hammer, random_smooth, simulate

    body = hammer().parameters
    recording = simulate(
        UR5.motion(random_smooth(6.0, 200.0, 1.0, seed=3)), body, pose_noise=(0.0, 0.0)
    )
    write_log(recording, tmp_path / "log.csv")
    words = ["naive.py", str(tmp_path / "log.csv"), "--gravity", "0,0,-9.80665"]
    monkeypatch.setattr(sys, "argv", words)
    runpy.run_path(str(ROOT / "benchmarks" / "naive.py"), run_name="__main__")
    mass = float(capsys.readouterr().out.split()[1])
    assert mass == pytest.approx(body.mass, rel=2e-3)


def test_two_versions_are_put_side_by_side(tmp_path, run_here):
    """Of the same code nothing differs; a COM moved by a standard deviation, a sign and
    an error are told."""
    a, b = tmp_path / "a.jsonl", tmp_path / "b.jsonl"
    status, _, err = run_here("benchmarks.same_answers", "--write", a, "--simulated", 2)
    assert status == 0, err
    status, out, err = run_here("benchmarks.same_answers", "--compare", a, a)
    assert status == 0, err
    assert "0 of 4 beyond" in out
    answers = [json.loads(line) for line in a.read_text().splitlines()]
    answers[0]["center_of_mass"][1] += answers[0]["std"]["center_of_mass"][1]
    answers[1]["provenance"]["wrench"] = "on-sensor"
    answers[2] = {
        key: answers[2][key] for key in ("name", "method", "groups", "seconds")
    } | {"error": "it fell"}
    b.write_text("\n".join(map(json.dumps, answers)))
    status, out, _ = run_here("benchmarks.same_answers", "--compare", a, b)
    assert status == 1
    assert "3 of 4 beyond" in out
    assert "COM 1," in out
    assert "it fell" in out
    assert "changed: sign" in out


def test_an_identification_that_is_not_the_first_is_timed_by_stage(run_here):
    """Each stage names a function that runs."""
    words = ("--recordings", 1, "--repeats", 1)
    status, out, err = run_here("benchmarks.warm", *words)
    assert status == 0, err
    *_, last = out.splitlines()
    assert min(float(number) for number in re.findall(r"\d+\.\d+", last)) > 0.0

"""Bad input of the command line: one line, exit status 2, and no file left behind."""

import json
import os

import pytest

from commands import refused
from hammer_log import edited, log_folder, shape_options

pytestmark = pytest.mark.usefixtures("same_commands")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return log_folder(tmp_path_factory)


def test_usage_errors(run, folder):
    assert refused(run("identify"), "LOG")
    assert refused(run(), "COMMAND")
    assert refused(run("identify", folder / "log.csv", "--sha", "x"), "--sha")
    assert refused(run("idenify", folder / "log.csv"), "identify")
    assert refused(run("identify", folder / "log.csv", "--points", "many"), "--points")
    assert refused(run("identify", folder / "none.csv"), "none.csv", "does not exist")
    assert refused(run("identify", folder / "log.csv", "--method", "pdm"), "PMD")
    assert refused(run("identify", folder / "log.csv", "--gravity", "0,0"), "--gravity")
    for size in ("0,0,-1", "0,0,-981"):
        said = run("identify", folder / "log.csv", "--gravity", size)
        assert refused(said, "no place where robots hold things", "0,0,-9.81")
    for box in (("--box", "100,450,150"), ("--shape", "box:0,100,0,450,0,150")):
        assert refused(run("identify", folder / "log.csv", *box), "give it in metres")
    assert refused(run("identify", folder / "log.csv", "--bias", "tare:1"), "tare")
    backwards = run("identify", folder / "log.csv", "--bias", "tare:2,1")
    assert refused(backwards, "--bias", "ends before it begins")
    for option in ("--tool", "--truth", "--object-pose"):
        for empty in ((option, ""), (f"{option}=",)):
            said = run("identify", folder / "log.csv", *empty)
            assert refused(said, f"{option}: its value is missing")
    assert refused(run("identify", folder / "log.csv", "--wrench", "up"), "on-sensor")
    assert refused(run("identify", folder / "log.csv", "--motion", "up"), "smooth")
    assert refused(run("identify", folder / "log.csv", "--shape", ""), "shape")
    assert refused(
        run("identify", folder / "log.csv", "--shape", "box:0,1e9,0,1,0,1"), "box"
    )
    assert refused(
        run("identify", folder / "log.csv", "--method", "OLS", "--c1", "3"), "c1"
    )
    assert refused(
        run("export", folder / "truth.json", "--to", "urdf"), "truth.json", "estimate"
    )


def test_a_folder_that_cannot_be_written_is_told_at_once(run, folder, monkeypatch):
    """Before a search or an identification, whose result would be lost."""
    monkeypatch.setattr("os.access", lambda *_: False)
    output = ("--output", folder / "a.json")
    plan = ("plan", "--urdf", "none.urdf", "--tip", "a", *output)
    for words in (("identify", "none.csv", *output), plan):
        assert refused(run(*words), "a.json: the folder cannot be written")


def cell(lines, row, column, text):
    """`lines` with one cell replaced; `row` counts from the header as 1."""
    names = lines[0].split(",")
    cells = lines[row - 1].split(",")
    cells[names.index(column)] = text
    return [*lines[: row - 1], ",".join(cells), *lines[row:]]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda n: [n[0].replace("fy", "fyy"), *n[1:]], ["fy", "fyy"]),
        (lambda n: cell(n, 7, "tz", "inf"), ["row 7", "tz"]),
        (lambda n: cell(n, 9, "time", "0"), ["row 9", "time"]),
        (
            lambda n: [*n[:8], *[n[8], cell(n, 9, "fx", "99")[8]] * len(n), *n[9:]],
            ["row 10", "time"],
        ),
        (lambda n: n[:1], ["no samples"]),
        (lambda n: n[:4], ["poses are too few"]),
        (lambda n: cell(n, 4, "px", "abc"), ["row 4", "px"]),
    ],
    ids=[
        "misspelt",
        "infinity",
        "unsorted",
        "repeated",
        "empty",
        "three samples",
        "text",
    ],
)
def test_bad_logs(run, folder, tmp_path, change, words):
    path = edited(folder, tmp_path, change)
    out = tmp_path / "out.json"
    assert refused(
        run("identify", path, *shape_options(folder), "--output", out),
        "bad.csv",
        *words,
    )
    assert not out.exists()


@pytest.mark.parametrize(
    ("row", "column", "text", "words"),
    [
        (7, "fx", "NaN", "left out 1 of 500 rows (the first: row 7)"),
        (5, "qw", "3", "left out 1 of 500 poses (the first: row 5)"),
    ],
)
def test_a_sample_that_is_none_is_left_out_and_told(
    run, folder, tmp_path, row, column, text, words
):
    path = edited(folder, tmp_path, lambda n: cell(n, row, column, text))
    status, said, _ = run("inspect", path)
    assert status == 0
    assert words in " ".join(said.split())


def test_an_input_is_never_overwritten(run, folder, tmp_path):
    log = tmp_path / "log.csv"
    log.write_bytes((folder / "log.csv").read_bytes())
    assert refused(
        run("identify", log, *shape_options(folder), "--output", log),
        "log.csv",
        "input",
    )
    assert log.read_bytes() == (folder / "log.csv").read_bytes()


def test_hostile_json(run, folder, tmp_path):
    for number, content in enumerate(
        (
            "[" * 100_000,
            '{"bias": [1' + "0" * 5000 + "]}",
            '{"mass": 0}',
            "[1]",
            "3",
            "",
        )
    ):
        path = tmp_path / f"{number}.json"
        path.write_text(content)
        for option in ("--bias", "--truth", "--box 0.1,0.1,0.1 --object-pose"):
            words = option.split()
            assert refused(run("identify", folder / "log.csv", *words, path), path.name)
        assert refused(run("export", path, "--to", "urdf"), path.name)


ABOUT_SHAPES = {
    "--unit": "mm",
    "--object-pose": "0,0,0.1",
    "--pose-std": "1mm,1deg",
    "--shape-std": "5%",
    "--points": "99",
}


@pytest.mark.parametrize(("option", "value"), ABOUT_SHAPES.items())
def test_what_is_said_of_a_shape_that_is_not_given_is_refused(
    run, folder, option, value
):
    given = "identify", folder / "log.csv", option, value
    assert refused(run(*given), f"{option}: there is no shape", "--box")
    if option in ("--object-pose", "--points"):
        assert run(*given, "--box", "0.3,0.3,0.6")[0] == 0


@pytest.mark.parametrize(
    ("command", "options"),
    [
        (("export", "a.json", "--to", "urdf"), ("--unit", "--object-pose")),
        (("plan", "--urdf", "a", "--tip", "b"), ("--unit", "--object-pose")),
        (("convert", "a.csv", "a.mcap", "--with", "a.json"), ("--unit",)),
        (("view", "a.csv"), ("--unit", "--object-pose", "--pose-std", "--points")),
        (("live", "a.csv"), ("--unit", "--object-pose", "--pose-std", "--points")),
        (
            ("batch", "a.csv", "--output", "b"),
            ("--unit", "--object-pose", "--pose-std", "--points"),
        ),
    ],
)
def test_so_is_it_by_every_command_that_takes_a_shape(
    run, tmp_path, monkeypatch, command, options
):
    """Before any file is read."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("no log")
    for option in options:
        result = run(*command, option, ABOUT_SHAPES[option])
        fix = "give --shape FILE or --box X,Y,Z"
        assert refused(result, f"{option}: there is no shape", fix)


def test_shapes_that_cannot_be(run, folder, tmp_path):
    log = folder / "log.csv"
    assert refused(
        run("identify", log, "--shape", folder / "mesh.stl"),
        "m long",
        "its --unit cm",
        "or mm (0.",
    )
    (tmp_path / "empty.stl").write_bytes(b"")
    assert refused(run("identify", log, "--shape", tmp_path / "empty.stl"), "empty.stl")
    (tmp_path / "page.stl").write_text("<html>not here</html>")
    assert refused(run("identify", log, "--shape", tmp_path / "page.stl"), "page.stl")
    assert refused(run("identify", log, "--shape", "box:0,1,2"), "box")
    away = ["--object-pose", "2,0,0,0,0,0,1"]
    mesh = ("--shape", folder / "mesh.stl", "--unit", "mm", *away)
    for method in ("Bayes", "PMD"):
        _, out, _ = run("identify", log, *mesh, "--method", method, "--json")
        warnings = " ".join(json.loads(out)["warnings"])
        assert "away from the sensor" in warnings
        assert "check the shape's pose" in warnings
    assert refused(
        run(
            "identify",
            log,
            *shape_options(folder)[:4],
            "--object-pose",
            "0,0,0,1,1,0,0",
        ),
        "norm",
        "quaternion",
    )


def test_nothing_is_left_half_written(run, folder, tmp_path):
    out = tmp_path / "there.json"
    out.write_text("old")
    run("identify", folder / "log.csv", "--shape", folder / "none.stl", "--output", out)
    assert out.read_text() == "old"
    assert refused(
        run("identify", folder / "log.csv", "--output", tmp_path / "no" / "a.json"),
        "folder",
    )
    assert refused(
        run("identify", folder / "log.csv", "--output", tmp_path / "a.xyz"), ".xyz"
    )
    assert os.listdir(tmp_path) == ["there.json"]

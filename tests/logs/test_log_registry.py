"""The registry of log formats: one file and one line make a format known everywhere,
and the shipped ones fit it."""

import json
import subprocess
import sys

import numpy as np
import pytest

from commands import refused
from hefting.core.errors import InputError
from hefting.core.recording import Recording, Stream
from hefting.logs import check_output, formats, read_log, write_log
from hefting.logs.registry import MODULES, Format, find_format
from log_files import ROWS, fails, log, random_recording, same

TOY = '''
"""Streams of numbers in JSON."""

import json
from pathlib import Path

from hefting.core.recording import Recording, Stream
from hefting.logs.registry import Format


def read_toy(path, toy_sign="+", wrench_needed=True):
    """Recording in a toy log."""
    streams = json.loads(Path(path).read_text())
    if toy_sign == "-":
        streams["wrench"][1] = [[-value for value in row] for row in streams["wrench"][1]]
    return Recording({name: Stream(*parts) for name, parts in streams.items()}, source=str(path))


def write_toy(recording, path):
    """Write a toy log, which holds no accelerometer."""
    kept = {name: stream for name, stream in recording.streams.items() if name != "accelerometer"}
    streams = {name: (stream.time.tolist(), stream.values.tolist()) for name, stream in kept.items()}
    Path(path).write_text(json.dumps(streams))
    return tuple(name for name in recording.streams if name not in kept)


FORMAT = Format(
    name="toy",
    description="a toy",
    suffixes=(".toy", ".plaything"),
    help_names=(".toy",),
    read=read_toy,
    options={"toy_sign": ("+|-", "of a toy: sign of the wrench")},
    written=(".toy",),
    write=write_toy,
)
'''
"""A format that reads everything itself."""

TABLE = '''
"""CSV with its lines in reverse order."""

from pathlib import Path

from hefting.logs.csv_file import open_csv, write_csv
from hefting.logs.registry import Format


def reverse(path):
    """Turn the order of the lines in a file."""
    Path(path).write_text("".join(reversed(Path(path).read_text().splitlines(keepends=True))))


def open_reversed(path, layout=None):
    """The table in a file whose last line is the header."""
    turned = Path(path).with_suffix(".turned")
    turned.write_bytes(Path(path).read_bytes())
    reverse(turned)
    return open_csv(turned, layout)


def write_reversed(recording, path):
    """Write a table from its end."""
    lost = write_csv(recording, path)
    reverse(path)
    return lost


FORMAT = Format(
    name="Reversed",
    description="a table",
    suffixes=(".vsc",),
    help_names=(".vsc",),
    open_table=open_reversed,
    written=(".vsc",),
    write=write_reversed,
)
'''
"""A format whose files have named columns."""


def add_format(monkeypatch, folder, name, text):
    """Write the format's file, and its line into the registry; yield, and remove
    both."""
    (folder / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setattr("hefting.logs.registry.MODULES", (*MODULES, name))
    yield
    sys.modules.pop(name, None)


@pytest.fixture
def toy(monkeypatch, tmp_path):
    """The format that reads everything itself."""
    yield from add_format(monkeypatch, tmp_path, "toy_log", TOY)


@pytest.fixture
def table(monkeypatch, tmp_path):
    """The format with named columns."""
    yield from add_format(monkeypatch, tmp_path, "reversed_log", TABLE)


def swinging() -> Recording:
    """1 kg that is turned about x, of which the orientation alone is logged."""
    time = np.arange(400) / 100
    tilt, gravity = 0.8 * np.sin(2 * time), np.array((0.0, 0.0, -9.80665))
    zero = np.zeros_like(time)
    orientation = np.stack((np.sin(tilt / 2), zero, zero, np.cos(tilt / 2)), axis=1)
    force = -gravity[2] * np.stack((zero, np.sin(tilt), np.cos(tilt)), axis=1)
    torque = np.cross((0.0, 0.01, 0.05), force)
    values = {
        "orientation": orientation,
        "wrench": np.hstack((force, torque)),
    }
    return Recording({name: Stream(time, array) for name, array in values.items()})


# A format that is added


@pytest.mark.usefixtures("toy")
def test_a_new_format_is_read_and_written(tmp_path):
    path, sent = tmp_path / "log.toy", random_recording(3)
    assert check_output(path) == ".toy"
    assert write_log(sent, path) == ("accelerometer",)
    got = read_log(path)
    for name, stream in got.streams.items():
        np.testing.assert_array_equal(stream.values, sent[name].values)
    np.testing.assert_array_equal(
        read_log(path, toy_sign="-")["wrench"].values, -sent["wrench"].values
    )
    assert find_format(path).name != "bag"
    path.rename(tmp_path / "log.plaything")
    assert read_log(tmp_path / "log.plaything").has("wrench")
    fails(tmp_path / "absent.toy", "cannot be read")
    fails(
        tmp_path / "log.plaything",
        "column map (`column_map`) is for CSV, Parquet, Arrow, NumPy, MATLAB and JSON lines",
        column_map="map.toml",
    )
    fails(tmp_path / "log.plaything", "`wrench_topic` is for bags", wrench_topic="/ft")
    fails(log(tmp_path, *ROWS), "`toy_sign` is for toys", toy_sign="-")


@pytest.mark.usefixtures("toy")
def test_errors_name_a_new_format(tmp_path):
    recording = random_recording(0)
    with pytest.raises(
        InputError, match=r"use \.csv, \.parquet, \.bag, \.mcap, \.toy, or no suffix"
    ):
        write_log(recording, tmp_path / "log.xlsx")
    with pytest.raises(InputError, match="type dict is no recording"):
        write_log({}, tmp_path / "log.csv")
    fails(
        log(tmp_path, *ROWS).rename(tmp_path / "log.doc"),
        ".db3, .toy, .plaything, or a bag's folder",
    )


@pytest.mark.usefixtures("toy")
@pytest.mark.parametrize(
    "command", ["inspect", "identify", "convert", "predict", "calibrate"]
)
def test_the_help_of_commands_names_a_new_format(run, command):
    words = " ".join(run(command, "--help")[1].split())
    assert (
        ": .csv, .parquet, .feather, .npz, .mat, .jsonl, ROS bag, .mcap or .toy; - reads"
        in words
    )
    assert "--toy-sign +|- of a toy: sign of the wrench" in words


@pytest.mark.usefixtures("toy")
def test_the_help_of_outputs_names_a_new_format(run):
    words = " ".join(run("convert", "--help")[1].split())
    assert (
        "canonical .csv or .parquet; a bag: .bag, .mcap, or no suffix for a folder; a toy: .toy"
        in words
    )
    words = " ".join(run("simulate", "--help")[1].split())
    assert "log: .csv, .parquet, .bag, .mcap, .toy, or no suffix for a folder" in words


@pytest.mark.usefixtures("toy")
def test_commands_take_a_new_format(run, tmp_path):
    path = tmp_path / "log.toy"
    write_log(swinging(), path)
    status, out, err = run("inspect", path, "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)
    status, out, err = run("identify", path, "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)
    assert refused(
        run("identify", path, "--toy-sign", "-", "--wrench", "on-object"),
        "check the wrench's sign",
    )
    assert run("convert", path, tmp_path / "log.csv")[0] == 0
    assert run("convert", tmp_path / "log.csv", tmp_path / "again.toy")[0] == 0
    assert same(read_log(tmp_path / "again.toy"), read_log(path))
    assert refused(
        run("inspect", tmp_path / "log.csv", "--toy-sign", "-"),
        "--toy-sign is for toys",
    )


@pytest.mark.usefixtures("table")
def test_a_new_table_takes_maps_and_all_headers(run, tmp_path):
    path, sent = tmp_path / "log.vsc", random_recording(1)
    assert write_log(sent, path) == ()
    assert same(read_log(path), sent)
    chosen = tmp_path / "map.toml"
    chosen.write_text(
        'orientation = ["qx", "qy", "qz", "qw"]\nwrench = ["fx", "fy", "fz", "tx", "ty", "tz"]\n'
    )
    assert set(read_log(path, chosen).streams) == {"orientation", "wrench"}
    names = [
        "timestamp",
        *(f"actual_TCP_pose_{i}" for i in range(6)),
        *(f"ft_raw_wrench_{i}" for i in range(6)),
    ]
    path.write_text(f"0.1,{'0,' * 11}2\n0,{'0,' * 11}1\n{','.join(names)}\n")
    assert "UR real-time record" in str(read_log(path).notes[0])
    fails(
        path.rename(tmp_path / "log.bag"),
        "is for CSV, Parquet, Arrow, NumPy, MATLAB, JSON lines and Reversed",
        column_map=chosen,
    )
    words = " ".join(run("convert", "--help")[1].split())
    assert "canonical .csv, .parquet or .vsc; a bag" in words
    assert (
        "which columns of a CSV, Parquet, Arrow, NumPy, MATLAB, JSON lines or Reversed hold what"
        in words
    )


# The formats there are


def test_an_added_format_is_gone_after_its_test(tmp_path):
    assert [each.name for each in formats()] == [
        "CSV",
        "Parquet",
        "Arrow",
        "NumPy",
        "MATLAB",
        "JSON lines",
        "UR real-time record",
        "bag",
    ]
    assert find_format(tmp_path / "log.toy") is None


@pytest.mark.parametrize("each", formats(), ids=lambda each: each.name)
def test_each_format_is_complete(each: Format):
    assert (
        sum(way is not None for way in (each.open_table, each.read_table, each.read))
        == 1
    )
    assert (each.read_table is None) == (each.is_header is None)
    assert bool(each.written) == (each.write is not None)
    assert ("" not in each.written) or each.folder
    assert set(each.options) == set() or each.read is not None
    assert all(
        suffix.startswith(".") and suffix == suffix.lower() for suffix in each.suffixes
    )


def test_no_two_formats_share_a_suffix():
    for endings in (
        [s for each in formats() for s in each.suffixes],
        [s for each in formats() for s in each.written],
    ):
        assert len(set(endings)) == len(endings)


def test_the_docstring_of_reading_names_every_suffix():
    rows = [
        line.strip().split("  ")[0] for line in (read_log.__doc__ or "").splitlines()
    ]
    for each in formats():
        names = [*each.suffixes, "or a folder"] if each.folder else each.suffixes
        assert not names or ", ".join(names) in rows
    assert "UR real-time record" in (read_log.__doc__ or "")


def test_the_registry_is_light():
    """What a format needs is imported when such a log is read or written."""
    code = (
        "import sys; from hefting.logs import formats; formats(); "
        "print(*{name.split('.')[0] for name in sys.modules}, 'hefting.logs.ros' in sys.modules)"
    )
    out = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout.split()
    assert not {"pyarrow", "rosbags", "scipy", "sqlite3", "pandas"} & set(out)
    assert out[-1] == "False"

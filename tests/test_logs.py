"""Canonical CSV and Parquet: exact round trips, and one clear line for each way a file can be wrong."""

import os
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hefting.errors import InputError
from hefting.logs import read_log, write_log
from hefting.recording import COLUMNS, JOINT_STREAMS, Recording, Stream

pa = pytest.importorskip("pyarrow")
from pyarrow import csv as pacsv  # noqa: E402
from pyarrow import parquet  # noqa: E402

HEADER = "time,qx,qy,qz,qw,fx,fy,fz,tx,ty,tz"
ROWS = ("0,0,0,0,1,1,2,3,4,5,6", "0.1,0,0,0,1,1,2,3,4,5,6", "0.2,0,0,0,-1,1,2,3,4,5,7")
SUFFIXES = (".csv", ".parquet")


def log(folder: Path, *lines: str, header: str = HEADER, end: str = "\n") -> Path:
    path = folder / "log.csv"
    path.write_bytes((end.join((header, *lines)) + end).encode())
    return path


def fails(path: Path, *words: str) -> None:
    """Reading gives one line that names the file and holds each of the words."""
    with pytest.raises(InputError) as caught:
        read_log(path)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    assert len(message) < 600
    for word in words:
        assert word in message, message


def random_recording(seed: int, static: bool = False, joints: int = 6) -> Recording:
    """All streams, each with its own irregular clock (static: all with the row's index)."""
    rng = np.random.default_rng(seed)
    streams = {}
    for name, columns in COLUMNS.items():
        count = 50 if static else int(rng.integers(1, 60))
        width = joints if name in JOINT_STREAMS else len(columns)
        values = rng.normal(size=(count, width)) * 10.0 ** rng.integers(-12, 12, (count, width))
        if name == "orientation":
            values /= np.linalg.norm(values, axis=1)[:, None]
        clock = np.arange(float(count)) if static else np.cumsum(rng.uniform(1e-4, 0.1, count))
        streams[name] = Stream(clock, values)
    return Recording(streams, static)


def same(a: Recording, b: Recording) -> bool:
    return (
        a.static == b.static
        and list(a.streams) == list(b.streams)
        and all(
            np.array_equal(a[name].time, b[name].time) and np.array_equal(a[name].values, b[name].values)
            for name in a.streams
        )
    )


# Reading and writing


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("static", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_round_trip_is_exact(tmp_path, suffix, static, seed):
    sent = random_recording(seed, static)
    path = tmp_path / f"log{suffix}"
    write_log(sent, path)
    got = read_log(path)
    assert same(got, sent)
    assert got.source == str(path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(st.floats(0, 100), *[finite] * 6), min_size=1, max_size=6, unique_by=lambda row: row[0]))
def test_any_floats_survive(tmp_path, suffix, samples):
    table = np.array(sorted(samples))
    pose = Stream(np.zeros(1), np.array([[0.0, 0.0, 0.0, 1.0]]))
    sent = Recording({"orientation": pose, "wrench": Stream(table[:, 0], table[:, 1:])})
    path = tmp_path / f"log{suffix}"
    write_log(sent, path)
    assert same(read_log(path), sent)


def test_streams_share_a_row_only_at_equal_times(tmp_path):
    path = log(
        tmp_path,
        "0,0,0,0,1,,,,,,",
        "0.1,,,,,1,2,3,4,5,6",
        "0.1,0,0,0,1,,,,,,",
        ",,,,,,,,,,",
        "0.2,0,0,0,1,1,2,3,4,5,6",
    )
    got = read_log(path)
    assert got["orientation"].time.tolist() == [0, 0.1, 0.2]
    assert got["orientation"].rows.tolist() == [2, 4, 6]
    assert got["wrench"].time.tolist() == [0.1, 0.2]
    assert got["wrench"].rows.tolist() == [3, 6]
    write_log(got, tmp_path / "again.csv")
    assert len((tmp_path / "again.csv").read_text().splitlines()) == 4
    assert same(read_log(tmp_path / "again.csv"), got)


def test_joints_may_stand_for_the_orientation(tmp_path):
    path = log(tmp_path, "0,1,2,1,2,3,4,5,6", header="time,q2,q1,fx,fy,fz,tx,ty,tz")
    got = read_log(path)
    assert got["joint_positions"].values.tolist() == [[2, 1]]
    assert not got.has("orientation")


def test_rows_without_time_are_static_poses(tmp_path):
    header = HEADER.removeprefix("time,")
    got = read_log(log(tmp_path, *(row.split(",", 1)[1] for row in ROWS), header=header))
    assert got.static
    assert got.warnings == ()
    assert got["wrench"].time.tolist() == [0, 1, 2]
    assert read_log(log(tmp_path, ROWS[0].split(",", 1)[1], header=header)).duration == 0
    moving = read_log(log(tmp_path, "0,0,0,1,1,2,3,4,5,6,0,0,1", header=header + ",gyro_x,gyro_y,gyro_z"))
    assert "static pose, although there is gyroscope" in moving.warnings[0]


def test_one_timed_sample_is_enough(tmp_path):
    got = read_log(log(tmp_path, ROWS[0]))
    assert not got.static
    assert got.duration == 0


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_separators_and_byte_order_mark(tmp_path, end, separator, mark):
    lines = [line.replace(",", separator) for line in ROWS]
    got = read_log(log(tmp_path, *lines, header=mark + HEADER.replace(",", separator), end=end))
    assert got["wrench"].values[2].tolist() == [1, 2, 3, 4, 5, 7]
    assert got["wrench"].rows.tolist() == [2, 3, 4]
    assert got["orientation"].values[2].tolist() == [0, 0, 0, -1]
    assert got.warnings == ()


def test_blanks_quotes_plus_signs_and_spaces_are_read(tmp_path):
    path = log(
        tmp_path,
        '"0", 0 ,0,0,+1,1e0,2.,3,4,5,6',
        '0.1,,"",  ,,1,2,3,4,5,6',
        header=HEADER.replace(",", ", "),
    )
    got = read_log(path)
    assert len(got["orientation"]) == 1
    assert got["wrench"].values[1].tolist() == [1, 2, 3, 4, 5, 6]


def test_the_last_line_needs_no_end(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("\n".join((HEADER, *ROWS)))
    assert len(read_log(path)["wrench"]) == 3


def test_the_suffix_may_be_in_capitals(tmp_path):
    path = log(tmp_path, *ROWS)
    assert len(read_log(path.rename(tmp_path / "LOG.CSV"))["wrench"]) == 3


# Rows


@pytest.mark.parametrize(
    ("before", "between", "row"),
    [("", "", 4), ("\n\n", "", 6), ("", "\n", 5), ("\n", "\n\n\n", 8), (" \n", "\n", 6)],
)
@pytest.mark.parametrize("bad", ["nan", "text", "inf"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_row_numbers_are_those_of_an_editor(tmp_path, before, between, row, bad, end):
    path = tmp_path / "log.csv"
    text = f"{before}{HEADER}\n{ROWS[0]}\n{between}{ROWS[1]}\n{ROWS[2].replace('7', bad)}\n"
    path.write_bytes(text.replace("\n", end).encode())
    fails(path, f"row {row}, column tz", bad)


def test_row_numbers_hold_far_into_a_large_file(tmp_path):
    lines = [f"{k / 1000},0,0,0,1,1,2,3,4,5,6" for k in range(60_000)]  # several of the parser's blocks
    lines[777:777] = [""]
    for bad in ("nan", "x"):
        lines[54_321] = f"{54.32},0,0,0,1,1,{bad},3,4,5,6"
        fails(log(tmp_path, *lines), "row 54323, column fy")
    lines[54_321] = "54.32,0,0,0,1,1,2"
    fails(log(tmp_path, *lines), "row 54323", "7 cells under 11 column names")


# What is refused


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("abc", ("'abc' is not a number", "leave the cell blank")),
        ("NA", ("'NA' is not a number",)),
        ("1.5.2", ("'1.5.2' is not a number",)),
        ("1_0", ("'1_0' is not a number",)),
        ("\x1b[31m", ("'\\x1b[31m' is not a number",)),
        ("nan", ("the value is nan", "leave the cell blank")),
        ("NaN", ("the value is nan",)),
        ("inf", ("the value is inf",)),
        ("-Infinity", ("the value is -inf",)),
        ("1e999", ("the value is inf",)),
        ("", ("the cell is blank", "fx fy fz tx ty tz")),
    ],
)
def test_bad_cells_are_named_by_row_and_column(tmp_path, cell, words):
    bad = f"0.1,0,0,0,1,1,{cell},3,4,5,6"
    fails(log(tmp_path, ROWS[0], bad, ROWS[2]), "row 3, column fy", *words)


def test_bad_times(tmp_path):
    fails(log(tmp_path, ROWS[0], "noon" + ROWS[1][3:]), "row 3, column time", "'noon'")
    fails(log(tmp_path, ROWS[0], ROWS[1][3:]), "row 3, column time", "time is blank")
    fails(log(tmp_path, ROWS[0], "nan" + ROWS[1][3:]), "row 3, column time", "nan")
    fails(log(tmp_path, ROWS[0], "inf" + ROWS[1][3:]), "row 3, column time", "inf")
    fails(log(tmp_path, *ROWS, ROWS[1]), "row 5", "0.1 s is before 0.2 s of row 4", "sort the rows")
    fails(log(tmp_path, *ROWS, ROWS[2]), "row 5", "repeats that of row 4", "keep one")


def test_decimal_commas_are_named(tmp_path):
    lines = [row.replace(",", ";").replace(".", ",") for row in ROWS]
    fails(log(tmp_path, *lines, header=HEADER.replace(",", ";")), "row 3, column time", "'0,1'", "with a point")


def test_quaternions(tmp_path):
    fails(log(tmp_path, ROWS[0], "0.1,0,0,0.5,1,1,2,3,4,5,6"), "row 3", "norm 1.118", "unit quaternions")
    fails(log(tmp_path, ROWS[0], "0.1,0,0,0,0,1,2,3,4,5,6"), "row 3", "norm 0")
    fails(log(tmp_path, ROWS[0], "0.1,0,,0,1,1,2,3,4,5,6"), "row 3, column qy", "blank", "qx qy qz qw")
    fails(log(tmp_path, ROWS[0], "0.1,,0,0,1,1,2,3,4,5,6"), "row 3, column qx", "blank")
    got = read_log(log(tmp_path, "0,0,0,0,1.005,1,2,3,4,5,6"))
    assert got["orientation"].values.tolist() == [[0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("header", "words"),
    [
        (HEADER.replace("fy", "aux"), ("column 'fy' is missing beside fx fz tx ty tz", "give all of")),
        (HEADER.replace("fy", "f_y"), ("'fy' is missing", "'f_y'", "did you mean 'fy'")),
        (HEADER.replace("qw", "q_w"), ("'qw' is missing", "'q_w'", "did you mean 'qw'")),
        (HEADER + ",px,py", ("'pz' is missing beside px py",)),
        (HEADER + ",q1,q2,q4", ("'q3' is missing beside q1 q2 q4",)),
        (HEADER + ",q2", ("'q1' is missing beside q2",)),
        (HEADER + ",GyroX,GyroY,GyroZ", ("'GyroX'", "did you mean 'gyro_x'", "rename")),
        (HEADER.replace("time", "timestamp"), ("'timestamp'", "did you mean 'time'", "in seconds")),
        (HEADER.replace("time", "Time"), ("'Time'", "did you mean 'time'")),
        (HEADER.replace("time", "tiem"), ("'tiem'", "did you mean 'time'")),
        (HEADER.replace("time", "t"), ("'t'", "did you mean 'time'")),
        ("time,qx,qy,qz,qw", ("there is no wrench", "fx fy fz tx ty tz")),
        (
            "time,qx,qy,qz,qw,force_x,moment_x",
            ("there is no wrench", "unknown columns: 'force_x', 'moment_x'"),
        ),
        ("time,fx,fy,fz,tx,ty,tz", ("there is no orientation", "qx qy qz qw", "q1..qn")),
        ("time,px,py,pz,fx,fy,fz,tx,ty,tz", ("there is no orientation",)),
        (HEADER + ",fx", ("column 'fx' is there 2 times",)),
        (HEADER + ",note,note", ("column 'note' is there 2 times",)),
        (HEADER.replace(",", " "), ("one column", "commas")),
        ("0,0,0,0,1,1,2,3,4,5,6", ("row 1", "numbers, not column names", "header row")),
        (HEADER + ',"', ("row 2", "11 cells under 12 column names")),
        (HEADER + ",note" * 2000, ("2011 columns, more than 1000",)),
        (HEADER + ",q1,q2,dq1,dq2,dq3", ("differ in number",)),
    ],
)
def test_bad_headers(tmp_path, header, words):
    width = len(header.split(","))
    row = ROWS[0] if width < 12 or '"' in header else ROWS[0] + ",1" * (width - 11)
    fails(log(tmp_path, row, header=header), *words)


def test_ragged_rows(tmp_path):
    fails(log(tmp_path, ROWS[0], ROWS[1][:-2], ROWS[2]), "row 3", "10 cells under 11 column names")
    fails(log(tmp_path, ROWS[0], ROWS[1], ROWS[2] + ",1"), "row 4", "12 cells under 11 column names")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", ("the file is empty",)),
        (b"\n \n\n", ("the file is empty",)),
        (HEADER.encode(), ("there are no samples",)),
        (HEADER.encode() + b"\n", ("there are no samples",)),
        (HEADER.encode() + b"\n\n\n", ("there are no samples",)),
        (HEADER.encode() + b"\n" + b"," * 10 + b"\n", ("no wrench", "blank")),
        (HEADER.encode() + b"\n0,,,,,1,2,3,4,5,6\n", ("no orientation", "blank")),
        (bytes(range(256)) * 40, ("binary",)),
        (b"PK\x03\x04\x00" + b"\x00" * 40, ("binary",)),
        (b"\x80\x81\xff" * 50, ("not CSV text in UTF-8",)),
        ("\ufeff".encode("utf-16-le") + HEADER.encode("utf-16-le"), ("UTF-16", "UTF-8")),
        (b"hello", ("one column",)),
        (b'"' + b"x" * 300_000, ("not CSV text",)),
        (HEADER.encode() + b"\n" + b"9" * 100_000, ("row 2", "1 cells under 11")),
        (HEADER.encode() + b',note\n0,0,0,0,1,1,2,3,4,5,6,"a\nb"\n', ("several lines",)),
        (
            HEADER.encode() + b",note\n0,0,0,0,1,1,2,3,4,5,6," + b"a" * 3_000_000,
            ("row 2", "is no row of cells"),
        ),
    ],
)
def test_files_that_are_no_log(tmp_path, content, words):
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    fails(path, *words)


def test_files_that_cannot_be_opened(tmp_path, monkeypatch):
    fails(tmp_path / "absent.csv", "does not exist")
    (tmp_path / "folder.csv").mkdir()
    fails(tmp_path / "folder.csv", "is not a file")
    os.mkfifo(tmp_path / "pipe.csv")
    fails(tmp_path / "pipe.csv", "is not a file")
    fails(tmp_path / "log.xlsx", "'.xlsx'", ".csv", ".parquet")
    fails(tmp_path / "log", "no suffix", ".csv")
    with open(tmp_path / "huge.csv", "wb") as huge:
        huge.truncate(3 * 1024**3)  # sparse: takes no room on the disk
    fails(tmp_path / "huge.csv", "3.2 GB")
    monkeypatch.setattr("hefting.logs.csv_file.MAX_CELLS", 20)
    fails(log(tmp_path, *ROWS), "3 rows, too many")


def test_writing_says_where_it_cannot(tmp_path):
    recording = random_recording(0)
    with pytest.raises(InputError, match=r"absent.*cannot be written"):
        write_log(recording, tmp_path / "absent" / "log.csv")
    with pytest.raises(InputError, match=r"'\.bag' is not a log format"):
        write_log(recording, tmp_path / "log.bag")


# What is read with a warning


def test_unknown_columns_are_listed_and_ignored(tmp_path):
    lines = [row + ",hello,,1" for row in ROWS]
    got = read_log(log(tmp_path, *lines, header=HEADER + ",comment,temperature,"))
    assert len(got["wrench"]) == 3
    assert got.warnings == ("ignored unknown columns: 'comment', 'temperature', number 14 without a name",)
    got = read_log(log(tmp_path, *lines, header=HEADER + ",gyrox_raw,b,c"))
    assert "'gyrox_raw' (did you mean 'gyro_" in got.warnings[0]


def test_a_column_of_row_numbers_may_lead(tmp_path):
    lines = [f"{k}\t" + row.replace(",", "\t") for k, row in enumerate(ROWS)]
    got = read_log(log(tmp_path, *lines, header="\t" + HEADER.replace(",", "\t")))
    assert got["wrench"].values[0].tolist() == [1, 2, 3, 4, 5, 6]
    assert got.warnings == ("ignored unknown columns: number 1 without a name",)


def test_an_optional_group_may_be_all_blank(tmp_path):
    got = read_log(log(tmp_path, ROWS[0] + ",,,", header=HEADER + ",gyro_x,gyro_y,gyro_z"))
    assert not got.has("gyroscope")
    assert got.warnings == ("columns gyro_x..gyro_z are all blank",)


def timed(folder: Path, times) -> Path:
    return log(folder, *(f"{t!r}{ROWS[0][1:]}" for t in times))


def test_epoch_seconds_are_shifted_with_their_precision(tmp_path):
    got = read_log(timed(tmp_path, [1.7e9 + k / 100 for k in range(5)]))
    # doubles near 1.7e9 are 2.4e-7 apart
    np.testing.assert_allclose(got["wrench"].time, np.arange(5) / 100, atol=2.4e-7)
    assert got["wrench"].time[0] == 0
    assert "shifted by 1700000000.000000 s" in got.warnings[0]
    assert "2e-07 s" in got.warnings[0]


@pytest.mark.parametrize(
    ("unit", "factor", "name"), [(10**3, "1e3", "milli"), (10**6, "1e6", "micro"), (10**9, "1e9", "nano")]
)
def test_epoch_times_in_other_units_are_refused(tmp_path, unit, factor, name):
    times = [1_700_000_000 * unit + k * unit // 100 for k in range(5)]
    fails(timed(tmp_path, times), "column time", f"{name}seconds since 1970", f"divide by {factor}")


def test_implausible_steps(tmp_path):
    assert "milliseconds" in read_log(timed(tmp_path, range(0, 100, 10))).warnings[0]
    assert "milliseconds" in read_log(timed(tmp_path, range(100))).warnings[0]  # 1 kHz in milliseconds
    assert "is time in seconds" in read_log(timed(tmp_path, [k * 1e-6 for k in range(9)])).warnings[0]
    fails(timed(tmp_path, range(0, 10**9, 10**7)), "column time", "step of orientation is 1e+07", "in seconds")
    for plausible in ([0.0, 2.5, 4.0], [53211.2, 53211.21], [-1.0, -0.9], [0, 1, 2]):
        assert read_log(timed(tmp_path, plausible)).warnings == ()


# Parquet


def parquet_log(folder: Path, **changes) -> Path:
    table = dict(zip(HEADER.split(","), np.array([row.split(",") for row in ROWS], dtype=float).T, strict=True))
    parquet.write_table(pa.table({**table, **changes}), folder / "log.parquet")
    return folder / "log.parquet"


def test_parquet_takes_other_number_types_and_ignores_the_rest(tmp_path):
    got = read_log(
        parquet_log(
            tmp_path,
            fx=np.array([1, 2, 3], dtype=np.int8),
            fy=np.array([0.5, 1, 2], dtype=np.float32),
            gyro_x=pa.nulls(3),
            gyro_y=pa.nulls(3),
            gyro_z=pa.nulls(3),
            note=["a", "b", "c"],
        )
    )
    assert got["wrench"].values[:, :2].tolist() == [[1, 0.5], [2, 1], [3, 2]]
    assert got["wrench"].rows.tolist() == [1, 2, 3]
    assert got.warnings == ("ignored unknown columns: 'note'", "columns gyro_x..gyro_z are all blank")


def test_bad_parquet(tmp_path):
    fails(parquet_log(tmp_path, fy=[0.0, float("nan"), 0.0]), "row 2, column fy", "nan")
    fails(parquet_log(tmp_path, fy=[0.0, None, 0.0]), "row 2, column fy", "blank")
    fails(parquet_log(tmp_path, time=[0.0, 1.0, 1.0]), "row 3", "repeats")
    fails(parquet_log(tmp_path, fy=["a", "b", "c"]), "column fy", "holds string, not numbers")
    times = pa.array([1, 2, 3], pa.timestamp("ns"))
    fails(parquet_log(tmp_path, time=times), "column time", "timestamp", "give seconds as numbers")
    whole = parquet_log(tmp_path).read_bytes()
    for broken in (
        b"PAR1",
        b"hello" * 100,
        whole[: len(whole) // 2],
        whole[:4] + b"\xff" * 40 + whole[44:],
        whole[:-40] + whole[-8:],
        whole.replace(b"fx", b"\xbc\xff"),
    ):
        (tmp_path / "log.parquet").write_bytes(broken)
        try:
            read_log(tmp_path / "log.parquet")
        except InputError:
            continue
        pytest.fail("a broken file was read")
    columns = ["time", "time", *HEADER.split(",")[1:]]
    twice = pa.Table.from_arrays([pa.array([0.0])] * len(columns), names=columns)
    parquet.write_table(twice, tmp_path / "log.parquet")
    fails(tmp_path / "log.parquet", "column 'time' is there 2 times")


def test_csv_and_parquet_say_the_same(tmp_path):
    sent = random_recording(9)
    for suffix in SUFFIXES:
        write_log(sent, tmp_path / f"log{suffix}")
    assert same(read_log(tmp_path / "log.csv"), read_log(tmp_path / "log.parquet"))


# Speed and data of others


def test_reading_costs_little_more_than_parsing(tmp_path):
    rng = np.random.default_rng(0)
    count = 20_000
    orientation = rng.normal(size=(count, 4))
    orientation /= np.linalg.norm(orientation, axis=1)[:, None]
    clock = np.arange(count) / 1000
    names = ("position", "wrench", "gyroscope", "accelerometer")
    streams = {name: Stream(clock, rng.normal(size=(count, len(COLUMNS[name])))) for name in names}
    path = tmp_path / "log.csv"
    write_log(Recording({**streams, "orientation": Stream(clock, orientation)}), path)

    def cost(read) -> float:
        best = np.inf
        for _ in range(5):
            begin = time.process_time()
            read(path)
            best = min(best, time.process_time() - begin)
        return best

    # measured 1.4 to 1.8; one pass of Python over the cells would be 20 or more
    assert cost(read_log) < 5 * cost(pacsv.read_csv)


@pytest.fixture
def data() -> Path:
    if "HEFTING_DATA" not in os.environ:
        pytest.skip("set HEFTING_DATA to the folder of recordings to run this test")
    return Path(os.environ["HEFTING_DATA"])


def test_every_recording_of_others_is_read_and_survives_a_round_trip(data, tmp_path):
    paths = sorted(data.rglob("*.csv"))
    assert len(paths) >= 19
    for path in paths:
        got = read_log(path)
        assert got.warnings == ()
        assert got.has("orientation", "wrench")
        assert got.static == (path.stem in ("static_poses", "poses7"))
        write_log(got, tmp_path / "log.parquet")
        assert same(read_log(tmp_path / "log.parquet"), got)


def test_recordings_of_others_hold_what_they_should(data):
    for name in ("baseline", "vibrations"):
        kuka = read_log(data / "kuka-ati" / f"{name}.csv")
        # nominal rates of its description, rounded to 1 Hz
        assert kuka.rates() == pytest.approx({"orientation": 100, "wrench": 698, "accelerometer": 254}, abs=1)
        assert kuka.duration == pytest.approx(6.3, abs=0.05)  # as described, to a decimal
    first = read_log(data / "kuka-ati" / "baseline.csv")
    assert first["wrench"].rows[:3].tolist() == [3, 4, 6]
    assert first["orientation"].rows[:2].tolist() == [2, 12]
    assert len(read_log(data / "kuka-ati" / "static_poses.csv")["wrench"]) == 24
    assert len(read_log(data / "axia80" / "poses7.csv")["wrench"]) == 7
    assert read_log(data / "axia80" / "dwells.csv").rates()["wrench"] == pytest.approx(10, rel=0.01)
    panda = read_log(data / "panda-optoforce" / "run1.csv")
    assert list(panda.streams) == ["position", "orientation", "wrench", "gyroscope", "linear_accelerometer"]
    assert panda.rates()["wrench"] == pytest.approx(1000, rel=0.01)
    tool = read_log(data / "workshop-tools" / "ruler" / "log.csv")
    assert tool.has("linear_velocity", "angular_velocity", "linear_acceleration", "angular_acceleration")
    assert len(tool["wrench"]) == 1000

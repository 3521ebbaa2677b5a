"""Logs that cannot be read: one clear line for each way a file can be wrong."""

import os

import pyarrow as pa
import pytest
from pyarrow import parquet

from hefting.core.errors import InputError
from hefting.logs import read_log, write_log
from hefting.logs.csv_header import NUMBER
from log_files import (
    HEADER,
    ROWS,
    fails,
    log,
    parquet_log,
    random_recording,
    refusal_time,
    timed,
)

# Rows


@pytest.mark.parametrize(
    ("before", "between", "row"),
    [
        ("", "", 4),
        ("\n\n", "", 6),
        ("", "\n", 5),
        ("\n", "\n\n\n", 8),
        (" \n", "\n", 6),
    ],
)
@pytest.mark.parametrize("bad", ["nan", "text", "inf"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_row_numbers_are_those_of_an_editor(tmp_path, before, between, row, bad, end):
    path = tmp_path / "log.csv"
    text = f"{before}{HEADER}\n{ROWS[0]}\n{between}{ROWS[1]}\n{ROWS[2].replace('7', bad)}\n"
    path.write_bytes(text.replace("\n", end).encode())
    fails(path, f"row {row}, column tz", bad)


def test_row_numbers_hold_far_into_a_large_file(tmp_path):
    # several of the parser's blocks
    lines = [f"{k / 1000},0,0,0,1,1,2,3,4,5,6" for k in range(60_000)]
    lines[777:777] = [""]
    for bad in ("inf", "x"):
        lines[54_321] = f"{54.32},0,0,0,1,1,{bad},3,4,5,6"
        fails(log(tmp_path, *lines), "row 54323, column fy")
    lines[54_321] = "54.32,0,0,0,1,1,2"
    fails(log(tmp_path, *lines), "row 54323", "7 cells under 11 column names")


# What is refused


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("abc", ("'abc' is not a number", "leave the cell blank")),
        ("NA", ("the cell is blank", "fx fy fz tx ty tz")),
        ("1.5.2", ("'1.5.2' is not a number",)),
        ('"1,234.5"', ("'1,234.5' is not a number", "without marks between thousands")),
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


def test_a_row_for_each_number_is_told(tmp_path):
    path = tmp_path / "plot.csv"
    path.write_text(
        "elapsed time,topic,value\n0.0,/ft.force.x,1.5\n0.1,/ft.force.x,1.6\n"
    )
    fails(path, "one number a row, beside its name", "make each name a column")


def test_column_names_in_the_middle_begin_another_recording(tmp_path):
    path = log(tmp_path, *ROWS, HEADER, *ROWS)
    fails(path, "row 5: ", "another recording begins", "cut the log in two")


def test_bad_times(tmp_path):
    fails(log(tmp_path, ROWS[0], "noon" + ROWS[1][3:]), "row 3, column time", "'noon'")
    fails(log(tmp_path, ROWS[0], ROWS[1][3:]), "row 3, column time", "time is blank")
    fails(log(tmp_path, ROWS[0], "nan" + ROWS[1][3:]), "row 3, column time", "nan")
    fails(log(tmp_path, ROWS[0], "inf" + ROWS[1][3:]), "row 3, column time", "inf")
    fails(
        log(tmp_path, *ROWS, ROWS[1]),
        "row 5",
        "0.1 s is before 0.2 s of row 4",
        "sort the rows",
    )
    fails(
        log(tmp_path, *ROWS, ROWS[2][:-1] + "8"),
        "row 5",
        "repeats that of row 4",
        "keep one",
    )


def test_a_decimal_comma_among_points_is_named(tmp_path):
    lines = [row.replace(",", ";") for row in ROWS]
    lines[1] = lines[1].replace("0.1", "0,1", 1)
    fails(
        log(tmp_path, *lines, header=HEADER.replace(",", ";")),
        "row 3, column time",
        "'0,1'",
        "with a point",
        'decimal = ","',
    )


def test_quaternions(tmp_path):
    fails(
        log(tmp_path, ROWS[0], "0.1,0,0,0.5,1,1,2,3,4,5,6"),
        "row 3",
        "norm 1.118",
        "unit quaternions",
    )
    fails(log(tmp_path, ROWS[0], "0.1,0,0,0,0,1,2,3,4,5,6"), "row 3", "norm 0")
    fails(
        log(tmp_path, ROWS[0], "0.1,0,,0,1,1,2,3,4,5,6"),
        "row 3, column qy",
        "blank",
        "qx qy qz qw",
    )
    fails(log(tmp_path, ROWS[0], "0.1,,0,0,1,1,2,3,4,5,6"), "row 3, column qx", "blank")
    got = read_log(log(tmp_path, "0,0,0,0,1.005,1,2,3,4,5,6"))
    assert got["orientation"].values.tolist() == [[0, 0, 0, 1]]


@pytest.mark.parametrize(
    ("header", "words"),
    [
        (
            HEADER.replace("fy", "aux"),
            ("column 'fy' is missing beside fx fz tx ty tz", "give all of"),
        ),
        # with as much lost as here, nothing is taken by its name
        (
            HEADER.replace("fy", "f_y").replace("qw", "aux"),
            ("unknown column 'f_y'", "did you mean 'fy'", "rename it 'fy'"),
        ),
        (
            HEADER.replace("qw", "q_w").replace("fz", "aux"),
            ("unknown column 'q_w'", "did you mean 'qw'", "rename it 'qw'"),
        ),
        (HEADER + ",px,py", ("'pz' is missing beside px py",)),
        (HEADER + ",q1,q2,q4", ("'q3' is missing beside q1 q2 q4",)),
        (HEADER + ",q2", ("'q1' is missing beside q2",)),
        (
            HEADER + ",q[0],q[1]",
            ("joints are numbered from 0, by 'q[0]'", "number them from 1"),
        ),
        (HEADER + ",GyroX,GyroY", ("'GyroX'", "did you mean 'gyro_x'", "rename")),
        (
            HEADER.replace("time", "timestamp") + ",px,py",
            ("'timestamp'", "did you mean 'time'", "in seconds"),
        ),
        (HEADER.replace("time", "tiem"), ("'tiem'", "did you mean 'time'")),
        ("time,qx,qy,qz,qw", ("there is no wrench", "fx fy fz tx ty tz")),
        (
            "time,qx,qy,qz,qw,force_x,moment_x",
            ("there is no wrench", "unknown columns: 'force_x', 'moment_x'"),
        ),
        (
            "time,fx,fy,fz,tx,ty,tz",
            ("there is no orientation", "qx qy qz qw", "q1..qn"),
        ),
        ("time,px,py,pz,fx,fy,fz,tx,ty,tz", ("there is no orientation",)),
        (HEADER + ",fx", ("column 'fx' is there 2 times",)),
        (HEADER + ",note,note", ("column 'note' is there 2 times",)),
        (HEADER.replace(",", ":"), ("one column", "commas")),
        ("0,0,0,0,1,1,2,3,4,5,6", ("row 1", "numbers, not column names", "header row")),
        (HEADER + ',"', ("row 2", "11 cells under 12 column names")),
        (HEADER + ",note" * 2000, ("2011 columns, more than 1000",)),
        (
            HEADER + "," + "x" * 1_000_000,
            ("row 1", "the header has more than 1,000,000 bytes"),
        ),
        (HEADER + ",q1,q2,dq1,dq2,dq3", ("differ in number",)),
    ],
)
def test_bad_headers(tmp_path, header, words):
    width = len(header.split(","))
    row = ROWS[0] if width < 12 or '"' in header else ROWS[0] + ",1" * (width - 11)
    fails(log(tmp_path, row, header=header), *words)


def test_ragged_rows(tmp_path):
    fails(
        log(tmp_path, ROWS[0], ROWS[1][:-2], ROWS[2]),
        "row 3",
        "10 cells under 11 column names",
    )
    fails(
        log(tmp_path, ROWS[0], ROWS[1], ROWS[2] + ",1"),
        "row 4",
        "12 cells under 11 column names",
    )


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
        (HEADER.encode("utf-16-le"), ("binary", "as CSV in UTF-8")),
        (HEADER.encode("utf-32"), ("binary", "as CSV in UTF-8")),
        (b"hello", ("one column",)),
        (b'"' + b"x" * 300_000, ("not CSV text",)),
        (HEADER.encode() + b"\n" + b"9" * 100_000, ("row 2", "1 cells under 11")),
        (
            HEADER.encode() + b',note\n0,0,0,0,1,1,2,3,4,5,6,"a\nb"\n',
            ("several lines",),
        ),
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
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    fails(tmp_path / "loop.csv", "is a link to no file")
    os.mkfifo(tmp_path / "pipe.csv")
    fails(tmp_path / "pipe.csv", "is a pipe or a device, not a file")
    for suffix in (".csv", ".txt", ".tsv", ".parquet", ".npz", ".bag", ".mcap", ".db3"):
        fails(log(tmp_path, *ROWS).rename(tmp_path / "log.mf4"), "'.mf4'", suffix)
    fails(tmp_path / "log.mf4", "`hefting.as_recording` takes arrays or columns")
    fails(tmp_path / "log", "does not exist")
    with open(tmp_path / "huge.csv", "wb") as huge:
        huge.truncate(3 * 1024**3)  # sparse: takes no room on the disk
    fails(tmp_path / "huge.csv", "3.2 GB")
    monkeypatch.setattr("hefting.logs.table.MAX_CELLS", 22)
    fails(log(tmp_path, *ROWS), "more than 2 rows, too many")
    with monkeypatch.context() as patch:
        # rows are counted over all blocks
        patch.setattr("hefting.logs.csv_file.BLOCK", 100)
        fails(log(tmp_path, *ROWS), "more than 2 rows, too many")
    monkeypatch.setattr("hefting.logs.table.MAX_CELLS", 33)
    assert len(read_log(log(tmp_path, *ROWS))["wrench"]) == 3


def test_writing_says_where_it_cannot(tmp_path):
    recording = random_recording(0)
    with pytest.raises(InputError, match=r"absent.*cannot be written"):
        write_log(recording, tmp_path / "absent" / "log.csv")
    for name in ("log.xlsx", "log.txt", "log.db3"):
        with pytest.raises(
            InputError,
            match=r"not a log format to write; use \.csv, \.parquet, \.bag, \.mcap",
        ):
            write_log(recording, tmp_path / name)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("log.xlsx", "is a workbook; save its sheet as CSV"),
        ("log.ods", "is a workbook; save its sheet as CSV"),
        (
            "wrench.npy",
            "is one array without a name; write all by numpy.savez('log.npz'",
        ),
        ("log.json", "is JSON, not a log format; in Python: hefting.write_log"),
        ("log.csv.gz", "is packed with gzip; unpack it"),
        ("log.h5", "is HDF5; in Python: hefting.write_log("),
        (
            "log.tdms",
            "(hefting.as_recording(nptdms.TdmsFile(path).groups()[0].as_dataframe()), 'log.csv')",
        ),
        ("log.pkl", "is a pickle, which may run code; in Python"),
    ],
)
def test_files_of_other_kinds_say_what_to_do(tmp_path, name, said):
    (tmp_path / name).write_bytes(b"PK\3\4")
    fails(tmp_path / name, said)


def test_options_and_maps_that_do_not_apply(tmp_path):
    path = log(tmp_path, *ROWS)
    assert len(read_log(path, wrench_topic=None)["wrench"]) == 3
    fails(path, "`wrench_topic` is for bags", wrench_topic="/ft")
    fails(path, "`sensor_frame` is for bags", sensor_frame="ft")
    bag = path.rename(tmp_path / "log.bag")
    fails(
        bag,
        "column map (`column_map`) is for CSV, Parquet, Arrow, NumPy, MATLAB and JSON lines",
        column_map=tmp_path / "map.toml",
    )


@pytest.mark.parametrize("row", [0, 1, -1])
def test_a_cell_of_another_column_may_be_long(tmp_path, row):
    """Longer than Python's `csv` splits, as of an image, in whatever row."""
    rows = [f"{each},x" for each in ROWS]
    rows[row] += "x" * 140_000
    path = tmp_path / "log.csv"
    path.write_text("\n".join((f"{HEADER},note", *rows, "")))
    assert len(read_log(path)["wrench"]) == len(ROWS)


def test_lines_too_long_to_hold(tmp_path, monkeypatch):
    monkeypatch.setattr("hefting.logs.csv_file.BLOCK", 1000)
    fails(log(tmp_path, "9" * 2500, *ROWS), "has a line of more than 1,000 bytes")


@pytest.mark.parametrize(
    ("unit", "factor", "name"),
    [(10**3, "1e3", "milli"), (10**6, "1e6", "micro"), (10**9, "1e9", "nano")],
)
def test_epoch_times_in_other_units_are_refused(tmp_path, unit, factor, name):
    times = [1_700_000_000 * unit + k * unit // 100 for k in range(5)]
    fails(
        timed(tmp_path, times),
        "column time",
        f"{name}seconds since 1970",
        f"divide by {factor}",
    )


def test_bad_parquet(tmp_path):
    fails(parquet_log(tmp_path, fy=[0.0, float("nan"), 0.0]), "row 2, column fy", "nan")
    fails(parquet_log(tmp_path, fy=[0.0, None, 0.0]), "row 2, column fy", "blank")
    fails(parquet_log(tmp_path, time=[0.0, 1.0, 1.0]), "row 3", "repeats")
    fails(
        parquet_log(tmp_path, fy=["a", "b", "c"]),
        "column fy",
        "holds string, not numbers",
    )
    lists = parquet_log(tmp_path, f=[[0.0, 1.0], [0.0], [2.0, 3.0]])
    column_map = tmp_path / "map.toml"
    column_map.write_text(
        'time = "time"\nwrench = ["f_0", "f_1", "fz", "tx", "ty", "tz"]\n'
        'orientation = ["qx", "qy", "qz", "qw"]\n'
    )
    with pytest.raises(InputError, match="Index 1 is out of bounds"):
        read_log(lists, column_map=column_map)
    fails(
        parquet_log(tmp_path, time=pa.array([1, 2, 3], pa.time64("ns"))),
        "column time",
        "time64",
        "give seconds as numbers",
    )
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


def test_a_cell_of_many_digits_takes_a_time_that_grows_with_its_length():
    """Ten times the digits took a hundred times as long: 60,000 more than 20 s."""
    for digit in ("1", " "):
        few, many = (
            refusal_time(NUMBER, count * digit + "x") for count in (20_000, 200_000)
        )
        # ten times as long, with a margin for clocks and caches
        assert many < 40.0 * few
    for text in ("1", "-1.", ".5", "1.5e-3", " nan ", "", "+inf"):
        assert NUMBER.fullmatch(text)

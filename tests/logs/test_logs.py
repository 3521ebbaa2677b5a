"""Canonical CSV and Parquet: exact round trips, and what is read with a warning."""

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from pyarrow import csv as pacsv
from pyarrow import parquet

import hefting
from hefting.core.magnitudes import LARGEST, SMALLEST_INTERVAL
from hefting.core.messages import NO_DOUBT, codes
from hefting.core.recording import Recording, Stream
from hefting.logs import read_log, write_log
from hefting.logs.csv_cells import UTF_16
from log_files import (
    HEADER,
    ROWS,
    fails,
    log,
    parquet_log,
    random_recording,
    reader_of_text,  # noqa: F401
    same,
    timed,
)

SUFFIXES = (".csv", ".parquet")


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


finite = st.floats(-LARGEST["wrench"], LARGEST["wrench"])


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    st.lists(
        st.tuples(st.floats(0, 100), *[finite] * 6),
        min_size=1,
        max_size=6,
        unique_by=lambda row: row[0],
    )
)
def test_any_floats_survive(tmp_path, suffix, samples):
    table = np.array(sorted(samples))
    assume((np.diff(table[:, 0]) >= SMALLEST_INTERVAL).all())
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
    got = read_log(
        log(tmp_path, *(row.split(",", 1)[1] for row in ROWS), header=header)
    )
    assert got.static
    assert got.warnings == ()
    assert got["wrench"].time.tolist() == [0, 1, 2]
    assert (
        read_log(log(tmp_path, ROWS[0].split(",", 1)[1], header=header)).duration == 0
    )
    moving = read_log(
        log(
            tmp_path,
            "0,0,0,1,1,2,3,4,5,6,0,0,1",
            header=header + ",gyro_x,gyro_y,gyro_z",
        )
    )
    assert "static pose, although there is gyroscope" in moving.warnings[0]


def test_rows_that_move_smoothly_are_hardly_static_poses(tmp_path):
    header = HEADER.split(",", 1)[1]
    angle = np.linspace(0.0, 1.5, 60)
    orders = (np.arange(60), np.random.default_rng(3).permutation(60))
    for order, count in zip(orders, (1, 0), strict=True):
        lines = [f"0,0,{np.sin(a)},{np.cos(a)},1,2,3,4,5,6" for a in angle[order]]
        got = read_log(log(tmp_path, *lines, header=header))
        assert got.static
        assert len(got.warnings) == count
        for said in got.warnings:
            assert (said.code, said.code in NO_DOUBT) == ("time-missing", False)
            assert "although they move smoothly" in said
            assert "time = { rate = 250 }" in said


def test_one_timed_sample_is_enough(tmp_path):
    got = read_log(log(tmp_path, ROWS[0]))
    assert not got.static
    assert got.duration == 0


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_separators_and_byte_order_mark(tmp_path, end, separator, mark):
    lines = [line.replace(",", separator) for line in ROWS]
    got = read_log(
        log(tmp_path, *lines, header=mark + HEADER.replace(",", separator), end=end)
    )
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


@pytest.mark.parametrize("suffix", [".csv", ".txt", ".tsv"])
def test_text_may_be_separated_by_spaces_and_its_header_be_a_comment(tmp_path, suffix):
    lines = [row.replace(",", "  ") for row in ROWS]  # as a column is aligned
    path = log(
        tmp_path, f" {lines[0]} ", *lines[1:], header="# " + HEADER.replace(",", " ")
    )
    got = read_log(path.rename(tmp_path / f"log{suffix}"))
    assert got["wrench"].values[2].tolist() == [1, 2, 3, 4, 5, 7]
    assert got["wrench"].rows.tolist() == [2, 3, 4]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("block", [150, 151, 152, 153, 1000])
def test_blocks_do_not_show(tmp_path, monkeypatch, end, block):
    """Wherever a file is cut, in the middle of a line's end too, the samples and their
    rows are the same."""
    lines = [f"{k / 100},0,0,0,1,{k},2,3,4,5,6" for k in range(40)]
    lines[10:10] = ["", ""]
    path = log(tmp_path, *lines, header="\ufeff" + HEADER, end=end)
    monkeypatch.setattr("hefting.logs.csv_file.BLOCK", block)
    got = read_log(path)["wrench"]
    assert got.values[:, 0].tolist() == list(range(40))
    assert got.rows.tolist() == [*range(2, 12), *range(14, 44)]
    lines[30] = lines[30].replace("2,3", "2,x")
    fails(log(tmp_path, *lines, end=end), "row 32, column fz", "'x'")


def test_streams_of_the_same_rows_share_their_times(tmp_path):
    """A long table then needs no memory for them, nor for copies of its numbers."""
    got = read_log(log(tmp_path, *ROWS))
    assert got["wrench"].time is got["orientation"].time
    assert got["wrench"].rows is got["orientation"].rows
    shifted = read_log(timed(tmp_path, (1.7e9, 1.7e9 + 0.5)))
    assert shifted["wrench"].time is shifted["orientation"].time
    for stream in got.streams.values():
        for array in (stream.time, stream.values, stream.rows):
            assert not array.flags.writeable
            assert array.base is None or not array.base.flags.writeable


@pytest.mark.parametrize(
    "text",
    ["1e-320", "1.", ".5", "-0.0", "1234567890.12345678901", "1E5", "0.1", "1e+9"],
)
def test_numbers_are_read_to_the_last_bit(tmp_path, text):
    got = read_log(log(tmp_path, ROWS[0], f"0.1,0,0,0,1,{text},2,3,4,5,6"))
    assert got["wrench"].values[1, 0].tobytes() == np.float64(text).tobytes()


@pytest.mark.parametrize("cell", ["1-2", "1.2.3", "--1", "1e", "e5", ".", "-", "1e5.5"])
def test_what_only_looks_like_numbers(tmp_path, cell):
    fails(
        log(tmp_path, ROWS[0], f"0.1,0,0,0,1,{cell},2,3,4,5,6"),
        f"row 3, column fx: '{cell}' is not a number",
    )


# What is read with a warning


def test_repeated_rows_are_dropped(tmp_path):
    again = "0.1,,,,,1,2,3,4,5,6"  # the wrench of the row before, and nothing else
    got = read_log(
        log(tmp_path, ROWS[0], ROWS[0], ROWS[0], ROWS[1], again, ROWS[2], ROWS[2])
    )
    assert (
        got["wrench"].time.tolist() == got["orientation"].time.tolist() == [0, 0.1, 0.2]
    )
    assert got["wrench"].rows.tolist() == [2, 5, 7]
    assert got.warnings == (
        "dropped 4 repeated rows, time and values alike (the first: row 3)",
    )
    got = read_log(log(tmp_path, *ROWS, ROWS[2]))
    assert got.warnings == (
        "dropped 1 repeated row, time and values alike (the first: row 5)",
    )
    header = HEADER.removeprefix("time,")
    static = read_log(log(tmp_path, *[ROWS[0].split(",", 1)[1]] * 3, header=header))
    assert len(static["wrench"]) == 3  # poses without time repeat as often as they like


@pytest.mark.parametrize("count", [1, 5, 6])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_few_rows_at_the_time_of_the_one_before_are_left_out(tmp_path, suffix, count):
    """As in bags: a clock of milliseconds at 1 kHz. Of more than a tenth it is told how
    to write them."""
    rng, at = np.random.default_rng(0), 7 * np.arange(1, count + 1)
    time = 0.001 * np.arange(50)
    time[at] = time[at - 1]
    names = [name for name in HEADER.split(",") if name != "time"]
    table = pa.table(
        {"time": time}
        | dict.fromkeys(names[:4], np.full(50, 0.5))
        | {name: rng.normal(size=50) for name in names[4:]}
    )
    path = tmp_path / f"log{suffix}"
    write = pacsv.write_csv if suffix == ".csv" else parquet.write_table
    write(table, path)
    if count > 5:
        fails(path, "repeats that of row", "with more digits")
        return
    got = read_log(path)
    assert len(got["wrench"]) == len(got["orientation"]) == 50 - count
    np.testing.assert_array_equal(got["wrench"].time, np.unique(time))
    (said,) = got.warnings
    assert said.code == "rows-conflicting"
    assert said.code in NO_DOUBT  # as other rows that are left out
    assert said.startswith(f"left out {count} row")
    assert "(the first: row 9)" in said or suffix == ".parquet"


def test_unknown_columns_are_listed_and_ignored(tmp_path):
    lines = [row + ",hello,,1" for row in ROWS]
    got = read_log(log(tmp_path, *lines, header=HEADER + ",comment,temperature,"))
    assert len(got["wrench"]) == 3
    assert got.warnings == (
        "ignored unknown columns: 'comment', 'temperature', number 14 without a name",
    )
    got = read_log(log(tmp_path, *lines, header=HEADER + ",gyrox_raw,b,c"))
    assert "'gyrox_raw' (did you mean 'gyro_" in got.warnings[0]


def test_a_column_of_row_numbers_may_lead(tmp_path):
    lines = [f"{k}\t" + row.replace(",", "\t") for k, row in enumerate(ROWS)]
    got = read_log(log(tmp_path, *lines, header="\t" + HEADER.replace(",", "\t")))
    assert got["wrench"].values[0].tolist() == [1, 2, 3, 4, 5, 6]
    assert got.warnings == ("ignored unknown columns: number 1 without a name",)


def test_an_optional_group_may_be_all_blank(tmp_path):
    got = read_log(
        log(tmp_path, ROWS[0] + ",,,", header=HEADER + ",gyro_x,gyro_y,gyro_z")
    )
    assert not got.has("gyroscope")
    assert got.warnings == ("columns gyro_x..gyro_z are all blank",)


@pytest.mark.parametrize("cell", ["nan", "N/A", ""])
@pytest.mark.parametrize("column", [2, 6])
def test_a_few_rows_that_lack_a_number_are_left_out_and_counted(tmp_path, cell, column):
    """Of the stream that lacks it; in many rows it is an error."""
    lines = [[f"{0.1 * k}", *ROWS[0].split(",")[1:]] for k in range(20)]
    for row in (7, 8, 15):
        lines[row][column] = cell
    got = read_log(log(tmp_path, *map(",".join, lines)))
    counts = {"orientation": 20, "wrench": 20} | {
        "orientation" if column < 5 else "wrench": 17
    }
    assert {name: len(stream) for name, stream in got.streams.items()} == counts
    [said] = got.warnings
    assert said.startswith("left out 3 of 20 rows (the first: row 9) in which ")
    for row in (9, 10):
        lines[row][column] = cell
    fails(
        log(tmp_path, *map(",".join, lines)),
        "row 9",
        "here and in 4 more rows",
        "blank",
    )


@pytest.mark.parametrize("fill", ["0", "-9999"])
def test_a_few_poses_that_are_none_are_left_out_and_counted(tmp_path, fill):
    header = HEADER + ",px,py,pz"
    lines = [[f"{0.1 * k}", *ROWS[0].split(",")[1:], "1", "2", "3"] for k in range(20)]
    for row in (7, 8):
        lines[row][1:5], lines[row][11:] = [fill] * 4, [fill] * 3
    got = read_log(log(tmp_path, *map(",".join, lines), header=header))
    assert len(got["orientation"]) == len(got["position"]) == 18
    assert len(got["wrench"]) == 20
    assert (got["position"].values == [1, 2, 3]).all()
    [said] = got.warnings
    assert said.startswith("left out 2 of 20 poses (the first: row 9)")
    for row in range(9, 12):
        lines[row][1:5] = [fill] * 4
    fails(log(tmp_path, *map(",".join, lines), header=header), "row 9", "norm")


ENDS = {
    "a row that was cut": "0.3,0,0,0,1",
    "a row that was cut by the power": "0.3,0,0,0,1,1,2,3,4,5,0." + "\0" * 5000,
    "NUL alone": "\0" * 200_000,
    "a comment": "\n# end of recording, 3 samples\n",
    "a summary": "Total,3,,,,,,,,,\nmean of fz,3,,,,,,,,,\n",
}


@pytest.mark.parametrize("codec", ["utf-8", *UTF_16.values()])
@pytest.mark.parametrize("case", ENDS)
def test_what_follows_the_last_whole_row_is_left_out_and_said(tmp_path, case, codec):
    path = log(tmp_path, *ROWS)
    whole = "\ufeff" + path.read_text()
    for end in ("\n", "\r\n"):
        path.write_bytes((whole.replace("\n", end) + ENDS[case]).encode(codec))
        got = read_log(path)
        assert same(got, read_log(log(tmp_path, *ROWS)))
        [said] = got.warnings
        assert said.startswith("left out what follows the last whole row: ")
        first = ENDS[case].strip("\n\0").partition("\n")[0]
        assert (first[:40] or "NUL") in said


@pytest.mark.parametrize("codec", UTF_16.values())
@pytest.mark.parametrize("size", [7, 4096])
def test_text_in_utf_16(tmp_path, monkeypatch, codec, size):
    """As Excel and PowerShell write it, whatever part of a letter a piece ends with;
    the last row may be cut in one."""
    monkeypatch.setattr("hefting.logs.csv_file.READ", size)
    path, said = tmp_path / "log.txt", {"columns-ignored"}
    lines = "\ufeff" + HEADER + ",時刻 µ", *(f"{row},時" for row in ROWS), ""
    text = "\r\n".join(lines).encode(codec)
    for cut in (b"", "0.3,0".encode(codec)[:-1]):
        path.write_bytes(text + cut)
        got = read_log(path)
        assert same(got, read_log(log(tmp_path, *ROWS)))
        assert codes(got.warnings) == said
        said.add("end-left-out")


def test_rows_that_end_with_words_are_rows(tmp_path):
    """Sparse ones too, in which words are the most."""
    header = HEADER + ",state,note,by"
    rows = [f"{row},on,moves,me" for row in ROWS]
    rows += ["0.3" + "," * 10 + ",on,moves,me", "0.4" + "," * 13]
    got = read_log(log(tmp_path, *rows, header=header))
    assert codes(got.warnings) == {"columns-ignored"}
    fails(log(tmp_path, *ROWS, "0.3,0,0,0,1,1,x,3,4,5,6"), "row 5, column fy")


def test_epoch_seconds_are_shifted_with_their_precision(tmp_path):
    got = read_log(timed(tmp_path, [1.7e9 + k / 100 for k in range(5)]))
    # doubles near 1.7e9 are 2.4e-7 apart
    np.testing.assert_allclose(got["wrench"].time, np.arange(5) / 100, atol=2.4e-7)
    assert got["wrench"].time[0] == 0
    assert "shifted by 1700000000.000000 s" in got.warnings[0]
    assert "2e-07 s" in got.warnings[0]
    times = [1_700_000_000.5 + k / 4 for k in range(5)]
    first, last = (f"{t},0,0,0,1,,,,,," for t in (times[0], times[4] + 1))
    rows = [first, *(f"{t},,,,,1,2,3,4,5,6" for t in times[1:]), last]
    got = read_log(log(tmp_path, *rows))
    assert got["orientation"].time.tolist() == [0, 2]
    assert got["wrench"].time.tolist() == [0.25, 0.5, 0.75, 1], (
        "all streams are shifted alike"
    )


def test_implausible_steps(tmp_path):
    assert "milliseconds" in read_log(timed(tmp_path, range(0, 100, 10))).warnings[0]
    # 1 kHz in milliseconds
    assert "milliseconds" in read_log(timed(tmp_path, range(100))).warnings[0]
    assert (
        "is time in seconds"
        in read_log(timed(tmp_path, [k * 1e-6 for k in range(9)])).warnings[0]
    )
    fails(
        timed(tmp_path, range(0, 10**9, 10**7)),
        "column time",
        "step of orientation is 1e+07",
        "in seconds",
    )
    bursts = [0.04 * (k // 5) + 1e-6 * k for k in range(20)]
    hours = [53211.2, 53211.21]
    for plausible in ([0.0, 2.5, 4.0], hours, [-1.0, -0.9], [0, 1, 2], bursts):
        assert read_log(timed(tmp_path, plausible)).warnings == ()


# Parquet


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
    assert got.warnings == (
        "ignored unknown columns: 'note'",
        "columns gyro_x..gyro_z are all blank",
    )


@pytest.mark.parametrize("fixed", [True, False])
def test_lists_in_parquet_are_columns(tmp_path, fixed):
    """As data sets for robot learning have them, with lists of other things beside; the
    numbers are those of the same log in columns of its own."""
    rng, time = np.random.default_rng(9), 0.01 * np.arange(50)
    turns = rng.normal(size=(50, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    sent = hefting.as_recording(
        time=time,
        position=rng.normal(size=(50, 3)),
        orientation=turns,
        wrench=rng.normal(size=(50, 6)),
    )
    write_log(sent, tmp_path / "columns.parquet")
    table = parquet.read_table(tmp_path / "columns.parquet")

    def lists(names):
        rows = np.stack([table[name].to_numpy() for name in names], axis=1).tolist()
        kind = pa.list_(pa.float64(), len(names)) if fixed else pa.list_(pa.float64())
        return pa.array(rows, kind)

    held = {
        "timestamp": table["time"],
        "observation.wrench": lists(["fx", "fy", "fz", "tx", "ty", "tz"]),
        "observation.pose": lists(["px", "py", "pz", "qx", "qy", "qz", "qw"]),
        "more": pa.array([{"note": "a", "of": {"list": [1.0]}}] * len(table)),
        "words": pa.array([["a", "b"]] * len(table)),
        "empty": pa.array([[]] * len(table), pa.list_(pa.float64())),
    }
    parquet.write_table(pa.table(held), tmp_path / "lists.parquet")
    got = read_log(tmp_path / "lists.parquet")
    for name in ("wrench", "position", "orientation"):
        np.testing.assert_array_equal(got[name].values, sent[name].values)


def test_fields_of_structures_in_parquet_are_columns(tmp_path):
    """Each is read under its path, as of messages of ROS."""
    rows = [dict(zip("xyz", row, strict=True)) for row in np.eye(3)]
    wrench = pa.array([{"force": row, "torque": row} for row in rows])
    path = parquet_log(tmp_path, wrench=wrench)
    table = parquet.read_table(path).drop_columns(["fx", "fy", "fz", "tx", "ty", "tz"])
    parquet.write_table(table, path)
    got = read_log(path)
    np.testing.assert_array_equal(got["wrench"].values, np.hstack((np.eye(3),) * 2))


def test_csv_and_parquet_say_the_same(tmp_path):
    sent = random_recording(9)
    for suffix in SUFFIXES:
        write_log(sent, tmp_path / f"log{suffix}")
    assert same(read_log(tmp_path / "log.csv"), read_log(tmp_path / "log.parquet"))

"""Logs and column maps made to harm: what the fuzzing found, each once."""

import sqlite3

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy.spatial.transform import Rotation

import ur_records
from bags import write
from hefting.core.errors import InputError
from hefting.core.files import MAX_MAP
from hefting.core.recording import Recording
from hefting.core.spatial import rotation_matrices
from hefting.logs import read_log
from log_files import HEADER, ROWS, check_line, fails, log, mapping_fails


@pytest.mark.parametrize(
    "line",
    [
        "a." * 30_000 + "a = 1",
        "[" + "a." * 30_000 + "a]",
        "x = { " + "a." * 30_000 + "a = 1 }",
        "x = {p=''' \" ' \" ''', " + "a." * 30_000 + "a = 1, q = '\"'}",
        '"a".' * 15_000 + "a = 1",
    ],
)
def test_maps_of_dotted_keys(tmp_path, line):
    """The first took two minutes and 8 GB."""
    assert len(line) < MAX_MAP
    mapping_fails(log(tmp_path, *ROWS), line, "a line of more than 1,000 dots")


def test_names_with_dots_are_read(tmp_path):
    names = [f"robot.state.{name}" for name in HEADER.split(",")]
    path = log(tmp_path, *ROWS, header=",".join(names))
    chosen = tmp_path / "map.toml"
    quoted = [f'"{name}"' for name in names]
    chosen.write_text(
        f"time = {quoted[0]}\norientation = [{','.join(quoted[1:5])}]\n"
        f"wrench = [{','.join(quoted[5:])}]\n"
    )
    assert len(read_log(path, chosen)["wrench"]) == 3


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE messages SET data = NULL WHERE id = 3",
        "UPDATE messages SET data = 7 WHERE id = 3",
        "UPDATE messages SET data = 'text' WHERE id = 3",
        "UPDATE messages SET timestamp = NULL WHERE id = 3",
        "UPDATE messages SET timestamp = 1e300 WHERE id = 3",
    ],
)
def test_rows_of_a_bag_that_hold_nothing(tmp_path, change):
    """A NULL where a message should be: read up to there."""
    entries = [
        ("/ft", "geometry_msgs/WrenchStamped", 10**9 + k, {"stamp": 10**9 + k})
        for k in range(6)
    ]
    entries += [
        (
            "/pose",
            "geometry_msgs/PoseStamped",
            10**9,
            {"stamp": 10**9, "pose.orientation": (0, 0, 0, 1)},
        )
    ]
    path = write(tmp_path, "bare.db3", [entries[-1], *entries[:-1]])
    assert len(read_log(path)["wrench"]) == 6
    database = sqlite3.connect(path, isolation_level=None)
    database.executescript(
        "CREATE TABLE other AS SELECT * FROM messages; DROP TABLE messages;"
        "ALTER TABLE other RENAME TO messages;"  # without its constraints
    )
    assert database.execute(change).rowcount == 1
    database.close()
    try:
        found = read_log(path)
    except InputError as error:
        check_line(str(error), str(path))
    else:
        assert len(found["wrench"]) < 6
        assert any("damaged" in line for line in found.warnings)


@pytest.mark.parametrize("field", ["actual_TCP_pose", "tcp_offset"])
@pytest.mark.parametrize("value", [1e200, -1e308, 1e31])
def test_rotations_of_a_record_that_are_no_angles(tmp_path, field, value):
    """The norm of such a vector is infinite, which gave quaternions of zero."""
    values = np.tile(ur_records.OFFSET, (ur_records.COUNT, 1))
    values[4, 5] = value
    path = ur_records.record(
        tmp_path / "log.csv", *ur_records.ALL, separator=",", **{field: values}
    )
    fails(path, "row 6", f"column {field}_5")


def test_large_rotations_of_a_record_are_rotations(tmp_path):
    """Up to what a cell may hold, many turns are some orientation."""
    values = np.tile(ur_records.OFFSET, (ur_records.COUNT, 1))
    values[:, 3:] = 1e25
    path = ur_records.record(
        tmp_path / "log.csv",
        "actual_TCP_pose",
        "ft_raw_wrench",
        separator=",",
        actual_TCP_pose=values,
    )
    found = read_log(path)["orientation"].values
    turned = rotation_matrices(found)
    np.testing.assert_allclose(
        turned, Rotation.from_rotvec(values[:, 3:]).as_matrix(), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(turned), 1.0, atol=1e-12)


def test_a_recording_of_huge_numbers_is_refused_by_name(tmp_path):
    row = ROWS[1].replace(",1,1,2", ",1,1e300,2")
    fails(log(tmp_path, ROWS[0], row, ROWS[2]), "row 3, column fx")
    fails(log(tmp_path, ROWS[0], ROWS[1], "1e300" + ROWS[2][3:]), "row 4, column time")
    assert isinstance(read_log(log(tmp_path, *ROWS)), Recording)


def test_lists_of_a_row_that_are_too_long(tmp_path, monkeypatch):
    """3 kB of Parquet held lists of 240 million numbers, in 4.2 GB."""
    path = tmp_path / "log.parquet"
    zeros = pa.array([np.zeros(1_000_001, np.int8)], pa.list_(pa.int8()))
    parquet.write_table(pa.table({"state": zeros}), path, compression="zstd")
    assert path.stat().st_size < 2000
    monkeypatch.setattr("hefting.logs.table.MAX_CELLS", 1_000_000)
    fails(path, "holds more than 1,000,000 numbers")


@pytest.mark.parametrize("repeated", ["joint1", "FTx", "a."])
def test_names_are_understood_in_no_time_that_grows_with_their_square(
    tmp_path, repeated
):
    """One of 90,000 characters took minutes."""
    head = HEADER.replace("fx", (repeated * 10_000)[:30_000] + "fx")
    fails(log(tmp_path, *ROWS, header=head), "fx")


@pytest.mark.parametrize(
    "head",
    [
        ",".join("a" * 300_000) + "\n" + ",".join("1" * 300_000),
        "time" + " " * 300_000 + "fx fy\n1 2 3",
    ],
)
def test_headers_are_looked_at_once(tmp_path, head):
    """The time had grown with the square of the number of names, or of blanks."""
    path = tmp_path / "log.csv"
    path.write_text(f"{head}\n")
    with pytest.raises(InputError):
        read_log(path)


def test_text_above_a_header_is_read_once(tmp_path):
    """A line of dashes above the names took minutes."""
    dashes = "Force Units:" + "-" * 9000
    head = HEADER.replace("fx", "Fx")
    path = log(tmp_path, *ROWS, header=f"{dashes}\n{head}")
    assert len(read_log(path)["wrench"]) == len(ROWS)

"""Arrow's files and streams are read as the same table in Parquet."""

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import feather, ipc

from hefting.core.errors import InputError
from hefting.logs import read_log
from table_of_log import WRENCH


def write(values: pa.Table, path) -> None:
    """Write Feather, or a stream where the name is of Arrow."""
    if path.suffix == ".feather":
        feather.write_feather(values, str(path))
        return
    with ipc.new_stream(str(path), values.schema) as writer:
        writer.write_table(values, max_chunksize=7)


@pytest.mark.parametrize("name", ["log.feather", "log.arrow"])
@pytest.mark.parametrize("dated", [False, True])
def test_a_table_is_read_as_parquet_is(frame, read, tmp_path, name, dated):
    frame.loc[::3, list(WRENCH)] = None
    values = pa.Table.from_pandas(frame, preserve_index=False)
    if dated:
        stamps = pa.array(
            (1e9 * frame["time"]).round().astype("int64"), pa.timestamp("ns", "UTC")
        )
        values = values.set_column(0, "time", stamps)
    write(values, tmp_path / name)
    found = read_log(tmp_path / name)
    assert found.warnings == ()
    assert len(found["wrench"]) == 20
    np.testing.assert_allclose(
        found["wrench"].time, read["wrench"].time[frame["fx"].notna()]
    )


@pytest.mark.parametrize("name", ["log.feather", "log.arrow"])
def test_lists_and_structures_of_streams_of_two_rates(frame, read, tmp_path, name):
    """A list, or a structure, is null where nothing was measured, first of all."""
    rows = [
        {
            "t": row[0],
            "quat": None if k % 3 == 0 else row[4:8].tolist(),
            "wrench": {"force": row[8:11].tolist(), "torque": row[11:].tolist()},
        }
        for k, row in enumerate(frame.to_numpy())
    ]
    write(pa.Table.from_pylist(rows), tmp_path / name)
    found = read_log(tmp_path / name)
    np.testing.assert_array_equal(found["wrench"].values, read["wrench"].values)
    kept = np.arange(30) % 3 > 0
    np.testing.assert_allclose(
        found["orientation"].values, read["orientation"].values[kept]
    )


@pytest.mark.parametrize("name", ["log.feather", "log.arrow"])
def test_a_damaged_file_is_refused_in_a_line(frame, tmp_path, name):
    write(pa.Table.from_pandas(frame), tmp_path / name)
    data = (tmp_path / name).read_bytes()
    for kept in (data[:40], data[: len(data) // 2], b"FEA1" + data[4:]):
        (tmp_path / name).write_bytes(kept)
        with pytest.raises(InputError, match="cannot be read as Arrow") as refused:
            read_log(tmp_path / name)
        assert "\n" not in str(refused.value)


def test_offsets_that_lead_outside_are_refused(tmp_path):
    """Following them would end the process."""
    offsets = pa.array([0, 10**9, 6], pa.int32()).buffers()[1]
    one = pa.Array.from_buffers(
        pa.list_(pa.float64()), 2, [None, offsets], children=[pa.array([1.0] * 6)]
    )
    write(pa.table({"force": one}), tmp_path / "log.arrow")
    with pytest.raises(InputError, match="cannot be read as Arrow"):
        read_log(tmp_path / "log.arrow")


def test_repeated_names_are_refused(frame, tmp_path):
    values = pa.Table.from_pandas(frame)
    write(values.append_column("fx", values["fx"]), tmp_path / "log.arrow")
    with pytest.raises(InputError, match="'fx' is there 2 times"):
        read_log(tmp_path / "log.arrow")


def test_small_files_of_much_are_refused_before_they_are_unpacked(
    tmp_path, monkeypatch
):
    """75 kB held 2.4 GB of zeros; nulls take no bytes; 960 kB of views on one list were
    written out in more than 7 GB."""
    monkeypatch.setattr("hefting.logs.table.MAX_CELLS", 100_000)
    path = tmp_path / "log.feather"
    zeros = pa.table({f"c{k}": np.zeros(10_000) for k in range(11)})
    feather.write_feather(zeros, str(path), compression="zstd")
    assert path.stat().st_size < 1e4
    with pytest.raises(InputError, match="more than 100,000 numbers"):
        read_log(path)
    write(pa.table({"time": pa.nulls(2**31 - 1)}), path)
    with pytest.raises(InputError, match="more than 100,000 numbers"):
        read_log(path)
    ends = pa.array([2**31 - 1], pa.int32())
    runs = pa.RunEndEncodedArray.from_arrays(ends, pa.array([1.0]))
    with ipc.new_stream(str(path), pa.schema({"time": runs.type})) as writer:
        writer.write(pa.record_batch({"time": runs}))
    with pytest.raises(InputError, match="more than 100,000 numbers"):
        read_log(path)


@pytest.mark.parametrize("name", ["log.feather", "log.arrow"])
def test_long_lists_are_not_written_out(frame, read, tmp_path, name):
    """Neither nested ones nor overlapping views, nor lists of nulls."""
    values = pa.Table.from_pandas(frame, preserve_index=False)
    count = len(values)
    many = pa.array(np.zeros(100_000))
    at = pa.array(np.zeros(count, np.int32))
    views = pa.ListViewArray.from_arrays(
        at, pa.array(np.full(count, 100_000, np.int32)), many
    )
    nulls = pa.FixedSizeListArray.from_arrays(pa.nulls(count * 10**7), 10**7)
    whole = values.append_column("views", views).append_column("nulls", nulls)
    if name == "log.arrow":
        write(whole, tmp_path / name)
    else:
        feather.write_feather(whole, str(tmp_path / name), compression="uncompressed")
    found = read_log(tmp_path / name)
    np.testing.assert_array_equal(found["wrench"].values, read["wrench"].values)

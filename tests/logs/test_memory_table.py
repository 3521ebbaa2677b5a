"""Tables in memory are read as the same table in a file: dictionaries, data frames,
structured arrays."""

import subprocess
import sys

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

from hefting.core.errors import InputError
from hefting.logs import read_log
from hefting.logs.given import as_recording
from hefting.logs.memory_table import MemoryTable
from table_of_log import WRENCH


def same(first, second, atol=0.0) -> bool:
    """Whether two recordings hold the same samples."""
    assert list(first.streams) == list(second.streams)
    for name, stream in first.streams.items():
        np.testing.assert_allclose(second[name].time, stream.time, atol=1e-9)
        np.testing.assert_allclose(
            second[name].values, stream.values, rtol=0, atol=atol
        )
    return True


FORMS = {
    "pandas": lambda frame: frame,
    "pandas, time as index": lambda frame: frame.set_index("time"),
    "pandas, nullable": lambda frame: frame.convert_dtypes(),
    "pandas, of Arrow": lambda frame: frame.convert_dtypes(dtype_backend="pyarrow"),
    "DuckDB": lambda frame: duckdb.from_df(frame),
    "pandas, object": lambda frame: frame.astype(object),
    "pandas, dates": lambda frame: frame.assign(
        time=pd.to_datetime(frame["time"], unit="s")
    ),
    "pandas, dates with zone": lambda frame: frame.assign(
        time=pd.to_datetime(frame["time"], unit="s", utc=True)
    ),
    "pandas, durations": lambda frame: frame.assign(
        time=pd.to_timedelta(frame["time"], unit="s")
    ),
    "polars": pl.from_pandas,
    "polars, dates": lambda frame: pl.from_pandas(
        frame.assign(time=pd.to_datetime(frame["time"], unit="s"))
    ),
    "Arrow": pa.Table.from_pandas,
    "dictionary of arrays": lambda frame: {k: v.to_numpy() for k, v in frame.items()},
    "dictionary of lists": lambda frame: frame.to_dict("list"),
    "structured array": lambda frame: np.asarray(frame.to_records(index=False)),
    "record array": lambda frame: frame.to_records(index=False),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_table_is_read_as_the_file_is(form, frame, read):
    assert same(read, as_recording(FORMS[form](frame)))


@pytest.mark.parametrize("form", [pd.DataFrame, pl.DataFrame, pa.Table.from_pylist])
def test_lists_and_dictionaries_in_rows_are_columns(form, frame, read):
    """As lines of JSON hold them: some lists, the orientation by x, y, z, w."""
    rows = [
        {
            "t": row[0],
            "pose": {
                "position": row[1:4].tolist(),
                "orientation": dict(zip("xyzw", row[4:8].tolist(), strict=True)),
            },
            "ft": row[8:].tolist(),
        }
        for row in frame.to_numpy()
    ]
    found = as_recording(form(rows))
    for name in ("position", "orientation", "wrench"):
        np.testing.assert_array_equal(found[name].values, read[name].values)


@pytest.mark.parametrize("form", ["pandas", "pandas, nullable", "polars", "Arrow"])
def test_blanks_mean_not_measured(form, frame, tmp_path):
    frame.loc[::3, list(WRENCH)] = None
    frame.to_parquet(tmp_path / "log.parquet")
    recording = as_recording(FORMS[form](frame))
    assert same(read_log(tmp_path / "log.parquet"), recording)
    assert len(recording["wrench"]) == 20
    assert len(recording["position"]) == 30


def test_masked_columns_and_none_are_blank(frame):
    columns = frame.to_dict("list")
    for name in WRENCH:
        columns[name] = np.ma.masked_array(columns[name], np.arange(30) % 3 == 0)
    assert len(as_recording(columns)["wrench"]) == 20
    for name in WRENCH:
        columns[name] = [v if k % 3 else None for k, v in enumerate(frame[name])]
    assert len(as_recording(columns)["wrench"]) == 20


@pytest.mark.parametrize("structured", [False, True])
def test_columns_may_be_whole_arrays(structured, frame, read):
    arrays = {
        "time": frame["time"].to_numpy(),
        "position": frame[["px", "py", "pz"]].to_numpy(),
        "orientation": frame[["qx", "qy", "qz", "qw"]].to_numpy(),
        "wrench": frame[list(WRENCH)].to_numpy(),
    }
    source = arrays
    if structured:
        widths = {name: a.shape[1:] for name, a in arrays.items()}
        source = np.empty(30, [(name, float, width) for name, width in widths.items()])
        for name, array in arrays.items():
            source[name] = array
    assert same(read, as_recording(source), atol=1e-15)
    if not structured:
        more = as_recording(arrays | {"gripper": "open"})
        assert [m.code for m in more.warnings] == ["columns-ignored"]


def test_other_columns_may_hold_anything(frame):
    recording = as_recording(frame.assign(phase="lift", when=pd.Timestamp.now()))
    assert [m.code for m in recording.warnings] == ["columns-ignored"]


def test_a_column_map_serves_frames_as_well(frame, read, tmp_path):
    path = tmp_path / "map.toml"
    path.write_text(
        'time = { column = "ms", unit = "ms" }\nposition = ["px", "py", "pz"]\n'
        'orientation = ["qx", "qy", "qz", "qw"]\n'
        'wrench = ["fx", "fy", "fz", "tx", "ty", "tz"]\n'
    )
    frame["ms"] = 1e3 * frame.pop("time")
    assert same(read, as_recording(frame, column_map=path), atol=1e-12)


BAD = {
    "a column lacks": (lambda f: f.drop(columns="fx"), "'fx' is missing beside fy"),
    "misspelled": (
        lambda f: f.rename(columns={"time": "tiem"}),
        "did you mean 'time'",
    ),
    "no wrench": (lambda f: f.drop(columns=list(WRENCH)), "there is no wrench"),
    "no orientation": (
        lambda f: f.drop(columns=["qx", "qy", "qz", "qw"]),
        "there is no orientation",
    ),
    "text": (lambda f: f.assign(fx="much"), "column 'fx' holds text, not numbers"),
    "complex": (
        lambda f: dict(f, fx=1j * f["fx"].to_numpy()),
        "'fx' holds complex128, not numbers",
    ),
    "half blank": (
        lambda f: f.assign(fx=f["fx"].mask(f.index % 3 == 1)),
        "row 1, column fx: the cell is blank, here and in 9 more rows",
    ),
    "infinite": (
        lambda f: f.assign(fx=f["fx"].mask(f.index == 7, np.inf)),
        "row 7, column fx: the value is inf",
    ),
    "no time": (
        lambda f: f.assign(time=f["time"].mask(f.index == 7)),
        "row 7, column time: the time is blank",
    ),
    "unsorted": (lambda f: f[::-1], "sort the rows by time"),
    "norm": (lambda f: f.assign(qx=2.0), "not 1; give unit quaternions"),
    "twice": (lambda f: pd.concat([f, f["fx"]], axis=1), "'fx' is there 2 times"),
    "no rows": (lambda f: f[:0], "there are no samples"),
    "no columns": (lambda f: pd.DataFrame(), "there is no wrench"),
    "empty dictionary": (lambda f: {}, "there is no wrench"),
    "lengths": (
        lambda f: dict(f, fx=f["fx"].to_numpy()[:-1]),
        "'fx' has 29 values, but 'time' has 30",
    ),
    "one number": (lambda f: dict(f, fx=1.0), r"'fx' has shape \(\), not \(K,\)"),
    "lazy": (lambda f: pl.from_pandas(f).lazy(), r"give .collect\(\)"),
    "no names": (lambda f: f.to_numpy(), "without column names is not a recording"),
    "a list": (lambda f: [1, 2], "a value of type list is not a recording"),
    "a number": (lambda f: 5, "a value of type int is not a recording"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_recording_is_refused_in_one_line(case, frame):
    make, match = BAD[case]
    with pytest.raises(InputError, match=match) as refused:
        as_recording(make(frame))
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 350


def test_no_data_frame_library_is_imported():
    code = (
        "import sys, numpy, hefting\n"
        "one = numpy.ones(9)\n"
        "q = dict(qx=0 * one, qy=0 * one, qz=0 * one, qw=one)\n"
        "w = {k: one for k in ('fx', 'fy', 'fz', 'tx', 'ty', 'tz')}\n"
        "hefting.as_recording(dict(time=numpy.arange(9) / 10, **q, **w))\n"
        "print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    assert not {"pandas", "polars", "pyarrow"} & set(done.stdout.split())


def test_a_column_of_times_goes_before_an_index_without_a_name():
    frame = pd.DataFrame({"timestamp [s]": [0.0, 0.1], "fx": [1.0, 2.0]})
    for index in (np.array([0.0, 7.0]), pd.to_datetime([0, 10**9])):
        table = MemoryTable.of(frame.set_index(pd.Index(index)))
        assert table is not None
        assert table.names == ("timestamp [s]", "fx")

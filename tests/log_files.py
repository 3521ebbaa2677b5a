"""Log files for tests: written by hand, made at random, and compared."""

import re
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from hefting.core.errors import InputError
from hefting.core.recording import COLUMNS, JOINT_STREAMS, Recording, Stream
from hefting.logs import read_log

HEADER = "time,qx,qy,qz,qw,fx,fy,fz,tx,ty,tz"
ROWS = ("0,0,0,0,1,1,2,3,4,5,6", "0.1,0,0,0,1,1,2,3,4,5,6", "0.2,0,0,0,-1,1,2,3,4,5,7")


def log(folder: Path, *lines: str, header: str = HEADER, end: str = "\n") -> Path:
    """A CSV file of these lines; those of `ROWS` fit the usual header."""
    path = folder / "log.csv"
    path.write_bytes((end.join((header, *lines)) + end).encode())
    return path


def fails(path: Path, *words: str, **options) -> None:
    """Reading gives one line that names the file and holds each of the words."""
    with pytest.raises(InputError) as caught:
        read_log(path, **options)
    check_line(str(caught.value), str(path), *words)


def mapped(path: Path, text: str) -> Recording:
    """The log at `path` through a column map of this text."""
    chosen = path.with_name("map.toml")
    chosen.write_text(text)
    return read_log(path, chosen)


def mapping_fails(path: Path, text: str, *words: str) -> None:
    """Reading through a map of this text gives one line that names either file and
    holds each of the words."""
    with pytest.raises(InputError) as caught:
        mapped(path, text)
    check_line(str(caught.value), str(path.parent), *words)


def check_line(message: str, *words: str) -> None:
    """One line, not too long, that holds each of the words."""
    assert "\n" not in message
    assert len(message) < 600
    for word in words:
        assert word in message, message


def random_recording(seed: int, static: bool = False, joints: int = 6) -> Recording:
    """All streams, each with its own irregular clock (static: all with the row's
    index)."""
    rng = np.random.default_rng(seed)
    streams = {}
    for name, columns in COLUMNS.items():
        count = 50 if static else int(rng.integers(1, 60))
        width = joints if name in JOINT_STREAMS else len(columns)
        values = rng.normal(size=(count, width)) * 10.0 ** rng.integers(
            -12, 7, (count, width)
        )
        if name == "orientation":
            values /= np.linalg.norm(values, axis=1)[:, None]
        clock = (
            np.arange(float(count))
            if static
            else np.cumsum(rng.uniform(1e-4, 0.1, count))
        )
        streams[name] = Stream(clock, values)
    return Recording(streams, static)


def same(a: Recording, b: Recording) -> bool:
    """Whether the streams are equal to the bit."""
    return (
        a.static == b.static
        and list(a.streams) == list(b.streams)
        and all(
            np.array_equal(a[name].time, b[name].time)
            and np.array_equal(a[name].values, b[name].values)
            for name in a.streams
        )
    )


def parquet_log(folder: Path, **changes) -> Path:
    """A Parquet file of `ROWS`, some columns of it changed."""
    table = dict(
        zip(
            HEADER.split(","),
            np.array([row.split(",") for row in ROWS], dtype=float).T,
            strict=True,
        )
    )
    parquet.write_table(pa.table({**table, **changes}), folder / "log.parquet")
    return folder / "log.parquet"


def timed(folder: Path, times) -> Path:
    """A CSV file of the first of `ROWS` at each of these times."""
    return log(folder, *(f"{t!r}{ROWS[0][1:]}" for t in times))


@pytest.fixture(autouse=True, params=["by NumPy", "by pyarrow"])
def reader_of_text(request, monkeypatch):
    """Each test reads text both ways: as a short file, where NumPy can, and as a long
    one."""
    if request.param == "by pyarrow":
        monkeypatch.setattr("hefting.logs.csv_file.SHORT", 0)


def refusal_time(pattern: re.Pattern[str], text: str) -> float:
    """[s] Shortest of five times that a pattern takes for a text that it refuses."""
    times = []
    for _ in range(5):
        began = time.perf_counter()
        assert pattern.fullmatch(text) is None
        times.append(time.perf_counter() - began)
    return min(times)

"""Windows: a table as consecutive recordings that hold each sample once."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import NOISE, body
from hefting import InputError, read_log, write_log
from hefting.core import files
from hefting.logs import windows as module
from hefting.logs.windows import needs_windows, windows
from hefting.simulation import UR5, random_smooth, simulate

ROWS = 500


@pytest.fixture(scope="module", params=[".csv", ".parquet"])
def path(request, tmp_path_factory):
    """Twenty-four seconds at 100 Hz, the wrench at half of that: 2,400 rows."""
    motion = UR5.motion(random_smooth(24.0, 100.0, 1.2, seed=5))
    log = simulate(motion, body(1.3), noise=NOISE, seed=5)
    wrench = log["wrench"]
    half = replace(
        wrench, time=wrench.time[::2], values=wrench.values[::2], rows=wrench.rows[::2]
    )
    path = tmp_path_factory.mktemp("windows") / f"log{request.param}"
    write_log(replace(log, streams={**log.streams, "wrench": half}), path)
    return path


@pytest.fixture
def short(monkeypatch):
    """Windows may be shorter than they are for good."""
    monkeypatch.setattr(module, "FEWEST_ROWS", 100)


@pytest.mark.parametrize("rows", [ROWS, 600, 700, 2400, 5000])
def test_each_sample_is_in_one_window(path, short, rows):
    whole = read_log(path)
    parts = list(windows(path, rows=rows))
    for name, stream in whole.streams.items():
        each = [part[name] for part in parts]
        for field in ("time", "values", "rows"):
            joined = np.concatenate([getattr(one, field) for one in each])
            np.testing.assert_array_equal(joined, getattr(stream, field))
    sizes = [len(part["position"]) for part in parts]
    assert max(sizes) <= rows
    assert min(sizes) >= 0.5 * max(sizes)
    if rows > 2400:
        assert len(parts) == 1


def test_a_window_lasts_as_long_as_asked(path, short):
    parts = list(windows(path, seconds=6.0))
    assert [round(part.duration, 1) for part in parts] == [6.0] * 4
    first = read_log(path)["position"].rows[0]
    assert parts[0].source == f"{path}, rows {first} to {first + 599}"
    assert len({part.source for part in parts}) == 4


def test_no_window_is_shorter_than_its_fewest_rows(path):
    """A thousand, and twice half of what is left."""
    sizes = [len(part["position"]) for part in windows(path, seconds=0.1)]
    assert sizes == [1000, 700, 700]


def test_a_column_map_is_followed(path, short, tmp_path):
    column_map = tmp_path / "map.toml"
    column_map.write_text(
        'time = { column = "time", unit = "ms" }\n'
        'position = { columns = ["px", "py", "pz"], unit = "mm" }\n'
        'orientation = ["qx", "qy", "qz", "qw"]\n'
        'wrench = ["fx", "fy", "fz", "tx", "ty", "tz"]\n'
    )
    parts = list(windows(path, column_map, rows=600))
    whole = read_log(path, column_map)
    np.testing.assert_array_equal(
        np.concatenate([part["position"].values for part in parts]),
        whole["position"].values,
    )
    assert parts[-1]["position"].time[-1] == whole["position"].time[-1]


def test_what_is_said_of_the_clock_is_said_once(short, tmp_path):
    """Times since 1970 are shifted in each window, by as much as each needs."""
    log = simulate(UR5.motion(random_smooth(12.0, 100.0, 1.2)), body(1.3), noise=NOISE)
    late = {k: replace(s, time=s.time + 1.7e9) for k, s in log.streams.items()}
    write_log(replace(log, streams=late), tmp_path / "log.parquet")
    parts = list(windows(tmp_path / "log.parquet", rows=400))
    said = [[m.code for m in part.warnings] for part in parts]
    assert said == [["time-shifted"], [], []]
    assert all(part.start == 0.0 for part in parts)


def test_a_table_of_any_size_is_read(path, short, monkeypatch):
    monkeypatch.setattr(files, "MAX_BYTES", 1000)
    with pytest.raises(InputError, match="more than 2 GiB"):
        read_log(path)
    assert len(list(windows(path, rows=600))) == 4


def test_a_bad_cell_is_named_in_its_window(path, short, tmp_path):
    if path.suffix != ".csv":
        return
    lines = path.read_text().splitlines()
    lines[1500] = lines[1500].replace(",", ",x", 1)
    bad = tmp_path / "bad.csv"
    bad.write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match="row 1501"):
        list(windows(bad, rows=600))


def test_what_has_no_windows_is_refused(tmp_path):
    bag = tmp_path / "log.mcap"
    bag.write_bytes(b"nothing")
    with pytest.raises(InputError, match="only CSV or Parquet is read window by"):
        next(windows(bag))
    with pytest.raises(InputError, match="does not exist"):
        next(windows(tmp_path / "none.csv"))
    empty = tmp_path / "empty.csv"
    empty.write_text("time,px,py,pz,qx,qy,qz,qw,fx,fy,fz,tx,ty,tz\n")
    with pytest.raises(InputError, match="no samples"):
        next(windows(empty))
    empty.write_text("time,px\n1,2\n")
    with pytest.raises(InputError, match="wrench"):
        next(windows(empty))


def test_only_what_is_large_needs_windows(path, monkeypatch, tmp_path):
    assert not needs_windows(path)
    assert not needs_windows(tmp_path / "none.csv")
    assert not needs_windows(tmp_path)
    count = 2400 * 14
    monkeypatch.setattr(module, "LARGEST_WHOLE", 0.9 * count)
    assert needs_windows(path)
    monkeypatch.setattr(module, "LARGEST_WHOLE", 1.1 * count)
    assert not needs_windows(path)

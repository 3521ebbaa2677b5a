"""How fast canonical files are read, and recordings of others."""

import time

import numpy as np
import pytest
from pyarrow import csv as pacsv

from hefting.core.recording import COLUMNS, Recording, Stream
from hefting.logs import read_log, write_log
from log_files import (
    same,
)
from recordings import DATA, LOGS, needs_recordings


def test_reading_costs_little_more_than_parsing(tmp_path):
    rng = np.random.default_rng(0)
    count = 20_000
    orientation = rng.normal(size=(count, 4))
    orientation /= np.linalg.norm(orientation, axis=1)[:, None]
    clock = np.arange(count) / 1000
    names = ("position", "wrench", "gyroscope", "accelerometer")
    streams = {
        name: Stream(clock, rng.normal(size=(count, len(COLUMNS[name]))))
        for name in names
    }
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


@needs_recordings
def test_every_recording_of_others_is_read_and_survives_a_round_trip(tmp_path):
    for path in LOGS:
        got = read_log(path)
        assert got.warnings == ()
        assert got.has("orientation", "wrench")
        assert got.static == (path.stem in ("static_poses", "poses7"))
        write_log(got, tmp_path / "log.parquet")
        assert same(read_log(tmp_path / "log.parquet"), got)


@needs_recordings
def test_recordings_of_others_hold_what_they_should():
    for name in ("baseline", "vibrations"):
        kuka = read_log(DATA / "kuka-ati" / f"{name}.csv")
        # nominal rates of its description, rounded to 1 Hz
        assert kuka.rates() == pytest.approx(
            {"orientation": 100, "wrench": 698, "accelerometer": 254}, abs=1
        )
        # as described, to a decimal
        assert kuka.duration == pytest.approx(6.3, abs=0.05)
    first = read_log(DATA / "kuka-ati" / "baseline.csv")
    assert first["wrench"].rows[:3].tolist() == [3, 4, 6]
    assert first["orientation"].rows[:2].tolist() == [2, 12]
    assert len(read_log(DATA / "kuka-ati" / "static_poses.csv")["wrench"]) == 24
    assert len(read_log(DATA / "axia80" / "poses7.csv")["wrench"]) == 7
    assert read_log(DATA / "axia80" / "dwells.csv").rates()["wrench"] == pytest.approx(
        10, rel=0.01
    )
    panda = read_log(DATA / "panda-optoforce" / "run1.csv")
    assert list(panda.streams) == [
        "position",
        "orientation",
        "wrench",
        "gyroscope",
        "linear_accelerometer",
    ]
    assert panda.rates()["wrench"] == pytest.approx(1000, rel=0.01)
    tool = read_log(DATA / "workshop-tools" / "ruler" / "log.csv")
    assert tool.has(
        "linear_velocity",
        "angular_velocity",
        "linear_acceleration",
        "angular_acceleration",
    )
    assert len(tool["wrench"]) == 1000

"""Dates, times of day and indices of data frames for times."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pandas as pd
import pytest

import hefting
from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.logs import read_log
from known_rows import (
    CANONICAL,
    LINES,
    PLAIN,
    ROWS,
    TIME,
    WRENCH,
    frame_of,
    same,
    text_of,
)


@pytest.mark.parametrize("zone", ["", "Z", "+01:00"])
@pytest.mark.parametrize("between", ["T", " "])
def test_dates_are_times(tmp_path, zone, between):
    began = datetime(2026, 1, 31, 23, 59, 59, 900000, tzinfo=UTC)
    dates = [
        (began + timedelta(seconds=t)).strftime(f"%Y-%m-%d{between}%H:%M:%S.%f") + zone
        for t in TIME
    ]
    lines = [
        f"{date},{line.partition(',')[2]}"
        for date, line in zip(dates, LINES[1:], strict=True)
    ]
    path = tmp_path / "log.csv"
    path.write_text("\n".join((LINES[0], *lines)))
    assert same(read_log(path))
    path.write_text("\n".join((LINES[0], *lines[:9], "soon" + lines[9][4:])))
    with pytest.raises(
        InputError, match=r"row 11, column time: 'soon.*is no date like"
    ):
        read_log(path)


WAYS = {"%d.%m.%Y %H:%M:%S.%f": "timestamp", "%H:%M:%S.%f": "Time"}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("block", [2**20, 1500])
def test_dates_with_the_day_first_and_times_of_day(tmp_path, monkeypatch, way, block):
    """Which go on past midnight, in whatever block."""
    monkeypatch.setattr("hefting.logs.csv_file.READ", block)
    began = datetime(2026, 1, 31, 23, 59, 59, 900000, tzinfo=UTC)
    times = [(began + timedelta(seconds=t)).strftime(way) for t in TIME]
    frame = frame_of(" ".join(CANONICAL), PLAIN).assign(time=times)
    path = tmp_path / "log.csv"
    frame.rename(columns={"time": WAYS[way]}).to_csv(path, index=False)
    assert same(read_log(path))


@pytest.mark.parametrize("name", ["when", "记录", "#", "Timestamp"])
@pytest.mark.parametrize("step", [0.01, 0.5, 2.0])
def test_dates_are_the_time_by_whatever_name(tmp_path, name, step):
    """Those of static poses tell that they are such."""
    began = datetime(2026, 1, 31, 23, 59, 59, 900000, tzinfo=UTC)
    times = [(began + timedelta(seconds=step * k)).isoformat() for k in range(ROWS)]
    frame = frame_of(" ".join(CANONICAL), PLAIN).assign(time=times)
    path = tmp_path / "log.csv"
    frame.rename(columns={"time": name}).to_csv(path, index=False)
    got = read_log(path)
    assert got.static == (step > 1.0)
    if not got.static:
        assert got.duration == pytest.approx(step * (ROWS - 1))


def test_of_a_time_that_is_not_read_it_is_said_what_is(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(f"{LINES[0]}\n3-Apr-2026 13:31:07,{LINES[1].partition(',')[2]}")
    with pytest.raises(InputError, match=r"in seconds, or as 2026-01-31T12:00:00.000"):
        read_log(path)


@pytest.mark.parametrize("date", ["2026-13-41T12:00:00", "9999-12-31T12:00:00"])
def test_a_date_that_cannot_be_is_named(tmp_path, date):
    """The first of all is no date at all, so that its column is one of numbers."""
    dates = [f"2026-01-31T12:00:0{k}" for k in range(10)]
    lines = [
        f"{d},{line.partition(',')[2]}"
        for d, line in zip(dates, LINES[1:], strict=False)
    ]
    path = tmp_path / "log.csv"
    for row, words in ((4, "is no date like"), (2, "is not a number")):
        wrong = [LINES[0], *lines]
        wrong[row - 1] = f"{date},{LINES[row - 1].partition(',')[2]}"
        path.write_text("\n".join(wrong))
        with pytest.raises(
            InputError, match=f"row {row}, column time: '{date}' {words}"
        ):
            read_log(path)


@pytest.mark.parametrize("kind", ["date", "date with a zone", "duration"])
def test_times_of_pandas_in_parquet(tmp_path, kind):
    frame = frame_of(" ".join(CANONICAL), PLAIN)
    time = pd.to_timedelta(frame["time"], unit="s")
    if kind != "duration":
        time = pd.Timestamp("2026-01-31T12:00") + time
    if kind == "date with a zone":
        time = time.dt.tz_localize("Europe/Berlin")
    frame.assign(time=time).to_parquet(tmp_path / "log.parquet")
    assert same(read_log(tmp_path / "log.parquet"))


def test_the_index_of_a_frame_is_its_time(tmp_path):
    """Where it grows by more than rows do."""
    frame = frame_of(" ".join(CANONICAL), PLAIN)
    frame.drop(columns="time").set_index(TIME).to_csv(tmp_path / "log.csv")
    assert same(read_log(tmp_path / "log.csv"))
    frame.to_csv(tmp_path / "log.csv")  # 0, 1, 2 in front of the time
    got = read_log(tmp_path / "log.csv")
    assert same(got)
    assert codes(got.warnings) == {"columns-ignored"}


INDICES = {
    "dates": pd.Timestamp("2026-01-31T23:59:59.9") + pd.to_timedelta(TIME, unit="s"),
    "numbers": pd.Index(2.0 + TIME),
    "a name": pd.Index(TIME, name="stamp"),
}


@pytest.mark.parametrize("case", INDICES)
def test_the_index_of_a_frame_is_its_time_in_memory_and_in_parquet(tmp_path, case):
    frame = frame_of(" ".join(CANONICAL), PLAIN).drop(columns="time")
    frame = frame.set_index(INDICES[case])
    frame.to_parquet(tmp_path / "log.parquet")
    for got in (hefting.as_recording(frame), read_log(tmp_path / "log.parquet")):
        assert same(got)


def test_an_index_of_picked_rows_is_no_time(tmp_path):
    frame = frame_of(" ".join(CANONICAL), PLAIN).drop(columns="time")
    frame = frame[frame["fx"] > 0.0]
    frame.to_parquet(tmp_path / "log.parquet")
    for got in (hefting.as_recording(frame), read_log(tmp_path / "log.parquet")):
        assert got.static


def test_dates_of_1970_and_decimal_commas_beside_dates(tmp_path):
    """The first of all is zero seconds, and dates keep their point."""
    lines = text_of(";", ",")
    rows = [
        f"1970-01-01T00:00:{0.25 * k:06.3f};{line.partition(';')[2]}"
        for k, line in enumerate(lines[1:])
    ]
    path = tmp_path / "log.csv"
    path.write_text("\n".join((lines[0], *rows)))
    got = read_log(path)
    assert got["wrench"].time.tolist() == (0.25 * np.arange(ROWS)).tolist()
    assert got["wrench"].values.tolist() == WRENCH.tolist()
    path.write_text("\n".join((lines[0], *rows[:5], rows[5].replace("0,", "0.5,", 1))))
    with pytest.raises(InputError, match=r"row 7, column .*is not a number"):
        read_log(path)

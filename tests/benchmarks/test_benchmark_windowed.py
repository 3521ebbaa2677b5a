"""The benchmark of windows: a short recording through all of its steps."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from benchmarks import windowed  # noqa: E402


def test_a_recording_in_windows(tmp_path, monkeypatch):
    """5 s of the motion at 1 kHz, written in blocks that are no windows."""
    from hefting.logs import windows

    monkeypatch.setattr(windowed, "BLOCK", 3_000)
    monkeypatch.setattr(
        windows.windows, "__kwdefaults__", {"seconds": 5.0, "rows": 5000}
    )
    path = tmp_path / "log.parquet"
    windowed.write(10_000, path)
    alone, parts = windowed.whole(path), windowed.windowed(path)
    assert parts["samples"] == pytest.approx(alone["samples"], abs=20)
    assert parts["parts"] == 2
    for found in (alone, parts):
        assert abs(found["mass_error"]) < 2.0 * found["half_mass"]

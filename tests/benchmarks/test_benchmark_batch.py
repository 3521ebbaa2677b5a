"""The benchmarks of batches, small: every recording has the row it should have."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from benchmarks import batch, batch_memory  # noqa: E402


def test_whole_and_broken_recordings(tmp_path, capsys):
    batch.run(tmp_path, 5, kills=0)
    told = capsys.readouterr().out
    assert told.count("0 wrong []") == 2
    assert told.count("1 failed") == 2


def test_a_missing_answer_is_seen(tmp_path):
    manifest, _ = batch.write_all(tmp_path, 3, 1)
    manifest.write_text("recording\n000001.csv\n")
    from hefting.batches import batch as run

    run(manifest, tmp_path / "r", jobs=1)  # without a shape the mass is found as well
    assert batch.wrong_rows(tmp_path / "r", 3) == [
        "1 rows",
        "0: not there",
        "2: not there",
    ]


def test_memory_over_rows(monkeypatch):
    """Of so few rows it says nothing; all are there."""
    monkeypatch.setattr(batch_memory, "FIRST", 100)
    assert batch_memory.grown(300)["rows"] == 300

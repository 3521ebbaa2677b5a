"""The benchmarks of batches, small: every recording has the row it should have."""

import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from benchmarks import batch, batch_memory  # noqa: E402
from jobs_here import do_jobs_here  # noqa: E402

COUNT = 3


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A folder after the benchmark, in this process, and what that printed."""
    folder, told = tmp_path_factory.mktemp("batch"), StringIO()
    with pytest.MonkeyPatch.context() as monkeypatch, redirect_stdout(told):
        do_jobs_here(monkeypatch)
        batch.run(folder, COUNT, kills=0)
    return folder, told.getvalue()


def test_whole_and_broken_recordings(done):
    _, told = done
    assert told.count("0 wrong []") == 2
    assert told.count("1 failed") == 2


def test_a_missing_answer_is_seen(done):
    """The table of three recordings where there should be five."""
    outputs = {path.parent for path in done[0].glob("*/*.parquet")}
    assert len(outputs) == 2
    for output in outputs:
        assert batch.wrong_rows(output, COUNT + 2) == [
            f"{COUNT} rows",
            f"{COUNT}: not there",
            f"{COUNT + 1}: not there",
        ]


def test_memory_over_rows(monkeypatch):
    """Of so few rows it says nothing; all are there."""
    do_jobs_here(monkeypatch)
    monkeypatch.setattr(batch_memory, "FIRST", 100)
    assert batch_memory.grown(300)["rows"] == 300

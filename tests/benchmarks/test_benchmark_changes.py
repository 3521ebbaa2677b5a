"""The benchmark of changes: that its recordings are what it says, and a quick run."""

from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.changes import event_row, main, quiet_row, run, runs
from benchmarks.changing import (
    CLEAN,
    EVENTS,
    LEVELS,
    MASSES,
    MISFITS,
    MOTIONS,
    case,
)

from hefting.ingest.changes.stretches import Changes, Stretch, Touch


@pytest.mark.parametrize("kind", EVENTS)
def test_an_event_is_what_its_kind_says(kind: str):
    """Within the range of times that is promised, of bodies of the range of masses; the
    body changes unless something touches it."""
    for seed in range(4):
        true = case(kind, seed)
        assert true.motion in MOTIONS
        assert true.level in LEVELS
        assert true.time is not None
        duration = true.recording.duration
        assert 0.2 * duration <= true.time <= 0.8 * duration + 0.01
        before, after = true.bodies
        assert MASSES[0] * 0.09 <= before.mass <= MASSES[1] * 1.2
        changed = not np.array_equal(before.vector, after.vector)
        assert changed == (kind != "touched")
        assert (true.end is not None) == (kind == "touched")
        if kind == "slipped":
            assert after.mass == pytest.approx(before.mass)


def test_a_case_is_the_same_for_the_same_seed():
    one, other = (case("swapped", 7).recording["wrench"].values for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_what_counts_as_found():
    true = case("swapped", 7)
    assert true.time is not None
    at = true.time
    one = Stretch(0.0, at + 0.1, 1.0, None, "swapped", bare=False)
    other = Stretch(at + 0.5, at + 9.0, 2.0, None, None, bare=False)
    found = run(true, Changes((one, other), (), 20.0))
    assert found.found
    assert found.named
    assert found.error == pytest.approx(0.3)
    assert found.held
    touched = run(true, Changes((one,), (Touch(at + 0.1, 20.0),), 20.0))
    assert touched.found
    assert not touched.named
    missed = run(true, None)
    assert not missed.told
    assert not missed.found


def test_a_quick_run():
    """Seven events, all of which are found, as nine tenths of two hundred: where half
    were, all would be in 1 of 128 runs; and none in twelve recordings without."""
    events = list(runs(EVENTS, 7, 3))
    assert all(r.found for r in events)
    assert event_row("all", events).split()[:2] == ["all", "7"]
    quiet = list(runs(CLEAN, 12, 3))
    assert not any(r.told for r in quiet)
    assert quiet_row("all", quiet).split() == ["all", "12", "0"]


def test_the_tables(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    """A row of each kind; nothing is looked for in the recordings."""
    monkeypatch.setattr(
        "hefting.ingest.condition", lambda recording: SimpleNamespace(changes=None)
    )
    arguments = ("--events", "5", "--clean", "6", "--misfits", "6")
    monkeypatch.setattr("sys.argv", ["changes", *arguments])
    main()
    said = capsys.readouterr().out
    for name in ("all", *EVENTS, *CLEAN, *MISFITS):
        assert f"\n{name} " in said
    assert said.count("\nclean ") == 2  # the title of a table, and a row
    assert said.splitlines()[1].split()[:3] == ["all", "5", "0.0"]

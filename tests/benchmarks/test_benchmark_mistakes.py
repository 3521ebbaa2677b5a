"""Quick runs of the mistakes and of clean recordings."""

from functools import cache

import pytest
from benchmarks.mistaken import mistakes as catalogue

from benchmarks import clean, mistake_runs, mistakes, two_mistakes

pytestmark = pytest.mark.usefixtures("same_recordings")


def test_half_a_turn_is_named_and_not_to_be_used(monkeypatch):
    """One recording of each strength, with and without a shape; of four seconds, which
    tell as much of a turn as ten."""
    monkeypatch.setattr("benchmarks.given.DURATION", 4.0)
    # what is kept of recordings of ten seconds, and for them
    again = cache(mistake_runs._answer_to_correct.__wrapped__)
    monkeypatch.setattr(mistake_runs, "_answer_to_correct", again)
    said = mistakes.run(1, "turned about x")
    assert len(said) == 4
    assert all(each.named for each in said)
    assert not any(each.beyond and each.verdict == "good" for each in said)
    halves = [each for each in said if each.strength == "180°"]
    assert {each.verdict for each in halves} == {"do not use"}
    text = "\n".join((*mistakes.table(said), *mistakes.totals(said)))
    assert "| turned about x | 180° | 2 of 2 |" in text
    assert "named, of those that data can tell: 100.0 % of 4" in text


def test_two_mistakes_are_both_named(monkeypatch):
    """One pair, and what the table says of it."""
    monkeypatch.setattr("benchmarks.given.DURATION", 4.0)
    again = cache(mistake_runs._answer_to_correct.__wrapped__)
    monkeypatch.setattr(mistake_runs, "_answer_to_correct", again)
    found = two_mistakes.run(1, "turned about z, 30° + quaternion order, w first")
    assert [each.named for each in found] == [2]
    assert found[0].said.verdict == "do not use"
    text = "\n".join((*two_mistakes.totals(found), *two_mistakes.table(found)))
    assert "both named: 100.0 %" in text
    assert "wrong, and good: 0" in text
    assert "w first |" not in text


def test_the_pairs_are_of_mistakes_in_the_catalogue():
    keys = {(mistake.name, mistake.strength) for mistake in catalogue()}
    assert set(two_mistakes.COMMON) <= keys


def test_there_are_at_least_sixty_mistakes_each_once():
    keys = [(mistake.name, mistake.strength) for mistake in catalogue()]
    assert len(keys) == len(set(keys)) >= 60


def test_clean_recordings_are_good():
    """One of each motion but the slowest to make; the second level of noise."""
    found = [clean.verdict(number) for number in (10, 13, 16, 18)]
    assert {each.level for each in found} == {"good"}
    assert not clean.doubted(found)

"""The pump delivers what a source gives, connects again with growing pauses, and ends
with what ended the source."""

import threading
import time
from collections import Counter

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.messages import note
from hefting.online.samples import EndOfSource, Samples, Source, SourceLostError
from hefting.sources import live as module
from hefting.sources.live import Pump


def some(k: int, stream="wrench", width=6) -> Samples:
    return Samples(stream, np.array([float(k)]), np.full((1, width), float(k)))


class Script:
    """A source that does what a list says: samples, an error to raise, or "refuse" for
    the next attempt to open it."""

    def __init__(self, *steps):
        self.name, self.steps = "a script", list(steps)
        self.chosen = (note("live-source", "a script is read"),)
        self.skipped: Counter[str] = Counter()
        self.calls: list[str] = []
        self.opened: list[float] = []

    def open(self):
        self.calls.append("open")
        self.opened.append(time.monotonic())
        if self.steps and self.steps[0] == "refuse":
            self.steps.pop(0)
            raise InputError("cannot be reached", self.name, "start it")

    def read(self, timeout):
        if not self.steps:
            time.sleep(0.001)
            return []
        step = self.steps.pop(0)
        if isinstance(step, Exception):
            raise step
        return [step]

    def close(self):
        self.calls.append("close")


def pumped(source, patience=5.0):
    """What came of a source until it ended: samples, messages, the pump."""
    assert isinstance(source, Source)
    found, said = [], []
    with Pump(source, found.append, said.append, patience) as pump:
        assert pump.wait(20)
    return found, said, pump


def test_samples_come_in_order_until_the_end():
    found, said, pump = pumped(Script(*map(some, range(50)), EndOfSource("over")))
    assert [int(each.time[0]) for each in found] == list(range(50))
    assert (pump.state, pump.error, pump.counts["samples"]) == ("ended", None, 50)
    assert [message.code for message in said] == ["live-source"]
    assert pump.source.calls == ["open", "close"]


def test_what_cannot_be_is_left_out_and_counted():
    bad = some(1)._replace(values=np.full((1, 6), np.nan))
    found, _, pump = pumped(Script(some(0), bad, some(2), EndOfSource("over")))
    assert [int(each.time[0]) for each in found] == [0, 2]
    assert pump.source.skipped == {"values that are not finite": 1}


def test_a_source_that_falls_silent_is_told_until_it_gives_again(monkeypatch):
    monkeypatch.setattr(module, "SILENT", 0.05)
    quiet = Script(some(0), *["nothing"] * 20, some(1), some(2), EndOfSource("over"))
    read = quiet.read

    def slowly(timeout):
        found = read(timeout)
        if found == ["nothing"]:
            time.sleep(0.01)
            return []
        return found

    quiet.read = slowly
    found, said, _ = pumped(quiet)
    assert len(found) == 3
    codes = [message.code for message in said]
    assert codes == ["live-source", "source-silent", "source-back"]


def test_a_lost_source_is_connected_again_with_growing_pauses(monkeypatch):
    monkeypatch.setattr(module, "SHORTEST_WAIT", 0.02)
    monkeypatch.setattr(module, "LONGEST_WAIT", 0.08)
    lost = SourceLostError("a script: gone")
    refusals = ["refuse"] * 4
    source = Script(some(0), lost, *refusals, some(1), lost, some(2), EndOfSource("x"))
    found, said, pump = pumped(source)
    assert [int(each.time[0]) for each in found] == [0, 1, 2]
    codes = [message.code for message in said]
    assert codes == ["live-source", *["source-lost", "source-back"] * 2]
    assert pump.counts["lost"] == 2
    pauses = np.diff(source.opened)
    # waits of 0.02, 0.04, then 0.08 s; after a success the shortest again
    assert (pauses[:5] >= [0.02, 0.04, 0.08, 0.08, 0.08]).all()


def test_an_error_at_the_first_attempt_ends_it():
    _, _, pump = pumped(Script("refuse"))
    assert pump.state == "failed"
    assert isinstance(pump.error, InputError)


def test_any_error_ends_it_and_is_kept():
    _, _, pump = pumped(Script(some(0), ZeroDivisionError("bug")))
    assert pump.state == "failed"
    assert isinstance(pump.error, ZeroDivisionError)
    assert pump.source.calls[-1] == "close"


def test_silence_at_first_is_an_error_that_says_what_to_check():
    _, _, pump = pumped(Script(), patience=0.05)
    assert "nothing arrives for 0.05 s" in str(pump.error)
    assert "check that" in str(pump.error)


def test_silence_with_bad_messages_says_why_they_are_bad():
    source = Script()
    source.skipped["not a JSON object"] = 7
    _, _, pump = pumped(source, patience=0.05)
    assert "7 skipped (not a JSON object)" in str(pump.error)


def test_a_source_that_ends_with_nothing_but_bad_messages_says_so():
    source = Script(EndOfSource("over"))
    source.skipped["not a JSON object"] = 7
    _, _, pump = pumped(source)
    assert pump.state == "failed"
    assert "7 skipped (not a JSON object)" in str(pump.error)
    # one sample that could be read is a stream, however short
    source = Script(some(0), EndOfSource("over"))
    source.skipped["not a JSON object"] = 7
    assert pumped(source)[2].error is None


def test_later_silence_is_none_of_its_business():
    source = Script(some(0))
    with Pump(source, lambda samples: None, patience=0.02) as pump:
        assert not pump.wait(0.2)
        assert pump.state == "open"
    assert pump.state == "ended"


def test_close_ends_the_thread_also_while_it_connects_again():
    source = Script(SourceLostError("gone"), *["refuse"] * 1000)
    before = threading.active_count()
    with Pump(source, lambda samples: None) as pump:
        time.sleep(0.05)
        assert pump.state == "lost"
    assert threading.active_count() == before
    assert pump.error is None


def test_an_error_of_who_takes_samples_ends_it():
    def deliver(samples):
        raise InputError("cannot be written", "log.mcap")

    with Pump(Script(some(0)), deliver) as pump:
        assert pump.wait(5)
    with pytest.raises(InputError, match="cannot be written"):
        raise pump.error

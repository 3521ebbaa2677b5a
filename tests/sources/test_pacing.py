"""What comes often is taken together, at most so many times a second."""

import time
from collections import Counter

import pytest

from hefting.logs.ros.source import Topic
from hefting.sources.pacing import GATHERING, Pace
from hefting.sources.request import Request
from hefting.sources.ros_source import RosSource


def test_looks_are_apart():
    pace = Pace()
    begin = time.monotonic()
    pace.wait()  # the first at once, if not for other work: nothing to measure
    for _ in range(3):
        pace.wait()
    assert time.monotonic() - begin >= 3 * GATHERING


def test_a_late_look_is_not_delayed(monkeypatch):
    """Time that has passed anyhow counts."""
    slept = []
    monkeypatch.setattr(time, "sleep", slept.append)
    pace, now = Pace(), [10.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    for passed in (0.0, GATHERING / 4, GATHERING, 5.0):
        now[0] += passed
        pace.wait()
    assert slept == pytest.approx([0.0, 0.75 * GATHERING, 0.0, 0.0], abs=1e-12)


class Told:
    """A transport that notes when it is asked."""

    def __init__(self):
        self.topics: list[Topic] = []
        self.skipped: Counter[str] = Counter()
        self.asked: list[float] = []

    def connect(self, wants):
        """Nothing to connect."""

    def receive(self, timeout):
        self.asked.append(time.monotonic())
        return []

    def close(self):
        """Nothing to close."""


def test_a_transport_is_asked_at_that_pace(monkeypatch):
    transport = Told()
    source = RosSource("told://", Request(), transport)
    monkeypatch.setattr(source, "_decoder", object())
    for _ in range(4):
        assert source.read(0.0) == []
    gaps = [b - a for a, b in zip(transport.asked, transport.asked[1:], strict=False)]
    assert sum(gaps) >= 2.5 * GATHERING  # what passes before a question differs

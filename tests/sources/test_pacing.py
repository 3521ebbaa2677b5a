"""What comes often is taken together, at most so many times a second."""

import time

import pytest

from hefting.sources import GATHERING, Pace


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

"""Streams of a live source: checked, averaged where fast, bounded."""

from collections import Counter

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.online.history import History
from hefting.online.samples import Samples, possible
from hefting.online.series import BIN, Series


def test_averages_of_a_fast_stream_lie_on_what_is_linear_in_time():
    """1 kHz with jitter, in parts of any length: means of time and value belong
    together; all rounding errors."""
    rng = np.random.default_rng(1)
    time = 1.7e9 + np.arange(2000) * 1e-3 + rng.uniform(0.0, 5e-4, 2000)
    values = np.column_stack([(time - 1.7e9) * slope for slope in (1.0, -2.0, 3.0)])
    series = Series("position", Counter())
    for part in np.array_split(np.arange(2000), np.sort(rng.integers(0, 2000, 40))):
        series.add(time[part], values[part])
    assert 0.99 * 2.0 / BIN <= len(series) <= 2.0 / BIN
    np.testing.assert_allclose(
        series.values, np.outer(series.time - 1.7e9, (1, -2, 3)), atol=2e-6
    )


def test_a_slow_stream_stays_as_it_is():
    time = np.arange(200) * 0.01
    series = Series("wrench", Counter())
    values = np.random.default_rng(2).normal(size=(200, 6))
    series.add(time, values)
    assert np.array_equal(series.time, time)
    assert np.array_equal(series.values, values)


def test_quaternions_of_either_sign_are_averaged_as_one():
    time = np.arange(1000) * 1e-3
    side = np.where(np.arange(1000) % 2, 1.0, -1.0)
    series = Series("orientation", Counter())
    series.add(time, side[:, None] * np.array([0.0, 0.6, 0.0, 0.8]))
    np.testing.assert_allclose(np.abs(series.values @ (0, 0.6, 0, 0.8)), 1.0)


def test_late_samples_are_sorted_and_repeated_ones_counted():
    skipped = Counter()
    series = Series("wrench", skipped)
    for t in (0.0, 0.01, 0.03, 0.02, 0.02, 0.04):
        series.add(np.array([t]), np.full((1, 6), t))
    assert series.time.tolist() == [0.0, 0.01, 0.02, 0.03, 0.04]
    assert series.values[:, 0].tolist() == series.time.tolist()
    assert skipped == {"repeated": 1}


@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_a_stamp_that_differs_by_rounding_is_repeated(rate):
    """In one part with its twin, at the end of one, and a part later."""
    skipped = Counter()
    series = Series("wrench", skipped)
    time = np.arange(400) / rate
    twice = np.insert(time, 301, np.nextafter(time[300], 9.0))
    for part in np.split(twice, [100, 280, 301, 310]):
        series.add(part, np.ones((len(part), 6)))
    later = np.nextafter(series.latest, 9.0)
    series.add(np.array([later]), np.ones((1, 6)))
    assert np.diff(series.time).min() > 0.5 / rate
    assert skipped.total() == 2


def mixed_by(parts) -> bool:
    """Whether wrenches, in parts as they come, are found to be of two times."""
    held = History()
    for time, values in parts:
        assert held.add(Samples("wrench", time, values)) is None
    assert held.set_back is None or held.set_back.code == "clock-set-back"
    return held.set_back is not None


@pytest.mark.parametrize("rate", [100.0, 1000.0])
@pytest.mark.parametrize("back", [0.3, 0.8037])
@pytest.mark.parametrize("count", [1, 7, 400])
def test_a_clock_that_is_set_back_by_less_than_a_second_is_told(rate, back, count):
    time = np.arange(400) / rate
    stamps = np.where(time < time[200], time, time - min(back, 0.15 * 1000 / rate))
    values = np.random.default_rng(4).normal(size=(400, 6))
    rows = np.split(np.arange(400), range(count, 400, count))
    assert mixed_by((stamps[k], values[k]) for k in rows)


def test_late_samples_and_those_that_are_sent_again_are_of_the_same_clock():
    time = np.arange(400) * 0.01
    values = np.random.default_rng(5).normal(size=(400, 6))
    rows = np.split(np.arange(400), range(20, 400, 20))
    late = [rows[k] for k in (0, 2, 1, 3, 6, 5, 4, 7)]
    for order in (late, np.repeat(np.arange(20), 2), [0, 1, 2, 0, 1, 2, 3]):
        sent = [rows[k] if np.isscalar(k) else k for k in order]
        assert not mixed_by((time[k], values[k]) for k in sent)


def test_what_cannot_be_is_counted_by_its_reason():
    skipped = Counter()
    values = np.tile([0.0, 0.0, 0.0, 1.0], (4, 1))
    values[1, 0], values[2, 3] = np.nan, 2.0
    good = possible("orientation", np.array([0, 1, 2, 1e300]), values, skipped)
    assert good.tolist() == [True, False, False, False]
    assert skipped == {"not finite": 1, "impossible": 2}
    wrench = np.outer((1.0, 1e6, 1e9), np.ones(6))  # of N, of mN, of nothing
    good = possible("wrench", np.arange(3.0), wrench, skipped)
    assert good.tolist() == [True, True, False]


def test_a_clock_is_another_only_when_several_samples_say_so():
    held = History()
    held.add(Samples("wrench", np.arange(100) * 0.01, np.zeros((100, 6))))
    one = Samples("wrench", np.array([500.0]), np.zeros((1, 6)))
    assert held.add(one) is None
    assert held.skipped == {"of another clock": 1}
    many = Samples("wrench", 500.0 + np.arange(20) * 0.01, np.zeros((20, 6)))
    assert held.add(many).code == "clock-jumped"
    assert len(held.take_all()["wrench"]) == 100
    assert held.add(many) is None
    assert held.latest == many.time[-1]
    # what is still on its way is of the clock before
    held.add(Samples("wrench", np.array([1.0]), np.zeros((1, 6))))
    assert held.skipped["of the clock before"] == 1


@pytest.mark.parametrize("count", [1, 60, 600])
@pytest.mark.parametrize("back", [1.5, 7.0])
def test_a_clock_that_begins_anew_may_pass_the_stamps_of_the_one_before(back, count):
    held = History()
    held.add(Samples("wrench", np.arange(700) * 0.01, np.zeros((700, 6))))
    time = 7.0 - back + np.arange(1000) * 0.01
    late = np.array([6.995])
    jumped = False
    for k in range(0, 1000, count):
        some = Samples(
            "wrench", time[k : k + count], np.zeros((len(time[k:][:count]), 6))
        )
        if held.add(some) is not None:
            held.take_all()
            assert held.add(Samples("wrench", late, np.zeros((1, 6)))) is None
            held.add(some)
            jumped = True
    assert jumped
    assert held.skipped["of the clock before"] == 1
    assert held.samples >= 1700 - 10
    assert held.series["wrench"].time[-1] == time[-1]


@pytest.mark.parametrize("unit", [1e6, 1e9])
@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("together", [1, 5])
def test_a_time_that_is_not_in_seconds_is_refused(unit, start, together):
    """Each sample would be of another clock, or of a time that cannot be."""
    held, time = History(), (start + np.arange(12) * 0.01) * unit
    few, more = np.split(time, [10])
    for some in np.split(few, len(few) // together):
        assert held.checked(Samples("wrench", some, np.zeros((together, 6))))
    with pytest.raises(InputError, match="give time in seconds"):
        held.checked(Samples("wrench", more, np.zeros((2, 6))))


def test_a_history_is_bounded(monkeypatch):
    monkeypatch.setattr("hefting.online.history.MOST_ROWS", 100)
    held = History()
    cut = []
    for k in range(10):
        time = k * 0.5 + np.arange(50) * 0.01
        held.add(Samples("wrench", time, np.zeros((50, 6))))
        older = held.overflow()
        cut += [] if older is None else [older]
        assert len(held.series["wrench"]) <= 100
    whole = np.concatenate([r["wrench"].time for r in [*cut, held.recording()]])
    np.testing.assert_allclose(whole, np.arange(500) * 0.01)

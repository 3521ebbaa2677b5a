"""What is said of times that do not increase."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.magnitudes import in_order
from hefting.core.recording import Recording, Stream

TIME = 0.01 * np.arange(500)


def error_of(time):
    """The error of a recording of static wrenches at these times."""
    with pytest.raises(InputError) as caught:
        Recording({"wrench": Stream(time, np.ones((len(time), 6)))}, False, "log.csv")
    return caught.value


def test_rounded_times_are_told_by_how_many_repeat():
    every = np.float64(np.float32(1.7e9 + TIME))  # one time, which tells no rate
    for time, rate in ((np.round(TIME, 1), 98), (np.floor(TIME), 100), (every, 250)):
        error = error_of(time)
        assert "repeats that of row" in error.what
        assert "write times with more digits" in error.fix
        repeats = int((np.diff(time) == 0.0).sum())
        assert error.fix.startswith(f"{repeats} of 499 do")
        # rows over the time they took, which rounding makes half a step longer
        assert f"hefting map LOG writes, time = {{ rate = {rate} }}" in error.fix


def test_times_of_arrival_take_no_more_digits():
    """Of packets that arrive when a buffer is emptied, at uneven times."""
    late = np.random.default_rng(4).exponential(0.02, len(TIME))
    error = error_of(np.maximum.accumulate(TIME + late))
    assert "more digits" not in error.fix
    assert "the sender's" in error.fix
    assert "time = { rate = 1" in error.fix


def test_a_message_that_was_logged_twice_is_one_of_two_rows():
    error = error_of(np.sort(np.append(TIME, TIME[[30, 70]])))
    assert error.fix == "keep one of the two rows"


def test_times_that_differ_by_rounding_are_one_time():
    twice = np.insert(TIME, 401, np.nextafter(TIME[400], 9.0))
    assert in_order(twice).tolist() == [*range(401), *range(402, 501)]
    assert in_order(np.array([3.0, 1.0, 2.0, 1.0])).tolist() == [1, 2, 0]
    error = error_of(twice)
    assert "they are equal but for rounding: keep one of the two rows" in error.fix
    assert error_of(1e-12 * TIME).fix == "check the unit of time"


@pytest.mark.parametrize("back", [0.2, 2.0, 2.5])
def test_a_clock_that_was_set_back_is_no_matter_of_order(back):
    time = TIME - np.where(np.arange(500) < 250, 0.0, back)
    error = error_of(time)
    assert "is before 2.49 s of row" in error.what
    assert "cut the log in two" in error.fix


def test_rows_out_of_order_are_sorted():
    swapped = TIME.copy()
    swapped[[100, 101]] = swapped[[101, 100]]
    shuffled = np.random.default_rng(0).permutation(TIME)
    for time in (swapped, TIME[::-1], shuffled):
        assert error_of(time).fix == "sort the rows by time"


@pytest.mark.parametrize(("behind", "fix"), [(10, "cut the log"), (9, "sort the rows")])
def test_a_clock_that_was_set_back_by_a_few_samples_is_rows_out_of_order(behind, fix):
    time = TIME.copy()
    time[300:] -= time[300] - time[299 - behind] - 0.005
    assert fix in error_of(time).fix

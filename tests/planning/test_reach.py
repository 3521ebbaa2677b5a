"""When an accuracy is expected, and how long it would take where it is not."""

import re

import numpy as np
import pytest

from hefting.core.accuracy import Accuracy
from hefting.planning.result import Forecast, out_of_reach, time_needed

ASKED = Accuracy.parse("com=2mm,inertia=10%")


def forecast(times, inertias, com=1e-3):
    n = len(times)
    accuracies = tuple(Accuracy(0.01, com, own) for own in inertias)
    return Forecast(
        np.array(times), np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3, 3)), accuracies
    )


def test_it_is_reached_between_two_instants():
    own = forecast([0.0, 2.0, 4.0], [np.inf, 0.15, 0.05])
    assert time_needed(own, ASKED) == pytest.approx(3.0)
    assert time_needed(forecast([0.0, 2.0], [0.05, 0.01]), ASKED) == 0.0
    assert time_needed(forecast([0.0, 2.0], [np.inf, 0.11]), ASKED) is None


def test_how_long_it_takes_follows_from_two_durations():
    """Variances n / T + f with n = 0.3, f = 0.005: 0.01 is reached after 60 s."""
    short, long = (
        forecast([0.0, T], [np.inf, (0.3 / T + 0.005) ** 0.5]) for T in (5.0, 20.0)
    )
    text = str(out_of_reach(ASKED, short, long))
    assert "out of reach within 5 s" in text
    assert "the inertia is known to" in text
    assert float(re.search(r"about (\S+) to 78 s", text)[1]) == pytest.approx(60.0)


def test_what_no_duration_reaches_is_said():
    short, long = (
        forecast([0.0, T], [np.inf, (0.3 / T + 0.02) ** 0.5]) for T in (5.0, 20.0)
    )
    assert "nor by any longer motion" in str(out_of_reach(ASKED, short, long))

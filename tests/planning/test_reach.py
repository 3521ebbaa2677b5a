"""When an accuracy is expected, and how long it would take where it is not."""

import re

import numpy as np
import pytest
from problems import BODY

from hefting.core.accuracy import Accuracy
from hefting.planning.result import Forecast, accuracy_by, out_of_reach, time_needed

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


def falling(floor, *durations):
    """Variances n / T + f with n = 0.3."""
    return [forecast([0.0, T], [np.inf, (0.3 / T + floor) ** 0.5]) for T in durations]


def said(own, kept, longer):
    return str(out_of_reach(ASKED, own, Accuracy(1e-3, 1e-9, kept), longer))


def test_how_long_it_takes_lies_between_two_durations():
    """With f = 0.005 0.01 is reached after 60 s."""
    short, *longer = falling(0.005, 5.0, 20.0, 80.0)
    text = said(short, 0.05, longer)
    assert "out of reach within 5 s" in text
    assert "the inertia is known to" in text
    assert float(re.search(r"about (\S+) to 120 s", text)[1]) == pytest.approx(60.0)


def test_only_what_no_motion_lessens_is_out_of_reach_of_any():
    short, *longer = falling(0.02, 5.0, 20.0)
    text = said(short, 0.05, longer)
    assert "nor by this motion again and again for 20 s" in text
    assert "any longer" not in text
    text = said(short, 0.12, longer)
    assert "nor by any longer motion: by a sensor's usual accuracy" in text
    assert text.count("COM") == 0  # which is reached


@pytest.mark.parametrize(
    ("parameter", "open_ones"),
    [(0, (True, True, True)), (2, (False, True, True)), (5, (False, False, True))],
)
def test_only_what_depends_on_an_open_parameter_is_open(parameter, open_ones):
    C = 1e-8 * np.eye(10)
    known = accuracy_by(C, BODY)
    C[parameter, parameter] = np.inf
    own = accuracy_by(C, BODY)
    for name, open_ in zip(
        ("mass", "center_of_mass", "inertia"), open_ones, strict=True
    ):
        expected = np.inf if open_ else getattr(known, name)
        # the draws are the same
        assert getattr(own, name) == pytest.approx(expected, rel=0.1)

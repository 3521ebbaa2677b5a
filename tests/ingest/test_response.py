"""A late wrench: through a filter, or by a delay."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.late_wrench import GRAVITY, filtered, late, motion

from hefting import Recording, identify
from hefting.ingest import filtering
from hefting.ingest import ingest as module
from hefting.ingest.ingest import ingest
from hefting.ingest.response import (
    LONGEST_LAG,
    Response,
    response_of,
)
from hefting.simulation import HeldObject, hammer
from hefting.simulation.demo import POSE

HELD = HeldObject.of(hammer(), POSE)
pytestmark = pytest.mark.usefixtures("same_poses")
SEEDS = range(8)
SHAPE, MASS = HELD.points(), HELD.parameters.mass


def recorded(lag: str, size: float, seed: int = 0) -> Recording:
    """Smooth motion of 12 s whose wrench is late by a delay, or through a filter."""
    return late(motion("smooth", 12.0, seed), lag, size, seed)[1]


def found_in(recording: Recording, monkeypatch: pytest.MonkeyPatch) -> Response | None:
    """The response that ingest finds."""
    kept: list[Response | None] = []

    def keep(*arguments) -> Response | None:
        kept.append(response_of(*arguments))
        return kept[-1]

    monkeypatch.setattr(module, "response_of", keep)
    ingest(recording, gravity=GRAVITY)
    return kept[0]


@pytest.mark.parametrize("lag", [0.2, 0.4])
def test_a_delay_is_no_filter(lag, monkeypatch):
    """Nothing is corrected: a tenth of the difference between the two at most."""
    found = found_in(recorded("delay", lag), monkeypatch)
    assert found is not None
    assert abs(found.share) < 0.1
    assert found.share_std < 0.2


@pytest.mark.usefixtures("nothing_looked_for")
def test_what_a_filter_does_to_the_mass_is_taken_back(monkeypatch):
    """Of eight recordings through a filter of 0.2 s the errors are less than a third of
    those of a delay, and seven intervals hold the mass (here all; one in twenty may
    not)."""
    errors, plain, held = [], [], []
    for seed in SEEDS:
        recording = recorded("filter", 0.2, seed)
        with monkeypatch.context() as patch:
            found = identify(recording, shape=SHAPE, gravity=GRAVITY).estimate
            low, high = found.intervals["mass"]
            held.append(low <= MASS <= high)
            errors.append(found.parameters.mass - MASS)
            patch.setattr(module, "response_of", lambda *_: None)
            found = identify(recording, shape=SHAPE, gravity=GRAVITY).estimate
            plain.append(found.parameters.mass - MASS)
    assert np.median(np.abs(errors)) < np.median(np.abs(plain)) / 3.0
    assert sum(held) >= len(held) - 1


def test_intervals_are_no_wider_for_a_delay():
    """What the residuals rule out adds less than a fifth to the interval of the mass."""
    widths = []
    for lag in (0.0, 0.4):
        recording = recorded("delay", lag, 1)
        found = identify(recording, shape=SHAPE, gravity=GRAVITY).estimate
        widths.append(np.ptp(found.intervals["mass"]))
    assert widths[1] < 1.2 * widths[0]


def test_a_short_lag_is_left_alone(monkeypatch):
    assert found_in(recorded("delay", 0.01), monkeypatch) is None


def test_the_filter_is_that_of_first_order():
    """Against SciPy's system in continuous time, ahead by the lag; steady change passes
    unchanged."""
    time, lag = np.linspace(0.0, 8.0, 400), 0.3
    # lines between samples and a sum at `INSTANTS_PER_LAG` are exact to a percent
    swing = np.array([np.sin(w * time) ** 2 for w in (0.5, 1.0, 1.5)] * 2).T
    expected = filtered(time, swing, lag)
    found = filtering.filtered(time, swing, lag)
    assert found is not None
    ahead = np.array([np.interp(time + lag, time, c) for c in expected.T]).T
    before_end = time < time[-1] - lag
    np.testing.assert_allclose(found[before_end], ahead[before_end], atol=0.01)

    steady = np.outer(time, np.arange(1.0, 7.0)) - 2.0
    np.testing.assert_allclose(filtering.filtered(time, steady, lag), steady, atol=1e-9)


def test_a_recording_too_long_for_its_lag_is_left_alone():
    time = np.linspace(0.0, 2e4, 300)
    assert filtering.filtered(time, np.ones((300, 6)), 0.03) is None
    assert filtering.filtered(time, np.ones((300, 6)), LONGEST_LAG) is None


def test_a_filter_that_the_residuals_show_is_said():
    response = Response(0.2, 0.9, 0.1, np.zeros((3, 6)), np.zeros((10, 2)))
    (message,) = response.messages()
    assert message.code == "wrench-response"
    assert "0.2 s" in message
    assert not replace(response, share_std=0.5).messages()

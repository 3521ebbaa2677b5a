"""A late wrench: through a filter, or by a delay."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.late_wrench import GRAVITY, filtered, late, motion

from disturbances import disturbed
from hefting import Recording, identify
from hefting.estimators.quadratic import least_squares
from hefting.estimators.sample_state import SampleState
from hefting.ingest import filtering
from hefting.ingest import sign_and_bias as module
from hefting.ingest.condition import condition
from hefting.ingest.ingest import ingest
from hefting.ingest.response import (
    Response,
    response_of,
)
from hefting.ingest.systematic import errors_of_drift
from hefting.logs import read_log
from hefting.simulation import HeldObject, hammer
from hefting.simulation.demo import POSE
from recordings import DATA, needs_recordings

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


@pytest.mark.usefixtures("same_recordings", "nothing_looked_for")
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


def test_the_time_constant_is_found(monkeypatch):
    """That of the filter, where a delay that fits best is 0.30 s; and of what the filter
    held when a part begins within a move nothing is left in the mass."""
    whole = late(motion("quick moves", 40.0, 0), "filter", 0.4, 0)[1]
    part = whole.slice(12.6, 9.0)
    found = found_in(part, monkeypatch)
    assert found is not None
    assert found.lag == pytest.approx(0.4, abs=0.02)
    assert found.share == pytest.approx(1.0, abs=0.06)
    estimate = identify(part, shape=SHAPE, gravity=GRAVITY).estimate
    assert estimate.mass == pytest.approx(MASS, rel=0.006)


@needs_recordings
@pytest.mark.usefixtures("nothing_looked_for")
def test_a_part_of_one_move_through_a_filter_tells_what_the_whole_does():
    """A sensor that filters with some 0.6 s. In a single move the filter's tail looked
    like a drift of the bias: masses of these parts were 3 to 13 % too small, and no
    interval held that of the whole. One in six may miss it, by little."""
    recording = read_log(DATA / "axia80" / "dwells.csv")
    whole, held = identify(recording).estimate.mass, 0
    for start in (20.0, 52.0, 80.0, 108.0, 112.0, 140.0):
        part = identify(recording.slice(start, 9.0)).estimate
        low, high = part.intervals["mass"]
        held += low < whole < high
        assert part.mass == pytest.approx(whole, rel=0.025)
    assert held >= 5


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
    assert filtering.filtered(time, np.ones((300, 6)), 0.5) is None


def test_a_filter_that_the_residuals_show_is_said():
    response = Response(0.2, 0.9, 0.1, np.zeros((3, 6)), np.zeros((10, 2)))
    (message,) = response.messages()
    assert message.code == "wrench-response"
    assert "0.2 s" in message
    assert not replace(response, share_std=0.5).messages()


def test_the_deviation_of_a_drift_is_that_of_repeated_recordings():
    """Of the same motion, with other white noise each."""
    recording, rng = disturbed("drift", 1.0, 1).recording, np.random.default_rng(5)
    wrench, found = recording["wrench"], []
    for _ in range(24):
        noise = rng.normal(size=wrench.values.shape) * (0.5, 0.5, 0.5, 0.02, 0.02, 0.02)
        noisy = replace(wrench, values=wrench.values + noise)
        streams = {**recording.streams, "wrench": noisy}
        found.append(condition(replace(recording, streams=streams), changes=False).bias)
    assert all(bias.kind == "linear" for bias in found)
    rises = np.array([bias.values[1] - bias.values[0] for bias in found])
    ratio = rises.var(axis=0, ddof=1) / np.mean([b.rise.diagonal() for b in found], 0)
    # 138 degrees of freedom: 0.12 is one standard deviation
    assert 0.64 < ratio.mean() < 1.36


def test_a_drift_that_was_removed_is_an_error_of_the_parameters():
    """What least squares changes by when a drift is larger by one deviation."""
    found = ingest(disturbed("drift", 1.0, 1).recording)
    bias, z, fit = found.conditioned.bias, found.measurements, found.fit
    assert bias.kind == "linear"
    errors = errors_of_drift(found.conditioned, z, fit)
    assert errors is not None
    slope = (z.time - z.time.mean())[:, None] / np.ptp(bias.knots)
    # far from the size of rounding; least squares is linear in the wrench
    changes = []
    for channel in np.eye(6):
        force, torque = (z.force + slope * channel[:3], z.torque + slope * channel[3:])
        more = replace(z, force=force, torque=torque)
        own = [
            least_squares(SampleState.of(each), True, fit.noise).solution[:10]
            for each in (more, z)
        ]
        changes.append(own[0] - own[1])
    J = np.array(changes).T
    expected = J @ bias.rise @ J.T
    np.testing.assert_allclose(
        errors @ errors.T, expected, rtol=1e-6, atol=1e-6 * expected.max()
    )
    constant = replace(found.conditioned, bias=replace(bias, rise=None))
    assert errors_of_drift(constant, z, fit) is None

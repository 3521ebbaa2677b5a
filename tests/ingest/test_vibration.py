"""Vibrations in what is left of a wrench: tones and bands, and what is neither."""

from typing import Any, cast

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from hefting.ingest.rivals import elastic
from hefting.ingest.rivals.elastic import Vibration

AXES = np.array((1.0, 2.0, -2.0, 0.1, 0.0, -0.2))


def of(residual, monkeypatch, rate: float = 100.0, start: float = 0.0):
    """The vibration of a residual (B, 6) at that rate."""
    time = start + np.arange(len(residual)) / rate
    monkeypatch.setattr(elastic, "_residual", lambda case: (time, residual))
    return Vibration.of(cast(Any, None))


def tone(hertz: float, count: int = 1000, rate: float = 100.0) -> np.ndarray:
    return np.sin(2.0 * np.pi * hertz * np.arange(count) / rate + 0.3)[:, None] * AXES


@pytest.mark.parametrize("hertz", [3.5, 7.3, 31.0])
@pytest.mark.parametrize("rate", [70.0, 100.0])
def test_a_tone_is_found_with_its_frequency_and_amplitude(hertz, rate, monkeypatch):
    """Whatever the clock, and beside a drift; of ten seconds to a tenth."""
    noise = 0.1 * np.random.default_rng(0).normal(size=(1000, 6)) * AXES
    drift = np.linspace(-30.0, 40.0, 1000)[:, None] * np.ones(6)
    residual = tone(hertz, rate=rate) + noise + drift
    for start in (0.0, 1000.0):
        found = of(residual, monkeypatch, rate, start)
        assert found is not None
        assert found.frequency == pytest.approx(hertz, abs=0.1)
        # of three axes: the root of the sum of their squares
        assert found.force == pytest.approx(3.0, rel=0.03)
        assert found.share == pytest.approx(1.0, abs=0.05)
    other = of(10.0 * residual, monkeypatch, rate)
    assert other is not None
    assert other.force == pytest.approx(10.0 * found.force, rel=1e-3)


def test_what_is_slow_is_no_vibration(monkeypatch):
    """Below 3 Hz; what is left besides it has its share alone."""
    for slow, told in ((0.9, True), (1.1, False)):
        found = of(tone(10.0) + slow * tone(1.0), monkeypatch)
        assert (found is not None and found.share > 0.5) == told


def test_of_too_few_blocks_nothing_is_told(monkeypatch):
    assert of(tone(10.0, 63), monkeypatch) is None
    assert of(tone(10.0, 64), monkeypatch) is not None
    assert of(np.zeros((100, 6)), monkeypatch) is None
    assert of(tone(1.0, 100, 5.0), monkeypatch, rate=5.0) is None


@pytest.mark.parametrize(
    ("low", "high", "told"), [(6.0, 15.0, True), (4.0, 35.0, False)]
)
def test_a_band_is_a_vibration_up_to_four_times_its_lowest_frequency(
    low, high, told, monkeypatch
):
    sos = butter(8, (low, high), "bandpass", fs=100.0, output="sos")
    noise = sosfilt(sos, np.random.default_rng(1).normal(size=(4000, 6)), axis=0)
    found = of(noise * AXES, monkeypatch)
    assert (found is not None) is told
    if found is not None:
        # the middle of an even band; ends of a filter are soft
        assert found.frequency == pytest.approx(0.5 * (low + high), rel=0.1)
        force = np.sqrt(2.0 * np.square(noise * AXES)[:, :3].sum(axis=1).mean())
        assert found.force == pytest.approx(force, rel=0.1)
        assert found.share == pytest.approx(1.0, abs=0.05)


def test_of_a_tone_in_noise_half_of_the_variance_decides(monkeypatch):
    """White noise is in no band of 4 to 1."""
    white = np.random.default_rng(2).normal(size=(4000, 6)) / 2.0**0.5
    axes = np.ones(6)
    wave = np.sin(2.0 * np.pi * 10.0 * np.arange(4000) / 100.0)[:, None] * axes
    for noise, told in ((0.85, True), (1.1, False)):
        # the band about the tone has 2 of 50 Hz of the noise
        found = of(wave + noise * white, monkeypatch)
        assert (found is not None) is told

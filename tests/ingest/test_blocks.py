"""Averages of a fast sensor: what they are of, and that nothing is lost by them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import median_filter

from hefting.core.measurements import Noise
from hefting.identification import identify
from hefting.ingest.blocks import (
    Blocks,
    block_starts,
    measured_blocks,
    medians,
    within_blocks,
)
from hefting.ingest.condition import condition
from hefting.ingest.free_fit import fit_freely, residuals
from hefting.ingest.ingest import ingest
from hefting.ingest.outliers import NEIGHBOURING_CELLS, _running_median
from hefting.motion import measure, sample_weights
from hefting.simulation import UR5, hammer, random_smooth, simulate


def samples(rate, seconds=1.0, seed=0):
    rng = np.random.default_rng(seed)
    time = 5.0 + np.sort(rng.uniform(0.0, seconds, round(rate * seconds)))
    return time, rng.normal(size=(len(time), 6))


@pytest.mark.parametrize("kept", [None, 0.7, 0.1])
def test_blocks_are_averages_of_what_is_kept(kept):
    time, wrench = samples(1000)
    mask = (
        np.ones(len(time), dtype=bool)
        if kept is None
        else np.random.default_rng(1).random(len(time)) < kept
    )
    blocks = Blocks.of(time, wrench, None if kept is None else mask)
    ends = np.append(blocks.starts, len(time))
    assert blocks.count.sum() == mask.sum()
    filled = np.count_nonzero(blocks.count)
    assert blocks.mean_count == pytest.approx(mask.sum() / filled)
    for b, (first, last) in enumerate(pairwise(ends)):
        chosen = (
            mask[first:last]
            if mask[first:last].any()
            else np.ones(last - first, dtype=bool)
        )
        t, y = time[first:last][chosen], wrench[first:last][chosen]
        assert np.ptp(time[first:last]) <= 0.01
        np.testing.assert_allclose(blocks.time[b], t.mean(), rtol=1e-12)
        # of times of some seconds
        np.testing.assert_allclose(blocks.variance[b], t.var(), atol=1e-12)
        np.testing.assert_allclose(blocks.wrench[b], y.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(
        medians(wrench, blocks.starts)[0], np.median(wrench[: ends[1]], axis=0)
    )
    # white noise of deviation 1: known to a few hundredths; a steady change is no part
    # of it
    steady = wrench + 50.0 * (time - time[0])[:, None]
    within = within_blocks(Blocks.of(time, steady, mask), time, steady, mask)
    np.testing.assert_allclose(
        within, np.eye(6) * (1.0 - 1.0 / blocks.mean_count), atol=0.2
    )


def test_a_slow_sensor_is_not_averaged():
    time, wrench = samples(100)
    assert block_starts(time) is None
    blocks = Blocks.of(time, wrench, time > time[3])
    assert blocks.wrench is wrench
    np.testing.assert_array_equal(blocks.count, time > time[3])
    assert not within_blocks(blocks, time, wrench).any()
    np.testing.assert_array_equal(medians(wrench, None), wrench)


def test_averages_tell_as_much_as_the_samples():
    """One arm and sensor at 1 kHz: least squares from the averages against that from
    every sample.

    Noise and weights are the same, so they differ by what averaging loses.
    """
    motion = UR5.motion(random_smooth(6.0, 1000.0, 1.5, seed=4))
    recording = simulate(
        motion,
        hammer().parameters,
        noise=Noise(0.1, 0.005),
        bias=(3, -2, 5, 0.1, 0.2, -0.1),
        seed=4,
    )
    found = ingest(recording, bias="estimate")
    conditioned = condition(recording)
    measured = measure(conditioned.corrected(recording), curves=conditioned.curves)
    noise, every = conditioned.noise, measured.measurements
    weights = sample_weights(
        conditioned.parameters, measured.motion, noise.force, noise.torque
    )
    fit = fit_freely(replace(every, weights=weights / weights.mean()), True)
    assert len(found.measurements) < 0.11 * len(every)
    assert found.counts.sum() == len(every)
    # where an estimator weighs samples against something else, an average counts as all
    # of its samples
    assert found.measurements.weights is not None
    assert found.weighted_by_count.weights is not None
    assert found.measurements.weights.sum() == pytest.approx(len(found.measurements))
    assert found.weighted_by_count.weights.sum() == pytest.approx(len(every))
    std = np.sqrt(fit.covariance.diagonal()[:10])
    assert (np.abs(found.fit.vector - fit.vector) < 0.1 * std).all()
    # a dozen of powers
    np.testing.assert_allclose(
        np.sqrt(found.fit.covariance.diagonal()[:10]) / std, 1.0, atol=0.3
    )
    # the noise that is told is that of one sample
    left = residuals(every, fit.vector, fit.bias)
    assert found.noise.force == pytest.approx(
        np.sqrt(np.mean(left[:, :3] ** 2)), rel=0.01
    )
    assert found.noise.torque == pytest.approx(
        np.sqrt(np.mean(left[:, 3:] ** 2)), rel=0.01
    )
    estimate = identify(recording, method="OLS").estimate
    assert estimate.samples == len(every)
    assert estimate.residual[0] == pytest.approx(0.1, rel=0.05)


def test_running_median_is_scipys():
    for count in (1, 5, 200):
        values = np.random.default_rng(count).random((count, 2))
        expected = median_filter(values, size=(NEIGHBOURING_CELLS, 1), mode="reflect")
        if count >= NEIGHBOURING_CELLS // 2:  # mirrored once is enough
            np.testing.assert_array_equal(_running_median(values), expected)


def test_what_is_averaged_does_not_depend_on_rounding_of_the_clock_offset():
    # times on the borders of blocks
    motion = UR5.motion(random_smooth(4.0, 1000.0, 1.0, 3))
    recording = simulate(motion, hammer().parameters, noise=Noise(0.1, 0.005), seed=3)
    found = condition(recording)
    offsets = 0.005 * (1.0 + 2.0**-52 * np.arange(20.0))
    each = [
        measured_blocks(recording, replace(found, offset=offset), "auto")
        for offset in offsets.tolist()
    ]
    first, counts, _ = each[0]
    for measured, others, _ in each[1:]:
        assert np.array_equal(others, counts)
        assert np.array_equal(measured.measurements.force, first.measurements.force)

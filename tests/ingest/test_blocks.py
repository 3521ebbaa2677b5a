"""Averages of a fast sensor: what they are of, and that nothing is lost by them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import median_filter
from scipy.spatial.transform import Rotation

from hefting.core.measurements import Noise
from hefting.identification import identify
from hefting.ingest.blocks import (
    Blocks,
    _averaged_motion,
    block_starts,
    measured_blocks,
    medians,
    residual_size,
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


@pytest.mark.parametrize("positions", [True, False])
def test_the_motion_is_averaged_over_the_times_of_the_samples(positions):
    """Against the mean of many; where these are beyond the ends of the poses, it is that
    of their middle. Of orientations alone only gravity is."""
    motion = UR5.motion(random_smooth(2.0, 1000.0, 1.5, seed=4))
    recording = simulate(motion, hammer().parameters, noise=Noise(0.1, 0.005), seed=4)
    if not positions:
        kept = {n: s for n, s in recording.streams.items() if n != "position"}
        recording = replace(recording, streams=kept)
    found = condition(recording, changes=False)
    every = measure(recording, found.gravity, "auto", found.curves)
    chosen = every.measurements[::20]
    apart, poses = 0.004, found.curves.poses
    every = replace(every, measurements=chosen)
    averaged = _averaged_motion(every, found, np.full(len(chosen), apart**2))
    outside = (chosen.time < poses.first + apart) | (chosen.time > poses.last - apart)
    assert outside.any()
    # an even spread of this deviation, of 41 times
    spread = apart * np.linspace(-1.0, 1.0, 41) * (3.0 * 40.0 / 42.0) ** 0.5
    names = ("linear_acceleration", "angular_velocity", "angular_acceleration")
    moved = (*names, "gravity") if positions else ("gravity",)
    for name in (*names, "gravity"):
        now = getattr(chosen, name)
        new = getattr(averaged.measurements, name)
        np.testing.assert_array_equal(new[outside], now[outside])
        if name not in moved:
            np.testing.assert_array_equal(new, now)
            continue
        each = [measure_at(recording, found, chosen.time + s, name) for s in spread]
        mean = np.mean([e[~outside] for e in each], axis=0)
        step = np.abs(mean - now[~outside]).max()
        # of the fourth order in the spread: of 2 Hz and 4 ms a thousandth of the second
        np.testing.assert_allclose(new[~outside], mean, atol=0.02 * step)


def measure_at(recording, found, time, name):
    """The motion of smoothed poses at any times; of the nearest one beyond their ends."""
    poses = found.curves.poses
    at = poses.at(np.clip(time, poses.first, poses.last))
    if name != "gravity":
        return getattr(at, name)
    return Rotation.from_quat(at.orientation).inv().apply(np.array(found.gravity))


def test_a_block_of_outliers_has_their_average_and_counts_for_nothing():
    """Whatever is kept of the others."""
    time, wrench = samples(1000)
    starts = Blocks.of(time, wrench).starts
    kept = (np.arange(len(time)) < starts[3]) | (np.arange(len(time)) >= starts[4])
    blocks, whole = Blocks.of(time, wrench, kept), Blocks.of(time, wrench)
    assert blocks.count[3] == 0.0
    np.testing.assert_array_equal(np.delete(blocks.count, 3), np.delete(whole.count, 3))
    for name in ("time", "variance", "wrench"):
        np.testing.assert_array_equal(getattr(blocks, name), getattr(whole, name))
    assert Blocks.of(time, wrench, np.zeros(len(time), dtype=bool)).mean_count == 1.0


@pytest.mark.parametrize("most", [1, 7, 30, 99, 100, 101, 1000])
def test_at_most_so_many_blocks_are_chosen_evenly(most):
    blocks = Blocks.of(*samples(1000))
    chosen, step = blocks.every(most), blocks.step_of(most)
    assert len(chosen) <= most
    assert len(blocks) <= step * most < len(blocks) + most
    for name in ("time", "variance", "count", "wrench"):
        np.testing.assert_array_equal(
            getattr(chosen, name), getattr(blocks, name)[::step]
        )


@pytest.mark.parametrize("nth", [1, 3])
def test_medians_are_numpys_of_each_block(nth):
    time, wrench = samples(700)
    starts = Blocks.of(time, wrench).starts
    expected = [np.median(part, axis=0) for part in np.split(wrench, starts[1:])]
    np.testing.assert_array_equal(medians(wrench, starts, nth), expected[::nth])
    np.testing.assert_array_equal(medians(wrench, None, nth), wrench[::nth])


def test_the_residual_of_a_sample_is_that_of_averages_and_what_is_within_them():
    """Of white noise, by averages of ten and of forty."""
    rng = np.random.default_rng(5)
    size = np.repeat((2.0, 0.3), 3)
    means, within, counts = [], np.zeros((6, 6)), np.repeat((10.0, 40.0), 300)
    for count in counts.astype(int):
        noise = size * rng.normal(size=(count, 6))
        means.append(noise.mean(axis=0))
        apart = noise - means[-1]
        within += apart.T @ apart / counts.sum()
    # 45,000 numbers: to half a percent
    found = residual_size(np.array(means), counts, within)
    np.testing.assert_allclose(found, (2.0, 0.3), rtol=0.015)
    none = residual_size(np.array(means)[:1], np.array([10.0]), np.zeros((6, 6)))
    expected = np.sqrt(np.square(means[0]).reshape(2, 3).mean(axis=1))
    np.testing.assert_allclose(none, expected)

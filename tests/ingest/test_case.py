"""The case that mistakes are judged by: its averages, their noise, and what of it counts
as nothing."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import correct

from given_cases import case_of
from hefting.ingest.rivals.case import (
    AVERAGES_VARIANCE,
    Case,
    _averaged,
    _averaged_together,
    _averages,
    _high_frequency_noise,
)
from hefting.motion.state import sample_weights


@pytest.fixture(scope="module")
def case() -> Case:
    return case_of(correct(0))


@pytest.mark.parametrize(
    ("count", "interval", "together"),
    [
        (250, 0.01, 1),
        (251, 0.01, 2),
        (750, 0.01, 3),
        (751, 0.01, 4),
        (5000, 0.01, 4),
        (5000, 0.001, 20),
        (50_000, 0.001, 40),
        (5000, 0.03, 1),
        (5000, 0.05, 1),
    ],
)
def test_blocks_are_averaged_for_250_of_them_but_over_40_ms_at_most(
    count, interval, together
):
    assert _averaged_together(interval * np.arange(count)) == together


def test_averages_are_the_wrench_in_the_middle_of_their_time():
    """Of a parabola but for a 24th of the square of a sample's time; the ends are means.
    What is left over is left out, and where times are uneven nothing is taken away."""
    h, n = 0.01, 4
    time = 3.0 + h * np.arange(43)
    slope, curve = np.arange(1.0, 7.0), np.arange(6.0, 0.0, -1.0)

    def wrench(t):
        since = (t - 3.0)[:, None]
        return 1.0 + slope * since + 0.5 * curve * since**2

    at, found = _averages(time, wrench(time), n)
    np.testing.assert_allclose(at, 3.0 + h * (4.0 * np.arange(10) + 1.5))
    off = (found - wrench(at)) / (curve * h**2 / 24.0)
    np.testing.assert_allclose(off[1:-1], -1.0, rtol=1e-6)
    np.testing.assert_allclose(off[[0, -1]], n**2 - 1.0, rtol=1e-6)
    late = time + 0.05 * (np.arange(43) >= 20)
    at, found = _averages(late, wrench(late), n)
    off = (found - wrench(at)) / (curve * h**2 / 24.0)
    expected = np.where(np.isin(np.arange(10), (0, 4, 5, 9)), n**2 - 1.0, -1.0)
    np.testing.assert_allclose(off, np.tile(expected[:, None], 6), rtol=1e-6)


@pytest.mark.parametrize(
    ("frequency", "together"), [(0.5, 4), (2.0, 4), (4.5, 2), (6.0, 2), (12.0, 1)]
)
def test_averages_are_as_long_as_they_lose_nothing_of_a_tremor(frequency, together):
    """Which a loose mass, a lever arm or a payload would explain: of 1 N at 6 Hz averages
    of 40 ms lose 2 %, which is a third of their noise."""
    time = 0.01 * np.arange(1000)
    wave = np.sin(2.0 * np.pi * frequency * time)[:, None] * np.repeat((1.0, 0.1), 3)
    noise = np.array((0.06, 0.006))
    loud = wave + np.random.default_rng(1).normal(size=wave.shape) * noise.repeat(3)
    at, found, less = _averaged(time, loud, noise, np.zeros(2))
    assert len(at) == 1000 // together
    exact = np.sin(2.0 * np.pi * frequency * at)[1:-1, None] * np.repeat((1.0, 0.1), 3)
    # what is left is noise of the size that is told
    left = np.sqrt(np.mean((found[1:-1] - exact) ** 2, axis=0))
    np.testing.assert_allclose(left, less.repeat(3), rtol=0.15)
    # rounding hides as much as noise does
    at, *_ = _averaged(time, loud, noise, np.array((1.0, 0.1)))
    assert len(at) == 250


def test_the_variance_of_averages_is_that_of_their_samples_weights():
    """By the answer to one sample after the other."""
    weights = []
    for k in range(20):
        wrench = np.zeros((20, 6))
        wrench[k] = 1.0
        weights.append(_averages(np.arange(20.0), wrench, 4)[1][2, 0])
    assert sum(weights) == pytest.approx(1.0)
    assert np.square(weights).sum() == pytest.approx(AVERAGES_VARIANCE / 4.0)


def test_noise_is_told_beside_a_slow_motion():
    """Of 4,000 numbers to a few hundredths; not of fewer than four samples."""
    rng = np.random.default_rng(1)
    sizes = np.array((1.0, 2.0, 2.0, 0.1, 0.1, 0.1))
    noise = sizes * rng.normal(size=(4000, 6))
    slow = 100.0 * np.sin(0.01 * np.arange(4000))[:, None]
    expected = np.sqrt(np.square(sizes).reshape(2, 3).mean(axis=1))
    found = _high_frequency_noise(noise + slow)
    np.testing.assert_allclose(found, expected, rtol=0.05)
    assert not _high_frequency_noise(noise[:3]).any()
    assert _high_frequency_noise(noise[:4]).all()


def test_a_case_has_the_noise_of_its_averages(case):
    """Of 0.1 N and 0.005 N m, four samples in each."""
    assert len(case.time) == 250
    expected = np.array((0.1, 0.005)) * (AVERAGES_VARIANCE / 4.0) ** 0.5
    np.testing.assert_allclose(case.noise, expected, rtol=0.15)
    third = case.every(3)
    np.testing.assert_array_equal(third.wrench, case.wrench[::3])
    np.testing.assert_array_equal(third.time, case.time[::3])


def test_what_counts_as_nothing_is_noise_and_a_good_sensor_s_error(case):
    """Three thousandths of the changes; a billionth of the wrench at least."""
    changes = np.sqrt(np.var(case.wrench, axis=0).reshape(2, 3).mean(axis=1))
    expected = np.hypot(case.noise, 0.003 * changes)
    np.testing.assert_allclose(case.floor, expected)
    still = np.tile((3.0, 4.0, 0.0, 0.0, 0.0, 0.0), (len(case.time), 1))
    same = replace(case, wrench=still, noise=np.zeros(2))
    np.testing.assert_allclose(same.floor, (1e-9 * (25.0 / 3.0) ** 0.5, 1e-18))


@pytest.mark.parametrize(("memory", "found"), [(0.0, 1.0), (0.05, 0.87), (0.15, 0.43)])
def test_the_level_is_that_of_coloured_noise(case, memory, found):
    """Averages that remember so many seconds: fourth differences over 0.12 s have so much of
    their variance. Turned axes count as none of it."""
    step = float(np.median(np.diff(case.time)))
    keep = np.exp(-step / memory) if memory else 0.0
    noise = np.random.default_rng(2).normal(size=(450, 6))
    for k in range(1, len(noise)):
        noise[k] = keep * noise[k - 1] + (1.0 - keep**2) ** 0.5 * noise[k]
    expected = 5.0 * np.array((0.1, 0.005)) * found**0.5
    time, wrench = case.consecutive
    added = wrench + 5.0 * np.repeat((0.1, 0.005), 3) * noise[200:]
    level = replace(case, consecutive=(time, added)).level
    # of 250 averages whose differences are correlated: to a tenth, and their own noise
    np.testing.assert_allclose(level, expected, rtol=0.2)
    assert np.array_equal(case.level, case.floor)
    late = replace(case, offset=0.2, consecutive=(time + 0.2, wrench))
    assert np.array_equal(late.level, case.floor)
    turned = replace(case, consecutive=(time, wrench[:, [1, 0, 2, 3, 4, 5]]))
    assert np.array_equal(turned.level, case.floor)
    assert np.array_equal(
        replace(case, consecutive=(time[:50], added[:50])).level, case.floor
    )


def test_averages_count_by_the_errors_of_their_motion(case):
    """As samples do of an estimate; every other one for half as many of an error; all
    alike where the motion has none."""
    np.testing.assert_array_equal(case.worth, np.ones(len(case.time)))
    recording, path, offset = case.recording, case.path, 0.003
    body = correct(0).truth.vector
    found = Case.of(recording, path, case.gravity, offset, biased=True, parameters=body)
    inside = path.known_at(case.time - offset)
    motion = path.curves.alone.at(case.time[inside] - offset)
    expected = sample_weights(body, motion, *found.floor)
    np.testing.assert_allclose(found.worth[inside], expected, rtol=1e-9)  # rounding
    assert found.worth.min() < 0.9 < found.worth.max() < 1.0
    np.testing.assert_array_equal(found.every(2).worth, found.worth[::2])
    heavy = Case.of(
        recording, path, case.gravity, offset, biased=True, parameters=1e3 * body
    )
    # of an error a million times as large the ratio alone is left
    np.testing.assert_allclose(
        heavy.worth, 1e-6 * found.worth / (1.0 - found.worth), rtol=1e-3
    )


def test_averages_without_a_motion_count_as_the_usual_one_with_it(case):
    """They had counted most of all where the others' motion is in doubt."""
    body, offset = correct(0).truth.vector, 0.5
    found = Case.of(
        case.recording, case.path, case.gravity, offset, biased=True, parameters=body
    )
    known = case.path.known_at(case.time - offset)
    assert (~known).sum() > 5
    np.testing.assert_allclose(found.worth[~known], found.worth[known].mean())


def test_offsets_to_try_are_within_a_tenth_of_a_second_and_near_the_one_found(case):
    np.testing.assert_allclose(case.offsets, 0.02 * np.arange(-5, 6), atol=1e-9)
    late = replace(case, offset=0.203)
    np.testing.assert_allclose(
        late.offsets, [*0.02 * np.arange(-5, 6), 0.183, 0.203, 0.223], atol=1e-9
    )
    np.testing.assert_array_equal(late.likely_offsets, (0.0, 0.203))
    np.testing.assert_array_equal(case.likely_offsets, (0.0,))
    still = replace(late, path=replace(case.path, kind="static"))
    np.testing.assert_array_equal(still.offsets, (0.0,))


def test_a_bias_drifts_in_recordings_of_eight_seconds_that_move(case):
    for seconds, functions in ((7.8, 1), (8.0, 2)):
        time = np.linspace(0.0, seconds, len(case.time))
        assert replace(case, time=time).bias_functions.shape[1] == functions
    long = replace(case, path=replace(case.path, kind="static"))
    np.testing.assert_array_equal(long.bias_functions, np.ones((250, 1)))
    assert replace(case, biased=False).bias_functions.shape == (250, 0)


def test_the_motion_is_that_at_the_time_of_a_late_wrench(case):
    both = case.motion_late(np.array((0.0, 0.04)))
    reading = case.path.at(case.time - 0.04, spread=False)
    np.testing.assert_array_equal(both.a[1], reading.value[:, :3])
    np.testing.assert_array_equal(both.rest[1], reading.value[:, 3:12])
    np.testing.assert_array_equal(both.known[1], reading.known)
    R = both.axes[1]
    np.testing.assert_allclose(
        R @ R.transpose(0, 2, 1), np.tile(np.eye(3), (250, 1, 1)), atol=1e-9
    )
    expected = both.a[1] - np.einsum("kij,j->ki", R, case.gravity)
    np.testing.assert_allclose(both.features(case.gravity)[1, :, :3], expected)
    measured = replace(case, path=replace(case.path, gravity_measured=True))
    assert not measured.modelled_gravity.any()
    assert case.modelled_gravity is case.gravity

"""Outliers beside a known prediction: noise is none, however it comes, nor is what an
imperfect sensor gets wrong."""

import numpy as np
import pytest

from hefting.ingest.outliers import (
    Outliers,
    _cell_medians,
    _contact_cells,
    _imperfection,
    _length,
    _running,
    _spread,
    find_odd_poses,
    find_outliers,
    saturated,
)

K = 2000
TIME = 0.01 * np.arange(K)
NOISE = np.repeat((0.1, 0.005), 3)


def noise(seed=0):
    return NOISE * np.random.default_rng(seed).normal(size=(K, 6))


def found_in(residual, changes=(0.0, 0.0), known=None, time=TIME) -> Outliers:
    """Beside a wrench that is the same throughout."""
    known = np.ones(K, dtype=bool) if known is None else known
    return find_outliers(
        time,
        residual,
        np.zeros((K, 6)),
        np.ones(K),
        known,
        NOISE[::3],
        np.array(changes),
    )


def test_an_arm_may_shake_for_a_while():
    """Three times the noise to and fro, four samples in a cell: its averages are no
    larger than before, and each sample counts beside those about it. The length of six
    normal numbers exceeds 7 once in 10⁸."""
    time = np.arange(K) / 64.0
    shaking = (time > 8.0) & (time < 16.0)
    edges = (np.abs(time - 8.0) < 0.3) | (np.abs(time - 16.0) < 0.3)
    for seed in range(3):
        to_and_fro = 3.0 * np.abs(noise(seed)) * (-1.0) ** np.arange(K)[:, None]
        found = found_in(np.where(shaking[:, None], to_and_fro, noise(seed)), time=time)
        # their spread is that of some forty samples: a tenth uncertain
        assert found.rejected[~edges].sum() <= 4
        assert not found.saturation.any()


def test_a_quiet_stretch_asks_no_more_than_the_rest():
    """In one of the twenty seconds; a sample in it is off by four of the usual
    deviations, eighty of its neighbours'. Of what is left when averages are taken off
    these are five to six; beyond seven it would be a spike."""
    residual = noise() * np.where((TIME > 10.0) & (TIME < 11.0), 0.05, 1.0)[:, None]
    for size, told in ((4.0, False), (9.0, True)):
        residual[1050] = (size * NOISE[0], 0, 0, 0, 0, 0)
        assert found_in(residual).spike[1050] == told


@pytest.mark.parametrize("channel", range(6))
def test_an_imperfect_sensor_is_no_outlier(channel):
    """Without noise: seven times four hundredths of what the wrench changes by."""
    changes = (10.0, 0.4)
    for share, told in ((0.27, False), (0.29, True)):
        residual = np.zeros((K, 6))
        residual[777, channel] = share * changes[channel // 3]
        found = found_in(residual, changes)
        np.testing.assert_array_equal(
            np.flatnonzero(found.rejected), [777] if told else []
        )
        poses = find_odd_poses(residual[700:800], np.zeros((100, 6)), np.array(changes))
        np.testing.assert_array_equal(
            np.flatnonzero(poses.rejected), [77] if told else []
        )


def test_a_touch_is_found_whole_and_nothing_else():
    """Half a second at three deviations of every sample: far beyond those of
    averages."""
    residual = noise()
    touched = (TIME >= 5.0) & (TIME < 5.5)
    residual[touched] += 3.0 * NOISE
    found = found_in(residual)
    assert found.contact[touched].all()
    # a cell or an average of four to each side
    assert found.contact[~touched].sum() <= 40
    assert not found.spike[~touched].any()


def test_nothing_known_is_nothing_found():
    assert not found_in(100.0 * noise(), known=np.zeros(K, dtype=bool)).rejected.any()
    one = np.arange(K) == 5
    assert not found_in(100.0 * noise(), known=one).rejected.any()


def test_a_contact_lasts_above_four_deviations_and_reaches_seven():
    size = np.array((0.0, 4.1, 7.1, 4.1, 3.9, 5.0, 6.9, 5.0, 0.0, 8.0))
    expected = np.isin(np.arange(10), (1, 2, 3, 9))
    np.testing.assert_array_equal(_contact_cells(size), expected)


def test_cells_have_the_medians_of_what_is_known_in_them():
    rng = np.random.default_rng(1)
    cell = np.repeat((0, 1, 2, 3), (1, 4, 5, 3))
    r = rng.normal(size=(13, 2))
    r[[2, 10, 11, 12]] = np.nan
    found, count = _cell_medians(r, cell)
    np.testing.assert_array_equal(count, (1, 3, 5, 0))
    expected = [np.nanmedian(r[cell == c], axis=0) for c in range(3)]
    np.testing.assert_array_equal(found, [*expected, (0.0, 0.0)])


def test_averages_are_over_the_cells_about_each_by_their_weights():
    values = np.arange(1.0, 7.0)[:, None] * np.ones(6)
    weights = np.array((1.0, 1.0, 0.0, 1.0, 1.0, 1.0))
    found = _running(values * weights[:, None], weights, 4)[:, 0]
    # two before, itself or the next ones, as far as there are any
    for k in range(6):
        part = [i for i in range(k - 1, k + 3) if 0 <= i < 6 and weights[i]]
        assert found[k] == pytest.approx(values[part, 0].mean())
    assert _running(values, weights, 1) is values


def test_spreads_are_those_of_normal_numbers():
    """1.4826 times the median size, of force and torque, or the least where that is
    larger; of many a part will do."""
    rng = np.random.default_rng(2)
    values = rng.normal(size=(50_001, 6)) * np.repeat((2.0, 0.1), 3)
    np.testing.assert_allclose(_spread(values, np.zeros(2)), (2.0, 0.1), rtol=0.02)
    few = values[:99]
    expected = 1.4826 * np.median(np.abs(few.reshape(-1, 2, 3)), axis=(0, 2))
    np.testing.assert_allclose(_spread(few, np.zeros(2)), expected)
    for least in np.outer((0.5, 0.999, 1.001, 2.0), expected):
        above = np.stack((least, 1.5 * least))
        larger = np.maximum(expected, above)
        np.testing.assert_allclose(_spread(few, above) + np.zeros((2, 2)), larger)
    assert not _spread(values[:0], np.zeros(2)).any()
    lengths = _length(values, np.array((2.0, 0.1)))
    expected = np.linalg.norm(values / np.repeat((2.0, 0.1), 3), axis=1)
    np.testing.assert_allclose(lengths, expected)
    assert np.isfinite(_length(values, np.zeros(2))).all()


def test_a_good_sensor_errs_by_its_changes_and_its_rate():
    """4 % of the changes and 3 ms of the rate, as a root mean square over each cell."""
    time = 0.01 * np.arange(60)
    cell = np.arange(60) // 20
    predicted = np.zeros((60, 6))
    predicted[:, 0] = np.where(cell == 1, 50.0 * (time - 0.2), 10.0 * (cell == 2))
    rate = np.gradient(predicted[:, 0], time)
    square = np.array([np.mean(rate[cell == c] ** 2) for c in range(3)])
    found = _imperfection(time, predicted, cell, np.array((5.0, 0.5)))
    np.testing.assert_allclose(found[:, 0], np.sqrt(0.2**2 + 9e-6 * square))
    np.testing.assert_allclose(found[:, 1], 0.02)


@pytest.mark.parametrize(
    ("shared", "beyond", "found"),
    [(5, 5.1, True), (4, 5.1, False), (5, 4.9, False), (8, 5.1, True)],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_limit_is_shared_by_five_samples_beyond_which_the_prediction_is(
    shared, beyond, found, sign
):
    """By five deviations; what is near it counts as well, within three."""
    wrench = np.zeros((60, 6))
    values = np.repeat(np.linspace(-5.0, 5.0, 12), 5)  # in coarse steps
    wrench[:, 1] = sign * values
    wrench[55:, 1] = sign * 4.0
    wrench[:shared, 1] = sign * 10.0
    predicted = wrench.copy()
    predicted[:shared, 1] = sign * (10.0 + 0.1 * beyond)
    predicted[20, 1] = sign * 9.71
    predicted[21, 1] = sign * 9.69
    mask = saturated(wrench, predicted, np.full(6, 0.1))
    expected = np.zeros(60, dtype=bool)
    if found:
        expected[:shared] = expected[20] = True
    np.testing.assert_array_equal(mask, expected)


def test_a_value_that_alone_is_shared_is_a_limit_whatever_is_predicted():
    """Unless most are, or others are shared as often."""
    rng = np.random.default_rng(3)
    wrench = rng.uniform(-1.0, 1.0, (60, 6))
    wrench[10:16, 2] = 1.5
    mask = saturated(wrench, wrench, np.ones(6))
    np.testing.assert_array_equal(np.flatnonzero(mask), np.arange(10, 16))
    wrench[30:35, 2] = 0.5
    assert not saturated(wrench, wrench, np.ones(6)).any()
    wrench[29:, 2] = 1.5
    assert not saturated(wrench, wrench, np.ones(6)).any()


def test_small_readings_that_were_written_as_zero_are_no_limit():
    """Of a channel whose others are all of one sign."""
    wrench = np.random.default_rng(3).uniform(1.0, 2.0, (60, 6))
    wrench[10:16, 2] = 0.0
    assert not saturated(wrench, wrench - 9.0, np.ones(6)).any()


@pytest.mark.parametrize(("odd", "found"), [(11, 11), (12, 12), (13, 0)])
def test_of_poses_six_tenths_at_most_are_odd(odd, found):
    """More, and it is the model that is wrong; by the spread of all but a good sensor's
    error."""
    wrench = np.full((20, 6), 1e-3) * np.array((1, -1) * 10)[:, None]
    wrench[:odd, 0] += 50.0
    assert find_odd_poses(wrench, 0.0 * wrench, np.zeros(2)).spike.sum() == found
    few = np.full((20, 6), 1e-3)
    few[:, 3:] = 0.0
    few[:3, 0] = 0.69, 0.71, -0.71
    spike = find_odd_poses(few, 0.0 * few, np.array((2.5, 0.0))).spike
    np.testing.assert_array_equal(np.flatnonzero(spike), (1, 2))


def test_of_two_causes_a_contact_is_the_one():
    no, yes = np.array((False,)), np.array((True,))
    both = Outliers(no, yes, no).union(Outliers(yes, no, yes))
    assert (both.contact[0], both.spike[0], both.saturation[0]) == (True, False, True)
    assert Outliers(no, yes, no).union(Outliers(no, no, no)).spike[0]
    assert Outliers(no, no, yes).rejected[0]
    assert Outliers(no, yes, no).rejected[0]

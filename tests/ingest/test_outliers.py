"""Outliers beside a known prediction: noise is none, however it comes, nor is what an
imperfect sensor gets wrong."""

import numpy as np
import pytest

from hefting.ingest.outliers import Outliers, find_odd_poses, find_outliers

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

"""The band of a sensor's reading."""

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes
from hefting.core.sensor_accuracy import EXACT, Z95, SensorAccuracy
from hefting.prediction import predict
from hefting.simulation import UR5, hammer, random_smooth, simulate


def test_a_reading_is_as_unsure_as_its_sensor():
    """Of one force: its gain, its slow errors, and the offset; the other channels hear
    of it by cross-talk."""
    accuracy = SensorAccuracy(0.01, 0.2, 0.004)
    force = np.zeros((2, 6))
    force[1, 0] = 50.0
    std = accuracy.reading_std(force)
    np.testing.assert_allclose(std[0], np.repeat((0.2, 0.004), 3) / Z95)
    more = np.sqrt(std[1] ** 2 - std[0] ** 2) / 50.0
    own = 1.5 * (0.01 / Z95) ** 2 + 0.005**2  # slow errors: half a percent at most
    np.testing.assert_allclose(more[0], own**0.5)
    np.testing.assert_allclose(more[1:], accuracy.channel_stds[1:, 0])
    assert not EXACT.reading_std(force).any()


def test_the_band_is_that_of_the_reading_where_a_sensor_is_given():
    body = hammer().parameters
    motion = simulate(
        UR5.motion(random_smooth(2.0, 50.0, 1.0, seed=1)), body, seed=1, exact=True
    )
    known = Estimate(
        "OLS", InertialParameters(body.vector), 100, covariance=np.zeros((10, 10))
    )
    bare, read = (predict(known, motion, sensor_accuracy=text) for text in (None, "1%"))
    assert bare.std is not None
    assert read.std is not None
    assert not bare.std.any()
    np.testing.assert_allclose(read.std, SensorAccuracy(0.01).reading_std(read.wrench))
    assert read.peaks["force"].std > 0.01 * read.peaks["force"].value / Z95
    assert "band-of-reading" in codes(read.notes)
    assert "band-of-reading" not in codes(bare.notes)

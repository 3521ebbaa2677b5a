"""Accuracy of a sensor: figures, names of sensors, and what they say of the wrench."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.sensor_accuracy import (
    EXACT,
    OWN_GAIN_RATIO,
    SHEETS,
    TYPICAL_LEVER,
    TYPICAL_SHARE,
    Z95,
    SensorAccuracy,
    sheet_name,
)


@pytest.mark.parametrize(
    ("text", "figures"),
    [
        ("0.5% 0.3N 0.01Nm", (0.005, 0.3, 0.01)),
        ("10 mNm, 300 mN, 0.5 %", (0.005, 0.3, 0.01)),
        (" 2%", (0.02, 0.0, 0.0)),
        ("0%", (0.0, 0.0, 0.0)),
        ("1e-1N", (TYPICAL_SHARE, 0.1, 0.0)),
        ("0.02 N m", (TYPICAL_SHARE, 0.0, 0.02)),
    ],
)
def test_figures_are_read_and_written(text, figures):
    found = SensorAccuracy.parse(text)
    assert (found.share, found.force, found.torque) == pytest.approx(figures)
    assert SensorAccuracy.parse(str(found)) == found
    assert found.lever == TYPICAL_LEVER
    assert found.none == (figures == (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    "text",
    [
        "0.5",
        "5kg",
        "1N 2N",
        "nan%",
        "-1%",
        "101%",
        "",
        "1e400N",
        "1%%",
        "gama",
        "9" * 99,
    ],
)
def test_what_is_no_accuracy_is_refused_in_one_line(text):
    with pytest.raises(
        InputError, match=r"as in 0\.5% 0\.3N|number and a unit"
    ) as error:
        SensorAccuracy.parse(text)
    assert "\n" not in str(error.value)


def test_what_is_no_text_is_refused():
    for value in (0.005, True, b"1%"):
        with pytest.raises(InputError, match="as in"):
            SensorAccuracy.of(value)  # type: ignore[arg-type]
    for figures in ((-0.1,), (0.1, float("nan")), (0.1, 0.0, 0.0, 0.0), ("a",)):
        with pytest.raises(InputError, match="as in"):
            SensorAccuracy(*figures)
    assert SensorAccuracy.of(None) is None


@pytest.mark.parametrize("name", SHEETS)
def test_a_sensor_s_name_stands_for_its_data_sheet(name):
    """Or says where to find what that does not state."""
    sheet = SHEETS[name]
    assert name == sheet_name(sheet.model)
    assert sheet.document
    assert 0.03 <= sheet.ranges[1] / sheet.ranges[0] <= 1.0 / 3.0  # [m]
    if not sheet.states_accuracy:
        assert sheet.remark
        with pytest.raises(InputError, match=sheet.remark):
            SensorAccuracy.parse(sheet.model)
        return
    found = SensorAccuracy.parse(f" {sheet.model.upper()} ")
    assert found.lever == sheet.ranges[1] / sheet.ranges[0]
    if sheet.of_full_scale is not None:
        assert (found.share, found.force, found.torque) == (sheet.of_full_scale, 0, 0)
    else:
        assert (found.force, found.torque) == sheet.absolute


def test_errors_over_the_range_are_those_of_the_figures():
    """Of a fully loaded sensor: the gain of all channels is off by the share, in 95 % of
    the cases, that of one by 1.2 times as much, and so is what cross-talk makes."""
    accuracy = SensorAccuracy(0.01, lever=0.05)
    full = np.repeat((100.0, 5.0), 3)
    variances = np.square(accuracy.channel_stds * full)
    own = variances.diagonal()
    np.testing.assert_allclose(Z95 * np.sqrt(own), OWN_GAIN_RATIO * 0.01 * full)
    assert Z95 * accuracy.gain_std == pytest.approx(0.01)
    crosstalk = np.sqrt(variances.sum(axis=1) - own)
    np.testing.assert_allclose(Z95 * crosstalk, 1.5**0.5 * 0.01 * full)


def test_an_exact_sensor_has_no_errors():
    assert EXACT.none
    assert not EXACT.channel_stds.any()
    assert not EXACT.offset_std.any()
    assert EXACT.gain_std == EXACT.slow_std == 0.0

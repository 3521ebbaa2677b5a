"""A scale's reading: the forms that are understood, and what is refused."""

from dataclasses import replace

import pytest

from hefting import MassReading
from hefting.core.errors import InputError


@pytest.mark.parametrize(
    ("text", "mass", "std"),
    [
        ("0.512kg±1g", 0.512, 1e-3),
        ("0.512±0.001", 0.512, 1e-3),
        ("512g+-1g", 0.512, 1e-3),
        ("512 ± 1 g", 0.512, 1e-3),
        ("0.512 kg +/- 0.2 %", 0.512, 0.002 * 0.512),
        ("1.2lb±0.1oz", 1.2 * 0.45359237, 0.1 * 0.45359237 / 16.0),
        ("5.12e2g±1", 0.512, 1e-3),
    ],
)
def test_forms_that_are_understood(text, mass, std):
    found = MassReading.parse(text)
    assert (found.mass, found.std) == pytest.approx((mass, std), rel=1e-12)
    assert not found.assumed
    # written with nine digits, the deviation with six
    again = MassReading.parse(str(found))
    assert (again.mass, again.std) == pytest.approx((mass, std), rel=1e-5)


@pytest.mark.parametrize(
    ("text", "mass", "std"),
    [("0.512kg", 0.512, 1e-3), ("512g", 0.512, 1e-3), ("0.5120", 0.512, 1e-4)],
)
def test_without_a_deviation_it_is_right_to_the_last_digit(text, mass, std):
    found = MassReading.parse(text)
    assert (found.mass, found.std) == pytest.approx((mass, std), rel=1e-12)
    assert found.assumed


def test_pairs_and_readings_are_taken_as_they_are():
    assert MassReading.of(None) is None
    assert MassReading.of((0.5, 0.01)) == MassReading(0.5, 0.01)
    assert MassReading.of("500g±10g") == MassReading(0.5, 0.01)
    reading = MassReading(0.5, 0.01)
    assert MassReading.of(reading) is reading


@pytest.mark.parametrize(
    "value",
    [
        *("", "kg", "-1kg", "0,512kg", "0.5kg±", "±1g", "1N", "nan", "1.2.3kg", "0"),
        *("0.5kg±1kg", "0.512±1g", "1kg±0g", "1kg", "0.5kg±1g±1g", "5%±1g"),
        *("1e99kg±1g", "1kg±1e-30kg", "9" * 99, " " * 10**6, "+-" * 10**5),
        *(0.5, (1.0,), (1.0, "a"), (1.0, float("nan")), (float("inf"), 1.0), [1, 2, 3]),
    ],
)
def test_what_is_no_reading_is_refused_in_one_line(value):
    with pytest.raises(InputError, match=r"as in '?0\.512kg") as error:
        MassReading.of(value)
    assert len(str(error.value)) < 250


def test_a_reading_is_checked_however_it_is_made():
    for changes in ({"mass": -1.0}, {"std": 0.0}, {"std": 1.0}):
        with pytest.raises(InputError):
            replace(MassReading(0.5, 0.01), **changes)

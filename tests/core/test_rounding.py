"""Rounding to what a number is worth."""

from decimal import Decimal

import numpy as np
import pytest

from hefting.core.quantity import (
    MOST_DIGITS,
    decimals,
    rounded,
    significant,
    wrench_text,
)


@pytest.mark.parametrize(
    ("half", "size", "places"),
    [
        (0.031, 1.2, 3),  # 31 thousandths: two digits
        (0.098, 1.2, 3),
        (0.1, 1.2, 2),
        (12.0, 345.0, 0),
        (120.0, 345.0, -1),
        (np.inf, 1.2, 5),  # six digits of the size
        (np.nan, 1.2, 5),
        (0.0, 1.2, 5),
        (np.inf, 0.0012, 8),
        (1e-12, 1.2, 5),  # no more than six
    ],
)
def test_two_digits_of_the_half_width_and_at_most_six(half, size, places):
    assert decimals(half, size) == places


def test_some_digits_stay_however_wide_the_interval():
    assert decimals(50.0, 0.0123) == 0
    assert decimals(50.0, 0.0123, least_digits=2) == 3
    assert decimals(1e-12, 0.0123, least_digits=2) == MOST_DIGITS + 1


def test_no_power_of_ten_stands_for_digits():
    assert [significant(x) for x in (13456.0, -112.0, 99.6)] == ["13000", "-110", "100"]
    assert [significant(x) for x in (0.01234, 2.0, 0.0)] == ["0.012", "2", "0"]
    assert significant(25.4, 1) == "30"


def test_numbers_are_off_by_half_a_step_at_most_and_have_no_more_digits():
    rng = np.random.default_rng(1)
    values = rng.normal(size=200) * 10.0 ** rng.integers(-9, 5, 200)
    half = 10.0 ** rng.uniform(-9, 5, 200)
    for value, h in zip(values, half, strict=True):
        places = int(decimals(h, abs(value)))
        found = float(rounded(value, places))
        # Python's decimal arithmetic; half a step plus the rounding of a double
        limit = 0.5 * 10.0**-places * (1 + 1e-9) + 1e-15 * abs(value)
        assert abs(Decimal(found) - Decimal(float(value))) <= Decimal(limit)
        written = Decimal(repr(found)).normalize()
        assert -written.as_tuple().exponent <= max(places, 0)
        # never coarser than a tenth of the half-width, unless six digits end there
        assert 10.0**-places <= 0.1 * h * (1 + 1e-9) or places == int(
            decimals(np.inf, abs(value))
        )


def test_zero_has_no_sign():
    found = rounded([-7e-19, -0.0, 1e-3], 5)
    assert [repr(float(v)) for v in found] == ["0.0", "0.0", "0.001"]


@pytest.mark.parametrize(
    ("wrench", "text"),
    [
        ((12.0, -7.0, 14.0, 0.3, -0.2, 0.0999), "(12, -7, 14) N, (0.3, -0.2, 0.1) N m"),
        ((1, 2, 3, 0.3, 3.64e-05, 0.000375), "(1, 2, 3) N, (0.3, 0, 0) N m"),
        (
            (1234.5, -1e-9, 7, -9.81e-5, 4e-4, 0.0),
            "(1230, 0, 10) N, (-0.000098, 0.0004, 0) N m",
        ),
        ((0, 0, 0, np.nan, 0, 0), "(0, 0, 0) N, (nan, 0, 0) N m"),
    ],
)
def test_a_wrench_has_three_digits_of_its_largest_parts(wrench, text):
    assert wrench_text(wrench) == text

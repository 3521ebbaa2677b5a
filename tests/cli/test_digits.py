"""Numbers as they are printed."""

import numpy as np
import pytest

from hefting.cli.report import Worth, aligned, decimals_of, fixed, with_reach
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters


@pytest.mark.parametrize(
    ("value", "reach", "decimals"),
    [
        (0.6704, 0.0046, 3),
        (172.3, 0.85, 1),
        (172.3, 12.0, 0),
        (3.1e-8, 1.9e-5, 5),
        (0.67041, None, 4),
        (5.0, np.inf, 3),
        (0.0, None, 0),
        (1.0, 1e-15, 9),
    ],
)
def test_one_digit_of_what_is_sure(value, reach, decimals):
    assert decimals_of(value, reach) == decimals


def test_no_minus_before_a_zero_and_nothing_open_as_a_number():
    assert fixed(-7e-19, 6) == "0.000000"
    assert fixed(np.inf, 2) == "open"
    assert with_reach([1.0, np.nan], 0.1) == "open"
    assert with_reach([1.44, 172.24], 0.83) == "1.4, 172.2 ± 0.8"


def test_digits_may_be_those_of_the_value_that_is_known_best():
    """A moment of 0.47 ± 0.2 had been 0 beside others of ± 2."""
    assert with_reach([1.3, 0.47, 1.7], 1.9, 0.2) == "1.3, 0.5, 1.7 ± 1.9"


def test_points_stand_under_each_other():
    column = [row[0] for row in aligned([["1.25"], ["10"], ["0.125"]])]
    width = max(map(len, column))
    ends = [len(text.rjust(width).split(".")[0].rstrip()) for text in column]
    assert len(set(ends)) == 1


def test_moments_of_a_point_take_their_digits_from_the_intervals():
    """Those of rounding, 1e-17 kg m², had twenty decimals."""
    point = InertialParameters.from_com(1.0, (0.0, 0.0, 0.1), 1e-17 * np.eye(3))
    ends = {
        "mass": np.array((0.9, 1.1)),
        "center_of_mass": np.array((-0.01, 0.01))[:, None] * np.ones(3),
        "inertia_at_com": np.array((-3e-18, 7e-3))[:, None, None] * np.ones((3, 3)),
    }
    worth = Worth.of(Estimate("Bayes", point, 10, intervals=ends))
    assert worth.text(-3e-18, 4, False) == "0.000000"

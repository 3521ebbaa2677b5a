"""Numbers as they are printed."""

import numpy as np
import pytest

from hefting.cli.report.digits import aligned, decimals_of, fixed, with_reach


@pytest.mark.parametrize(
    ("value", "reach", "decimals"),
    [
        (0.6704, 0.0046, 4),
        (172.3, 0.85, 2),
        (172.3, 12.0, 0),
        (3.1e-8, 1.9e-5, 6),
        (0.67041, None, 4),
        (5.0, np.inf, 3),
        (0.0, None, 0),
        (1.0, 1e-15, 9),
    ],
)
def test_two_digits_of_what_is_sure(value, reach, decimals):
    assert decimals_of(value, reach) == decimals


def test_no_minus_before_a_zero_and_nothing_open_as_a_number():
    assert fixed(-7e-19, 6) == "0.000000"
    assert fixed(np.inf, 2) == "open"
    assert with_reach([1.0, np.nan], 0.1) == "open"
    assert with_reach([1.44, 172.24], 0.83) == "1.4, 172.2 ± 0.8"


def test_points_stand_under_each_other():
    column = [row[0] for row in aligned([["1.25"], ["10"], ["0.125"]])]
    width = max(map(len, column))
    ends = [len(text.rjust(width).split(".")[0].rstrip()) for text in column]
    assert len(set(ends)) == 1

"""Half-spaces as inequalities."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.planning.space import HalfSpace


@pytest.mark.parametrize(
    ("text", "normal", "offset"),
    [
        ("z>=0.05", (0, 0, 1), 0.05),
        (" x <= 0.6 ", (-1, 0, 0), -0.6),
        ("y >= -1e-1", (0, 1, 0), -0.1),
        ("3,0,4>=0.5", (0.6, 0, 0.8), 0.1),
        ("0,-2,0<=1", (0, 1, 0), -0.5),
    ],
)
def test_inequalities_are_planes(text, normal, offset):
    half = HalfSpace.parse(text)
    # numbers of one digit: rounding alone
    np.testing.assert_allclose(half.normal, normal, atol=1e-15)
    assert half.offset == pytest.approx(offset, abs=1e-15)


@pytest.mark.parametrize("text", ["z>=0.05", "x<=0.6", "0.7,-0.2,1.1>=-0.3"])
def test_clearance_is_positive_where_the_inequality_holds(text):
    """The inequality itself, as Python evaluates it."""
    half = HalfSpace.parse(text)
    points = np.random.default_rng(0).uniform(-1, 1, (500, 3))
    left, bound = text.replace("<=", ">=").split(">=")
    named = {"x": (1, 0, 0), "z": (0, 0, 1)}.get(left)
    factors = named or [float(part) for part in left.split(",")]
    values = points @ np.array(factors)
    holds = values >= float(bound) if ">=" in text else values <= float(bound)
    np.testing.assert_array_equal(half.clearance(points) >= 0.0, holds)
    # a distance: as far as the foot on the plane
    foot = points - half.clearance(points)[:, None] * half.normal
    np.testing.assert_allclose(half.clearance(foot), 0.0, atol=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "z",
        "z>0.05",
        "z==1",
        "w>=1",
        "z>=",
        ">=1",
        "z>=nan",
        "z>=inf",
        "z>=1_0",
        "0,0,0>=1",
        "1,2>=1",
        "1,2,3,4>=1",
        "1,nan,0>=1",
        "z>=0.1>=0.2",
        "z>=5000",
        "__import__('os')>=1",
    ],
)
def test_other_texts_are_refused(text):
    with pytest.raises(InputError, match=r"half-space.*; as in z>=0\.05") as error:
        HalfSpace.parse(text)
    assert "\n" not in str(error.value)

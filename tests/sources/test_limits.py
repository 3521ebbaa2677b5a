"""Samples that cannot be are left out and counted; the others pass unchanged."""

from collections import Counter

import numpy as np
import pytest

from hefting.online.samples import Samples
from hefting.sources import check

TIME = np.arange(5.0)


def bad(width: int, value: float, row: int = 2) -> np.ndarray:
    values = np.zeros((5, width))
    values[row, -1] = value
    return values


def turned(norm: float) -> np.ndarray:
    values = np.tile([0.0, 0.0, 0.0, 1.0], (5, 1))
    values[2] *= norm
    return values


@pytest.mark.parametrize(
    ("samples", "reason"),
    [
        (Samples("wrench", TIME, bad(6, np.nan)), "values that are not finite"),
        (Samples("wrench", TIME, bad(6, np.inf)), "values that are not finite"),
        (Samples("wrench", TIME, bad(6, 1e11)), "values that cannot be"),
        (Samples("position", TIME, bad(3, -1e9)), "values that cannot be"),
        (
            Samples("orientation", TIME, turned(1.1)),
            "quaternions that are not of unit norm",
        ),
        (
            Samples("orientation", TIME, turned(0.0)),
            "quaternions that are not of unit norm",
        ),
        (
            Samples("wrench", np.where(TIME == 2, 1e13, TIME), bad(6, 0.0)),
            "times that cannot be seconds",
        ),
    ],
)
def test_one_bad_sample_is_left_out(samples, reason):
    skipped: Counter[str] = Counter()
    found = check(samples, skipped)
    assert found is not None
    assert skipped == {reason: 1}
    assert found.time.tolist() == [0, 1, 3, 4]
    assert np.array_equal(found.values, np.delete(samples.values, 2, axis=0))


@pytest.mark.parametrize(
    "samples",
    [
        Samples("torque", TIME, np.zeros((5, 6))),
        Samples("wrench", TIME, np.zeros((5, 5))),
        Samples("wrench", TIME, np.zeros(5)),
        Samples("wrench", TIME[:4], np.zeros((5, 6))),
        Samples("joint_positions", TIME, np.zeros((5, 1001))),
    ],
)
def test_what_is_no_stream_is_left_out(samples):
    skipped: Counter[str] = Counter()
    assert check(samples, skipped) is None
    assert list(skipped) == ["not the shape of a stream"]


def test_good_samples_pass():
    skipped: Counter[str] = Counter()
    samples = Samples("joint_positions", TIME, np.ones((5, 7)))
    found = check(samples, skipped)
    assert found is not None
    assert np.array_equal(found.values, samples.values)
    assert not skipped

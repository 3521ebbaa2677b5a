"""Moments: which may be merged, and what the merged ones hold."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.moments import Moments
from random_problems import random_body, random_motion, with_wrench


@pytest.fixture
def z():
    rng = np.random.default_rng(1)
    return with_wrench(random_motion(rng, 60), random_body(rng), 0.3)


def test_moments_that_may_hold_two_biases_are_not_merged_unasked(z):
    for samples in (1, 40):
        first, second = Moments.of(z[:samples]), Moments.of(z[samples:])
        with pytest.raises(InputError, match="a wrench bias of its own"):
            first.merge(second)
    merged = first.merge(second, one_bias=True)
    whole = Moments.of(z)
    assert merged.samples == whole.samples
    # rounding of sums of sixty squares up to a thousand
    np.testing.assert_allclose(
        merged.factor.T @ merged.factor, whole.factor.T @ whole.factor, atol=1e-9
    )


def test_moments_without_a_bias_or_without_samples_merge_with_any(z):
    first, second = Moments.of(z[:40]), Moments.of(z[40:])
    assert first.may_hold_bias
    for other in (second.without_bias(), Moments.empty()):
        assert not other.may_hold_bias
        merged = first.merge(other)
        assert merged.samples == other.merge(first).samples
        expected = sum(each.factor.T @ each.factor for each in (first, other))
        np.testing.assert_allclose(merged.factor.T @ merged.factor, expected, atol=1e-9)

"""A covariance taken apart is put together again; what is none is refused."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.undetermined import Covariance

SIZES = 10.0 ** np.random.default_rng(5).uniform(-6, 1, 10)
"""Of deviations: those of masses and of inertias differ by as much."""


def covariance():
    """Of full rank."""
    root = SIZES[:, None] * np.random.default_rng(6).normal(size=(10, 10))
    return root @ root.T


def test_root_and_information():
    C = covariance()
    own = Covariance.of(C)
    scale = np.outer(own.size, own.size)
    # rounding of sums of ten numbers, and of an inverse of a condition of 1e5 at most
    np.testing.assert_allclose(own.root @ own.root.T / scale, C / scale, atol=1e-14)
    found = (own.information * scale) @ (C / scale)
    np.testing.assert_allclose(found, np.eye(10), atol=1e-9)
    assert not own.open.any()


def test_what_is_open_has_no_information():
    C = covariance()
    C[3], C[:, 3], C[3, 3] = 0.0, 0.0, np.inf
    own = Covariance.of(C)
    assert own.open.tolist() == [i == 3 for i in range(10)]
    scaled = own.information * np.outer(own.size, own.size)
    assert np.abs(scaled[3]).max() < 1e-9 * np.abs(scaled).max()  # rounding
    assert np.abs(own.root[3]).max() < 1e-7  # the root of rounding, ten times 2e-16
    rest = np.arange(10) != 3
    scale = np.outer(own.size[rest], own.size[rest])
    found = scaled[np.ix_(rest, rest)] @ (C[np.ix_(rest, rest)] / scale)
    np.testing.assert_allclose(found, np.eye(9), atol=1e-9)


def test_a_direction_without_variance_has_none():
    """Of ten numbers that two determine, all information is of these two."""
    root = np.random.default_rng(7).normal(size=(10, 2))
    own = Covariance.of(root @ root.T)
    assert np.linalg.matrix_rank(own.information, tol=1e-9) == 2
    back = root.T @ own.information @ root
    np.testing.assert_allclose(back, np.eye(2), atol=1e-9)


@pytest.mark.parametrize(
    ("places", "value", "what"),
    [
        ([(2, 2)], -1e-3, "negative or missing"),
        ([(1, 4)], np.nan, "negative or missing"),
        ([(0, 1)], 1e3, "not symmetric"),
        ([(0, 1), (1, 0)], 1e3, "not positive"),  # a correlation above 1
    ],
)
def test_what_is_none_is_refused(places, value, what):
    C = covariance()
    for place in places:
        C[place] = value
    with pytest.raises(InputError, match=what):
        Covariance.of(C)


def test_what_goes_with_an_open_parameter_is_left_out():
    """Not only its own variance, which is infinite."""
    C = covariance()
    closed = np.delete(np.delete(C, 3, axis=0), 3, axis=1)
    C[3, 3] = np.inf
    root = Covariance.of(C).root
    np.testing.assert_allclose(root[3], 0.0, atol=1e-14)
    kept = np.delete(root, 3, axis=0)
    scale = np.outer(np.delete(SIZES, 3), np.delete(SIZES, 3))
    np.testing.assert_allclose(kept @ kept.T / scale, closed / scale, atol=1e-13)

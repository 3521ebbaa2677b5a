"""The fit's normal equations: inverted in what they determine, with what they do not
said."""

import numpy as np
import pytest

from hefting.ingest.model import _invert_semidefinite, invert

SIZES = 10.0 ** np.arange(-3.0, 4.0)
"""Units of seven unknowns: they do not matter."""


def normal_matrix(least):
    """(7, 7) in those units, of eigenvalues 1 and, along (1, -1, 0 ..), `least`."""
    direction = np.array((1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0)) / np.sqrt(2.0)
    return (np.eye(7) - (1.0 - least) * np.outer(direction, direction)) * np.outer(
        SIZES, SIZES
    )


@pytest.mark.parametrize("least", [1.0, 1e-3, 1e-8])
def test_determined_equations_are_inverted(least):
    N = normal_matrix(least)
    inverse, undetermined = invert(N)
    assert not undetermined.any()
    # rounding, times the conditioning
    np.testing.assert_allclose(
        (N @ inverse) / np.outer(SIZES, 1.0 / SIZES), np.eye(7), atol=1e-14 / least
    )


@pytest.mark.parametrize("least", [1e-13, 0.0, -1e-15])
def test_what_equations_leave_open_is_left_out(least):
    """A direction that only rounding tells: its two unknowns are open, the others as if
    these were not there."""
    inverse, undetermined = invert(normal_matrix(least))
    np.testing.assert_array_equal(np.flatnonzero(undetermined), [0, 1])
    expected = np.eye(7)
    expected[:2, :2] = 0.5  # its own inverse along (1, 1), where its eigenvalue is 1
    np.testing.assert_allclose(inverse * np.outer(SIZES, SIZES), expected, atol=1e-9)


def test_an_unknown_without_a_column_is_open():
    N = normal_matrix(0.5)
    N[3], N[:, 3] = 0.0, 0.0
    inverse, undetermined = invert(N)
    np.testing.assert_array_equal(np.flatnonzero(undetermined), [3])
    rest = np.delete(np.arange(7), 3)
    np.testing.assert_allclose(
        inverse[np.ix_(rest, rest)] @ N[np.ix_(rest, rest)], np.eye(6), atol=1e-8
    )
    assert not inverse[3].any()


@pytest.mark.parametrize("largest", [0.01, 100.0])
@pytest.mark.parametrize(("share", "open_"), [(3e-12, True), (3e-11, False)])
def test_a_direction_is_open_by_its_eigenvalue_over_the_largest(largest, share, open_):
    """Below a hundred billionth of it, however large that is."""
    scaled = np.diag((largest, largest * share))
    inverse, undetermined = _invert_semidefinite(
        scaled, np.ones(2), np.ones(2, dtype=bool)
    )
    np.testing.assert_array_equal(undetermined, [False, open_])
    expected = 0.0 if open_ else 1.0 / (largest * share)
    np.testing.assert_allclose(inverse[1, 1], expected)


@pytest.mark.parametrize(("share", "open_"), [(0.9e-4, False), (1.2e-4, True)])
def test_an_unknown_is_open_by_its_part_in_an_open_direction(share, open_):
    """From a ten thousandth of its square on."""
    direction = np.zeros(5)
    direction[:2] = np.sqrt((1.0 - share, share))
    scaled = np.eye(5) - np.outer(direction, direction)
    _, undetermined = _invert_semidefinite(scaled, np.ones(5), np.ones(5, dtype=bool))
    np.testing.assert_array_equal(undetermined, [True, open_, False, False, False])

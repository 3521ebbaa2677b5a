"""Bounds: prior of an object that is somewhere inside a box, of any shape and
orientation.

In a cube of unit sides about its middle, for 1 kg: c (3,) is the centre of mass, S
(3, 3) the second moment about it. For a member of the mixture c has the mean zero and
the standard deviation gamma along each axis; the moments S_ii have the mean m, the
variance a m² and the correlation rho, the products S_ij the mean zero and the variance
b m². A box stretches the cube along its sides.
"""

import numpy as np

from hefting.core.spatial import Array

BOUNDS_MEMBERS = np.array(
    (
        (0.04, 0.025, 0.15, 0.9, 0.15, 0.013),
        (0.04, 0.045, 0.03, 0, 0.15, 0.082),
        (0.04, 0.045, 0.03, 0, 0.6, 0.017),
        (0.04, 0.045, 0.03, 0.5, 0.003, 0.011),
        (0.04, 0.045, 0.03, 0.5, 0.15, 0.016),
        (0.04, 0.045, 0.15, 0, 0.15, 0.027),
        (0.04, 0.065, 0.15, -0.4, 0.6, 0.077),
        (0.08, 0.025, 0.15, 0, 0.03, 0.016),
        (0.08, 0.025, 0.15, 0.5, 0.15, 0.074),
        (0.08, 0.025, 0.15, 0.9, 0.15, 0.017),
        (0.08, 0.045, 0.03, 0.5, 0.15, 0.033),
        (0.08, 0.045, 0.03, 0.9, 0.15, 0.017),
        (0.08, 0.045, 0.15, -0.4, 0.15, 0.03),
        (0.08, 0.045, 0.15, 0, 0.15, 0.06),
        (0.08, 0.045, 0.15, 0, 0.6, 0.053),
        (0.15, 0.003, 0.15, 0.9, 0.15, 0.025),
        (0.15, 0.01, 0.15, 0, 0.15, 0.04),
        (0.15, 0.01, 0.15, 0.5, 0.15, 0.033),
        (0.15, 0.01, 0.15, 0.9, 0.03, 0.026),
        (0.15, 0.01, 0.15, 0.9, 0.15, 0.035),
        (0.15, 0.01, 0.5, 0, 0.03, 0.009),
        (0.15, 0.01, 0.5, 0, 0.15, 0.019),
        (0.15, 0.025, 0.15, 0, 0.15, 0.069),
        (0.15, 0.025, 0.15, 0, 0.6, 0.022),
        (0.15, 0.025, 0.15, 0.5, 0.15, 0.057),
        (0.15, 0.025, 0.5, -0.4, 0.15, 0.023),
        (0.15, 0.045, 0.03, 0.5, 0.6, 0.029),
        (0.15, 0.045, 0.15, 0, 0.6, 0.067),
        (0.28, 0.01, 0.5, 0, 0.6, 0.03),
        (0.28, 0.045, 0.5, 0, 0.6, 0.03),
        (0.06, 0.07, 0.06, 0, 0.003, 0.06),
        (0.06, 0.083, 0.02, 0, 0.003, 0.06),
        (0.08, 0.1, 0.06, 0.3, 0.03, 0.06),
        (0.06, 0.13, 0.06, 0, 0.003, 0.05),
    )
)
"""(j, 6) gamma, m, a, rho, b and prior probability of the members for a box.

Found by expectation maximisation over 1,800 candidates, those of least weight left out
one after the other: the likelihood of 1,080 bodies (`benchmarks.bodies`, seeds 60000
and up), each turned three times at random inside a box along the axes, half of the
boxes touching it, half up to 3.5 times as large. The two of gamma 0.28 were added for
boxes of which the object is in a corner; the last four for objects that are the box, as
a parcel: cylinders along its sides (1/16 and 1/12), filled (1/12) or hollow (0.14)
ones, and walls with something in them. Bodies turned at random fill no box, and of
parcels at 150 samples 85 % of the moments of inertia were inside 95 % intervals; with
these 96 %."""
REACH_MEMBERS = np.array(
    (
        (0.02, 0.0003, 0.15, 0.5, 0.03, 0.021),
        (0.04, 0.0006, 0.15, 0, 0.15, 0.048),
        (0.04, 0.001, 0.15, -0.4, 0.15, 0.018),
        (0.04, 0.001, 0.15, 0, 0.15, 0.037),
        (0.04, 0.001, 0.5, -0.4, 0.15, 0.032),
        (0.04, 0.002, 0.15, 0, 0.15, 0.066),
        (0.04, 0.002, 0.5, -0.4, 0.15, 0.082),
        (0.04, 0.002, 0.5, 0, 0.6, 0.018),
        (0.04, 0.004, 0.5, -0.4, 0.6, 0.019),
        (0.04, 0.004, 0.5, 0, 0.15, 0.051),
        (0.04, 0.008, 0.5, 0, 0.6, 0.021),
        (0.08, 0.0003, 0.15, 0.5, 0.03, 0.024),
        (0.08, 0.0006, 0.5, -0.4, 0.15, 0.017),
        (0.08, 0.001, 0.15, 0, 0.15, 0.036),
        (0.08, 0.001, 0.5, -0.4, 0.15, 0.021),
        (0.08, 0.002, 0.5, -0.4, 0.15, 0.058),
        (0.08, 0.002, 0.5, -0.4, 0.6, 0.02),
        (0.08, 0.002, 0.5, 0, 0.15, 0.031),
        (0.08, 0.002, 0.5, 0, 0.6, 0.071),
        (0.08, 0.004, 0.5, -0.4, 0.15, 0.044),
        (0.08, 0.004, 0.5, 0, 0.6, 0.028),
        (0.08, 0.008, 0.5, -0.4, 0.6, 0.032),
        (0.16, 0.0006, 0.15, 0, 0.15, 0.03),
        (0.16, 0.001, 0.5, -0.4, 0.15, 0.04),
        (0.16, 0.002, 0.5, -0.4, 0.15, 0.062),
        (0.16, 0.002, 0.5, 0, 0.6, 0.034),
        (0.16, 0.004, 0.5, -0.4, 0.15, 0.02),
        (0.16, 0.004, 0.5, 0, 0.6, 0.02),
        (0.16, 0.016, 0.5, 0, 0.6, 0.03),
        (0.3, 0.004, 0.5, 0, 0.6, 0.03),
    )
)
"""(j, 6) the same where nothing is known but that a robot holds it: a cube of 1 m about
the sensor, in which bodies as above, of half to twice the size, have their centre of
mass up to 0.3 m further away than they were made to. The two last of gamma 0.16 and 0.3
were added for large objects."""
OFF_CENTRE_GROWTH = 1.0
"""As `densities.OFF_CENTRE_GROWTH`, about the middle of the box. By the parallel axis
theorem it is 1, as the second moment about the COM is the same anywhere in the box."""
WIDER_COM, WIDER_MOMENTS = 1.3, 2.0
"""Factors of gamma, and of a and b, for objects unlike those fitted."""
EVEN_COM = 12.0**-0.5
"""Least gamma for a box: that of a centre of mass uniformly distributed in it. A
smaller one would bias the mass where forces are doubtful and the first moment is not.
"""
_DIAGONAL, _PRODUCTS = (3, 6, 8), (4, 5, 7)
"""Indices of S_ii and S_ij among c and xx, xy, xz, yy, yz, zz of S."""


def bounded_members(
    table: Array, sides: Array, least_gamma: float
) -> tuple[Array, Array]:
    """For a box of `sides` (3,) [m]: means (j, 10) of the members for 1 kg about its
    middle, and factors (j, 9, 9) of their covariances without the mass. `least_gamma`
    is a lower bound of gamma."""
    wider = (WIDER_COM, 1.0, WIDER_MOMENTS, 1.0, WIDER_MOMENTS)
    gamma, m, variance, correlation, products = (table[:, :5] * wider).T
    gamma = np.maximum(gamma, least_gamma)
    Q = np.zeros((len(table), 9, 9))
    mean = np.zeros((len(table), 9))
    for i in range(3):
        Q[:, i, i] = gamma**2
        mean[:, _DIAGONAL[i]] = m
        Q[:, _PRODUCTS[i], _PRODUCTS[i]] = products * m**2
        for k in range(3):
            shared = 1.0 if i == k else correlation
            Q[:, _DIAGONAL[i], _DIAGONAL[k]] = variance * m**2 * shared
    onto = _onto_parameters(sides)
    means = np.concatenate((np.ones((len(table), 1)), mean @ onto.T), axis=1)
    return means, onto @ np.linalg.cholesky(Q)


def _onto_parameters(sides: Array) -> Array:
    """(9, 9) map of c and S in the unit cube to the moments of 1 kg in the box."""
    onto = np.zeros((9, 9))
    onto[:3, :3] = np.diag(sides)
    rows, columns = np.triu_indices(3)
    stretch = sides[rows] * sides[columns]
    inertia = -np.eye(6)
    for i in (0, 3, 5):
        for k in (0, 3, 5):
            inertia[i, k] = 0.0 if i == k else 1.0
    onto[3:, 3:] = inertia * stretch
    return onto

"""Observability of the reduced model with its force rows: the appendix A of Nadeau et
al. 2022."""

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.moments import Moments
from hefting.core.regressor import reduced_regressor
from hefting.estimators import PMD
from hefting.ingest.identifiability import rank
from hefting.shapes import Shape
from random_problems import with_wrench
from restricted_motions import at_rest, rotated, turning


def point_matrix(points):
    """(4, n) of 1 and the coordinates: masses to m and m c."""
    return np.vstack((np.ones(len(points)), points.T))


@pytest.mark.parametrize("seed", range(5))
def test_rank_of_the_reduced_model(seed):
    """4 once gravity takes two directions that are not parallel; 3 for one pose, or
    turning about the vertical.

    In sensor axes about the sensor's origin the force rows see m, and the torque rows m
    c across gravity.
    """
    rng = np.random.default_rng([12, seed])
    one, other = rng.normal(size=(2, 3))
    assert rank(Moments.of(at_rest(one)), "reduced") == 3
    assert rank(Moments.of(at_rest(one, -one, 2.0 * one)), "reduced") == 3
    assert rank(Moments.of(at_rest(one, other)), "reduced") == 4
    assert (
        rank(Moments.of(at_rest(one, other, *rng.normal(size=(9, 3)))), "reduced") == 4
    )
    R = Rotation.random(rng=rng).as_matrix()
    assert rank(Moments.of(rotated(turning((0, 0, 1)), R)), "reduced") == 3
    assert rank(Moments.of(rotated(turning((0, 1, 0)), R)), "reduced") == 4
    torques = reduced_regressor(at_rest(one, other))[:, 3:, :4].reshape(-1, 4)
    assert np.linalg.matrix_rank(torques) == 3  # which say nothing of the mass


@pytest.mark.parametrize("seed", range(5))
def test_the_kernel_in_point_masses_keeps_mass_and_com(seed):
    """Of n points the reduced model leaves n - 4 directions open; none changes sum m or
    sum m p, and they are all."""
    rng = np.random.default_rng([13, seed])
    n = int(rng.integers(8, 60))
    points = 0.1 * rng.normal(size=(n, 3)) + 0.2 * rng.normal(size=3)
    z = at_rest(*rng.normal(size=(5, 3)))
    AM = reduced_regressor(z).reshape(-1, 10) @ Shape(points).matrix
    kernel = null_space(AM)
    assert kernel.shape == (n, n - 4)
    # rounding of unit vectors
    np.testing.assert_allclose(point_matrix(points) @ kernel, 0.0, atol=1e-12)
    masses = rng.exponential(size=n)
    changed = masses + kernel @ rng.normal(size=n - 4)
    assert np.linalg.norm(changed - masses) > 1.0
    body, other = (InertialParameters.from_points(points, m) for m in (masses, changed))
    np.testing.assert_allclose(other.vector[:4], body.vector[:4], atol=1e-12)
    # but the inertia is not kept
    assert np.abs(other.vector[4:] - body.vector[4:]).max() > 1e-4
    np.testing.assert_allclose(AM @ null_space(point_matrix(points)), 0.0, atol=1e-11)
    short = null_space(
        reduced_regressor(at_rest((0, 0, -1))).reshape(-1, 10) @ Shape(points).matrix
    )
    assert short.shape == (n, n - 3)  # of one pose the kernel moves the COM up and down
    moved = point_matrix(points) @ short
    np.testing.assert_allclose(moved[:3], 0.0, atol=1e-12)
    assert np.abs(moved[3]).max() > 0.01


def reduced_problem(seed, regularization):
    """PMD on the reduced model alone, static poses, noise, more points than data can
    tell apart."""
    rng = np.random.default_rng([14, seed])
    points = rng.uniform(-0.1, 0.1, (30, 3)) + np.array((0.0, 0.0, 0.1))
    body = InertialParameters.from_points(points, rng.exponential(size=30) / 30)
    z = with_wrench(
        at_rest(*rng.normal(size=(6, 3)), each=3), body, 0.0, rng, 0.1, 0.01
    )
    pmd = PMD(Shape(points), regularization=regularization, model="reduced")
    return pmd, pmd.update(pmd.start(), z), z, rng


@pytest.mark.parametrize("regularization", [1e-3, 0.1, 10.0])
@pytest.mark.parametrize("seed", range(3))
def test_any_regularization_makes_the_solution_unique(seed, regularization):
    """Two starts at the shape's opposite ends lead to the same masses.

    Between any two masses of lengths at most L, |m| at the middle is (|d|² - e²) / 8 L
    or more below its mean, d their difference and e that of their lengths: so |d|² <=
    e² + 8 L (mean objective - lower bound) / lambda.
    """
    pmd, state, z, _ = reduced_problem(seed, regularization)
    points = pmd.shape.positions
    ends = []
    for index in (np.argmin(points[:, 0]), np.argmax(points[:, 0])):
        masses = np.full(30, 1e-6)
        masses[index] = 5.0
        start = Estimate(
            "PMD",
            InertialParameters.from_points(points, masses),
            1,
            point_masses=masses,
        )
        ends.append(pmd.estimate(state, start=start))
    one, other = (e.point_masses for e in ends)
    lengths = np.linalg.norm(one), np.linalg.norm(other)
    objectives = np.array([e.certificate.objective for e in ends])
    slack = objectives.mean() - max(e.certificate.bound for e in ends)
    bound = (lengths[0] - lengths[1]) ** 2 + 8.0 * max(lengths) * max(
        slack, 0.0
    ) / regularization
    difference = np.linalg.norm(one - other)
    assert difference**2 <= bound + 1e-20
    # the starts are 7 kg apart; the law leaves 5e-4 of the length at gaps of 5e-12 to
    # 2e-7 N
    assert difference < 1e-3 * max(lengths)
    AM = reduced_regressor(z).reshape(-1, 10) @ pmd.shape.matrix
    plain = np.linalg.eigvalsh(AM.T @ AM)
    assert np.sum(plain > 1e-9 * plain[-1]) == 4  # semidefinite
    curved = np.linalg.eigvalsh(AM.T @ AM + regularization * np.eye(30))
    assert curved[0] >= 0.99 * regularization  # rounding: 1e-13 of the largest


@pytest.mark.parametrize("seed", range(3))
def test_without_regularization_the_solution_is_not_unique(seed):
    """Two non-negative masses far apart with one objective, which is the optimum: PMD's
    own and another corner."""
    pmd, state, z, rng = reduced_problem(seed, 0.0)
    found = pmd.estimate(state)
    P = point_matrix(pmd.shape.positions)
    corner = linprog(
        rng.normal(size=30),
        A_eq=P,
        b_eq=P @ found.point_masses,
        bounds=(0, None),
        method="highs",
    ).x
    A, b = reduced_regressor(z).reshape(-1, 10), z.wrench.ravel()
    objectives = [
        np.linalg.norm(A @ pmd.shape.matrix @ m - b)
        for m in (found.point_masses, corner)
    ]
    assert np.linalg.norm(corner - found.point_masses) > 0.1 * found.parameters.mass
    assert corner.min() >= 0.0
    # the linear program's tolerance
    assert objectives[1] == pytest.approx(objectives[0], rel=1e-7)
    assert found.certificate.gap <= 1e-5 * objectives[0]

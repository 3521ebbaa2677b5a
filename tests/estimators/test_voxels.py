"""Voxels of a shape, and the prior over densities in them, each against another way to
the same numbers."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, tensor_to_vector, vector_to_tensor
from hefting.estimators.bayes.densities import MEMBERS, between_cells
from hefting.estimators.bayes.distortion import affine
from hefting.estimators.bayes.prior import Prior
from hefting.estimators.bayes.voxels import Voxels, _group_points
from hefting.shapes import Shape


def box(**settings) -> Shape:
    return Shape.from_box(-0.05, 0.15, -0.03, 0.01, 0.02, 0.12, **settings)


@pytest.mark.parametrize("points", [8, 56, 400, 6000])
def test_the_prior_holds_the_homogeneous_body_exactly(points):
    """Its mean, its voxels and its cells, whatever the number of points; cells gathered
    from many points too."""
    solid = box(points=points)
    prior, sides = Prior.of(solid, (0.0, 0.0)), np.array((0.2, 0.04, 0.1))
    J = (np.eye(3) * (sides @ sides) - np.diag(sides**2)) / 12.0
    # closed form of a box
    body = InertialParameters.from_com(1.0, (0.05, -0.01, 0.07), J)
    for vector in (prior.mean, prior.voxels @ prior.voxel_shares):
        np.testing.assert_allclose(vector, body.vector, atol=1e-12)
    # shares of points and cells are those of `Shape`, exact for a box
    np.testing.assert_allclose(prior.cells @ prior.shares, body.vector, atol=1e-12)
    assert np.exp(prior.log_weight).sum() == pytest.approx(1.0, abs=1e-12)


def test_the_prior_expects_what_random_densities_do():
    """Q1 is the covariance of 3,000 bodies of random density and given mass, drawn from
    the process itself."""
    rng, solid = np.random.default_rng(1), box(points=140)
    x = solid.positions
    v = solid.volumes
    diagonal = float(np.linalg.norm((0.2, 0.04, 0.1)))
    assert v is not None
    C = np.exp(
        -0.5 * ((x[:, None] - x[None]) ** 2).sum(axis=2) / (0.25 * diagonal) ** 2
    )
    density = np.linalg.cholesky(C + 1e-9 * np.eye(len(x))) @ rng.normal(
        size=(len(x), 3000)
    )
    density -= np.outer(C @ v, v @ density) / (v @ C @ v)  # given the mass
    drawn = (
        affine(np.eye(3), -solid.homogeneous.center_of_mass)
        @ solid.cell_matrix
        @ (v[:, None] * density)
    )
    Q1 = between_cells(Voxels.of(solid), 0.25 * diagonal)
    scale = np.sqrt(np.cov(drawn).diagonal()[1:])
    # a deviation of 3,000 draws is 1.3 % of a standard deviation; four of it, twice for
    # variances
    np.testing.assert_allclose(
        (Q1 - np.cov(drawn)[1:, 1:]) / np.outer(scale, scale), 0.0, atol=0.1
    )


def test_a_shell_is_one_of_the_bodies_expected():
    """Members with a shell have the direction of Qd, an empty box's inertia about its
    middle, beside that of the same density without one."""
    Q = covariances(box(points=56))
    sigma, _, delta, kappa = MEMBERS[:, :4].T
    # of even density, but for the shell, and little freedom of the inertia
    shells = (sigma < 0.15) & (delta >= 1.0) & (kappa < 0.1)
    even = (sigma < 0.15) & (delta == 0.0) & (kappa < 0.1)
    assert shells.any()
    assert even.any()
    growth = np.trace(Q[:, 3:, 3:], axis1=1, axis2=2) ** 0.5
    # delta is ten times sigma and more
    assert growth[shells].max() > 3.0 * growth[even].max()


def test_members_scatter_as_their_numbers_say():
    """Without a shell the centre of mass scatters by sigma, and the inertia given the
    centre of mass by kappa; the weights are probabilities."""
    assert MEMBERS[:, 5].sum() == pytest.approx(1.0, abs=0.02)  # three digits each
    assert (MEMBERS[:, (0, 1, 3, 5)] > 0.0).all()
    assert (MEMBERS[:, 2] >= 0.0).all()
    assert (MEMBERS[:, 1] < 1.0).all()  # lengths are shares of the diagonal
    assert set(MEMBERS[:, 4]) == {0.0, 1.0}  # whether the pose may be off
    prior = Prior.of(box(points=56), (0.0, 0.0))
    assert np.exp(prior.log_weight).sum() == pytest.approx(1.0, abs=1e-12)
    Q = covariances(box(points=56))
    even = np.flatnonzero((MEMBERS[:, 2] == 0.0) & (MEMBERS[:, 1] == 0.25))
    given = [q[3:, 3:] - q[3:, :3] @ np.linalg.solve(q[:3, :3], q[:3, 3:]) for q in Q]
    for number, found in ((0, Q[:, :3, :3]), (3, np.array(given))):
        size = np.trace(found, axis1=1, axis2=2)[even] ** 0.5
        ratio = MEMBERS[even, number] / MEMBERS[even[0], number]
        np.testing.assert_allclose(size / size[0], ratio, rtol=1e-6)


def covariances(solid: Shape) -> Array:
    """(j, 9, 9) of the prior's members about the homogeneous COM."""
    T = affine(np.eye(3), -solid.homogeneous.center_of_mass)
    F = (T @ Prior.of(solid, (0.0, 0.0)).spread)[:, 1:, 1:]
    return F @ F.transpose(0, 2, 1)


def test_voxels_fill_their_cells_whatever_way_these_are_turned():
    """Cells askew to the shape's own axes: the voxels of each have its mean and its
    inertia."""
    solid, R = box(points=56), Rotation.from_rotvec((0.4, -0.7, 0.2)).as_matrix()
    assert solid.cell_inertia is not None
    turned = Shape(
        solid.positions @ R.T,
        cell_inertia=tensor_to_vector(R @ vector_to_tensor(solid.cell_inertia) @ R.T),
        volumes=solid.volumes,
    )
    for each in (solid, turned):
        middle = affine(np.eye(3), each.homogeneous.center_of_mass)
        # rounding
        np.testing.assert_allclose(
            middle @ Voxels.of(each).points, each.cell_matrix, atol=1e-12
        )


def test_distances_to_the_surface_are_scipys():
    from scipy.ndimage import distance_transform_edt

    from hefting.estimators.bayes.voxels import _distance_to_outside

    rng, step = np.random.default_rng(0), np.array((0.01, 0.02, 0.005))
    for size in ((5, 7, 9), (20, 30, 12), (3, 3, 60)):
        filled = np.zeros(size, dtype=bool)
        filled[1:-1, 1:-1, 1:-1] = rng.random(tuple(n - 2 for n in size)) < 0.97
        expected = distance_transform_edt(filled, sampling=step)
        # rounding
        np.testing.assert_allclose(
            _distance_to_outside(filled, step), expected, rtol=1e-12
        )


def test_voxels_of_points_without_volumes_are_shares_of_the_whole():
    """Of few points and of more than are cells: shares sum to one at every level, and
    each level has the mean of the homogeneous body."""
    rng = np.random.default_rng(3)
    for count in (1, 40, 400):
        points = rng.uniform(-0.1, 0.1, (count, 3))
        cloud = Shape(points - points.mean(axis=0))  # voxels are about the middle
        voxels = Voxels.of(cloud)
        expected = cloud.homogeneous.vector / cloud.homogeneous.mass
        np.testing.assert_allclose(voxels.mean, expected, atol=1e-12)
        for parameters, shares in (
            (voxels.parameters, voxels.volumes),
            (voxels.points, voxels.shares),
            (voxels.cells, voxels.cell_shares),
        ):
            assert shares.sum() == pytest.approx(1.0, rel=1e-12)
            np.testing.assert_allclose(parameters @ shares, expected, atol=1e-12)


@pytest.mark.parametrize("sides", [(0.4, 0.3, 0.2), (1.0, 0.02, 0.02)])
def test_points_are_grouped_by_cubes(sides):
    """Points of one group are within a cube, those of two groups in cubes apart; there
    are no more groups than twice as many as are asked for, and no far fewer: of the
    long one the first cubes tried, of a hundredth of the volume, make 252."""
    points = np.random.default_rng(4).uniform(0.0, sides, (20_000, 3))
    label = _group_points(points, 100)
    groups = [points[label == each] for each in range(label.max() + 1)]
    assert 40 <= len(groups) <= 200
    pitch = max(float(np.ptp(group, axis=0).max()) for group in groups)
    low = np.array([group.min(axis=0) for group in groups]) / pitch
    assert len(np.unique(np.round(low - 0.25), axis=0)) == len(groups)

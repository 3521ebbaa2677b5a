"""The parts of Bayes: prior, likelihood, mixture and projection, each against another
way to the same numbers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, norm

from hammers import counted_lengths, exact, noisy, shape
from hefting.core.errors import InputError
from hefting.core.estimate import com_jacobian
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.regressor import full_regressor, predict_wrench
from hefting.core.spatial import Array, tensor_to_vector, vector_to_tensor
from hefting.estimators import OLS, Bayes
from hefting.estimators.bayes import projection
from hefting.estimators.bayes.densities import MEMBERS, between_cells
from hefting.estimators.bayes.distortion import affine
from hefting.estimators.bayes.likelihood import Equations, Likelihood, motion_effect
from hefting.estimators.bayes.mixture import Mixture, prior_mixture
from hefting.estimators.bayes.prior import Prior
from hefting.estimators.bayes.projection import projected
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.bayes.voxels import Voxels, _group_points
from hefting.shapes import Shape
from hefting.simulation import hammer

# prior


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


# likelihood


@pytest.mark.parametrize("free_bias", [False, True])
def test_residuals_have_the_covariance_of_a_sample(free_bias):
    """About their mean where a bias is free, which takes one of eight samples; about
    zero where it is not."""
    z = noisy(3, 8, Noise(0.1, 0.005))
    samples = Samples.of(OLS().update(OLS().start(), z), free_bias)
    phi = 0.9 * hammer().parameters.vector
    r = z.wrench - predict_wrench(z, phi)
    expected = np.cov(r.T) if free_bias else r.T @ r / 8
    np.testing.assert_allclose(
        samples.residual_covariance(phi, spent=0.0), expected, rtol=1e-7, atol=1e-12
    )


def test_a_rough_mass_is_force_over_acceleration():
    """In step with it, or by its size beyond the noise, or three deviations of the
    noise; signs do not matter."""
    z, mass = exact(50), hammer().parameters.mass
    still = replace(
        z, angular_velocity=0.0 * z.gravity, angular_acceleration=0.0 * z.gravity
    )
    felt = still.linear_acceleration - still.gravity

    def rough(force, std):
        filled = replace(still, force=force, torque=0.0 * force)
        return Samples.of(OLS().update(OLS().start(), filled), False).mass_scale(std)

    assert rough(mass * felt, 0.0) == pytest.approx(mass, rel=1e-9)
    assert rough(-mass * felt, 0.0) == pytest.approx(mass, rel=1e-9)
    across = np.cross(felt, (0.3, -0.5, 0.8))
    assert rough(across, 0.0) == pytest.approx(
        np.linalg.norm(across) / np.linalg.norm(felt), rel=1e-9
    )
    # of 150 numbers' squares, 0.09 each are noise
    less = (np.sum(across**2) - 150 * 0.09) ** 0.5
    assert rough(across, 0.3) == pytest.approx(less / np.linalg.norm(felt), rel=1e-9)
    assert rough(0.01 * felt, 0.5) == pytest.approx(
        1.5 / np.linalg.norm(felt), rel=1e-9
    )


def test_the_likelihood_is_weighted_least_squares_where_the_motion_is_exact():
    z = noisy(1, 200, Noise(0.1, 0.005))
    samples = Samples.of(
        Bayes(shape()).update(Bayes(shape()).start(), z), free_bias=False
    )
    S = np.diag(np.repeat((0.01, 2.5e-5), 3))
    found = Equations.of(samples, hammer().parameters.vector, S, None).white()
    A, W = full_regressor(z), np.linalg.inv(S)
    np.testing.assert_allclose(
        found.precision, np.einsum("kia,ij,kjb->ab", A, W, A), rtol=1e-9, atol=1e-9
    )
    np.testing.assert_allclose(
        found.shift, np.einsum("kia,ij,kj->a", A, W, z.wrench), rtol=1e-9, atol=1e-7
    )


def test_a_free_bias_is_that_of_weighted_least_squares():
    z = noisy(2, 300, Noise(0.1, 0.005))
    offset = np.array((1.0, -2.0, 3.0))
    z = replace(z, force=z.force + offset, torque=z.torque - 0.1 * offset)
    state = OLS().update(OLS().start(), z)
    samples = Samples.of(state, free_bias=True)
    S = np.diag(np.repeat((0.01, 2.5e-5), 3))
    found = Equations.of(samples, hammer().parameters.vector, S, None).white()
    theirs = OLS("estimate", noise=S).estimate(state)
    phi = np.linalg.solve(found.precision, found.shift)
    deviation = np.sqrt(theirs.covariance.diagonal())
    np.testing.assert_allclose(
        (phi - theirs.parameters.vector) / deviation, 0.0, atol=1e-6
    )
    np.testing.assert_allclose(samples.bias(phi), theirs.bias, atol=1e-6)
    np.testing.assert_allclose(
        np.linalg.inv(found.precision), theirs.covariance, rtol=1e-5, atol=1e-15
    )


def test_noise_of_the_motion_neither_biases_nor_goes_unnoticed():
    """Over 400 recordings the corrected equations hold on average, and scatter as V
    says."""
    phi, S_k = hammer().parameters.vector, np.repeat((0.05**2, 0.5**2), 3)
    E = motion_effect(phi)
    S = np.diag(np.repeat((0.01, 2.5e-5), 3)) + (E * S_k) @ E.T
    squares, errors = [], []
    for seed in range(400):
        samples = Samples.of(
            OLS().update(OLS().start(), noisy(seed, 60)), free_bias=False
        )
        found = Equations.of(samples, phi, S, S_k).white()
        error = found.shift - found.precision @ phi
        squares.append(
            error @ np.linalg.pinv(found.precision, rcond=1e-13, hermitian=True) @ error
        )
    # chi² of ten degrees at the truth: 10, to 0.22 on average over 400; four deviations
    assert np.mean(squares) == pytest.approx(10.0, abs=0.9)
    for seed in range(60):
        samples = Samples.of(OLS().update(OLS().start(), noisy(seed)), free_bias=False)
        both = (Equations.of(samples, phi, S, given).white() for given in (S_k, None))
        errors.append(
            [np.linalg.solve(each.precision, each.shift) - phi for each in both]
        )
    # without the correction the inertia is attenuated: by many standard errors, which
    # with it are few
    t = np.mean(errors, axis=0) / (np.std(errors, axis=0) / 60**0.5)
    assert np.abs(t[0]).max() < 4.5
    assert np.abs(t[1, [4, 7, 9]]).max() > 10.0


def test_effect_of_accelerations_on_the_wrench():
    """E by finite differences of the wrench itself."""
    phi, z = hammer().parameters.vector, exact(5)
    E = motion_effect(phi)
    for q, name in enumerate(("linear_acceleration", "angular_acceleration")):
        for axis in range(3):
            moved = replace(z, **{name: getattr(z, name) + np.eye(3)[axis]})
            change = predict_wrench(moved, phi) - predict_wrench(z, phi)
            np.testing.assert_allclose(
                change, np.tile(E[:, 3 * q + axis], (5, 1)), atol=1e-12
            )


# mixture


def covariances_of(mixture: Mixture) -> np.ndarray:
    """(j, 10, 10) of the members."""
    return mixture.factors @ mixture.factors.transpose(0, 2, 1)


def random_mixture(seed: int) -> Mixture:
    rng = np.random.default_rng(seed)
    means = hammer().parameters.vector * (1.0 + 0.02 * rng.normal(size=(5, 10)))
    roots = (
        0.01
        * np.abs(hammer().parameters.vector).max()
        * rng.normal(size=(5, 10, 10))
        * 0.1
    )
    weights = rng.random(5)
    return Mixture(weights / weights.sum(), means, roots)


def test_the_evidence_is_the_probability_of_the_samples_by_the_prior():
    """Their best parameters are normal about each member's mean, with both covariances
    together; what is the same for every prior is left out."""
    rng = np.random.default_rng(5)
    X = rng.normal(size=(10, 10))
    precision, best = X @ X.T, rng.normal(size=10) + 2.0 * np.eye(10)[0]
    likelihood = Likelihood(precision, precision @ best, np.eye(6))

    def evidence(prior: Prior) -> tuple[float, float]:
        means = np.zeros((len(prior.spread), 10)) + prior.mean
        means = means if prior.offsets is None else means + prior.offsets
        each = [
            multivariate_normal(
                2.0 * mean, 4.0 * F @ F.T + np.linalg.inv(precision)
            ).logpdf(best)
            for mean, F in zip(means, prior.spread, strict=True)
        ]
        found = Mixture.of(prior, 2.0, likelihood).evidence
        return found, float(logsumexp(np.add(each, prior.log_weight)))

    pairs = [
        evidence(Prior.of(shape())),
        evidence(Prior.of_bounds(Shape.unknown())),
        evidence(Prior.of_bounds(Shape.from_box(-0.1, 0.2, -0.1, 0.1, 0.0, 0.3))),
    ]
    found, expected = np.array(pairs).T
    np.testing.assert_allclose(np.diff(found), np.diff(expected), atol=1e-6)


@pytest.mark.parametrize("level", [0.5, 0.95, 0.999])
def test_intervals_are_quantiles_of_the_mixture(level):
    """By the distribution function of each number, with `com_jacobian` for the delta
    method."""
    mixture = random_mixture(3)
    found = mixture.intervals(level)
    J = [com_jacobian(InertialParameters(m)) for m in mixture.means]
    bodies = [InertialParameters(m) for m in mixture.means]
    cases = {
        "mass": (found["mass"], [b.mass for b in bodies], [j[0] for j in J]),
        "com": (
            found["center_of_mass"][:, 1],
            [b.center_of_mass[1] for b in bodies],
            [j[2] for j in J],
        ),
        "inertia_at_com": (
            found["inertia_at_com"][:, 0, 2],
            [b.inertia_at_com[0, 2] for b in bodies],
            [j[6] for j in J],
        ),
        "inertia": (
            found["inertia_at_origin"][:, 1, 2],
            [b.vector[8] for b in bodies],
            [np.eye(10)[8]] * 5,
        ),
    }
    for name, (ends, means, rows) in cases.items():
        stds = [
            np.sqrt(row @ C @ row)
            for row, C in zip(rows, covariances_of(mixture), strict=True)
        ]
        reached = [float(mixture.weights @ norm.cdf(end, means, stds)) for end in ends]
        np.testing.assert_allclose(
            reached, (0.5 - level / 2, 0.5 + level / 2), atol=1e-5, err_msg=name
        )


def test_mean_and_covariance_are_those_of_draws():
    mixture, rng = random_mixture(4), np.random.default_rng(5)
    members = rng.choice(5, size=200_000, p=mixture.weights)
    draws = np.concatenate(
        [
            rng.multivariate_normal(
                mixture.means[j], covariances_of(mixture)[j], int((members == j).sum())
            )
            for j in range(5)
        ]
    )
    scale = np.sqrt(mixture.covariance.diagonal())
    # five deviations
    np.testing.assert_allclose(
        draws.mean(axis=0) / scale, mixture.mean / scale, atol=0.012
    )
    np.testing.assert_allclose(
        np.cov(draws.T) / np.outer(scale, scale),
        mixture.covariance / np.outer(scale, scale),
        atol=0.03,
    )
    # six deviations
    assert mixture.mass_std == pytest.approx(draws[:, 0].std(), rel=0.01)


def test_levels_that_are_none_are_refused():
    with pytest.raises(InputError, match="between 0 and 1"):
        random_mixture(1).intervals(1.0)


# projection


@pytest.mark.parametrize("seed", range(6))
def test_the_projection_is_that_of_non_negative_least_squares(seed):
    from scipy.optimize import nnls

    rng, prior = np.random.default_rng(seed), Prior.of(shape())
    masses = rng.exponential(size=shape().n) * (rng.random(shape().n) < 0.3)
    phi = prior.cells @ masses * (1.0 + 0.05 * rng.normal(size=10))
    scale = np.abs(phi) * 10.0 ** rng.uniform(-3, -1, 10)
    root = (
        scale[:, None]
        * np.linalg.qr(rng.normal(size=(10, 10)))[0]
        * rng.uniform(0.3, 1.0, 10)
    )
    found, distance, _ = projected(
        phi, root @ root.T, prior.cells, prior.shares, float(phi[0])
    )
    W = np.linalg.inv(root)
    _, least = nnls(W @ prior.cells, W @ phi, maxiter=10_000)
    assert (found >= 0.0).all()
    off = W @ (prior.cells @ found - phi)
    # the evenness counts for a ten thousandth
    assert float(off @ off) <= least**2 * (1.0 + 1e-3) + 0.05
    assert distance == pytest.approx(float(off @ off), rel=2e-3, abs=1e-5)


def test_parameters_far_from_every_body_are_projected_by_newtons_method(monkeypatch):
    """Which the most even masses are found by; its way from zero would fail in four of
    these forty."""

    def not_needed(*_):
        raise AssertionError("Newton's method did not converge")

    monkeypatch.setattr(projection, "_nearest", not_needed)
    rng, prior = np.random.default_rng(5), Prior.of(shape())
    mixture = prior_mixture(prior, 0.7, False)
    F = np.linalg.cholesky(mixture.covariance)
    for _ in range(40):
        turn = np.linalg.qr(rng.normal(size=(10, 10)))[0]
        root = F @ turn * 10.0 ** rng.uniform(-1.0, 0.0, 10)
        phi = mixture.mean + 10.0 * root @ rng.normal(size=10)
        covariance = root @ root.T
        projection.projected(phi, covariance, prior.cells, prior.shares, 0.7)


def test_where_newtons_method_fails_the_distance_is_still_that_of_the_covariance(
    monkeypatch,
):
    monkeypatch.setattr(projection, "_from_dual", lambda *_: None)
    rng, prior = np.random.default_rng(8), Prior.of(shape())
    mixture = prior_mixture(prior, 0.7, False)
    F = np.linalg.cholesky(mixture.covariance)
    phi = mixture.mean + 3.0 * F @ rng.normal(size=10)
    found = projection.projected(
        phi, mixture.covariance, prior.cells, prior.shares, 0.7
    )
    assert found.dual is None
    off = np.linalg.solve(F, prior.cells @ found.masses - phi)
    # the metric is kept invertible by 1e-14 of it
    assert found.distance == pytest.approx(float(off @ off), rel=1e-4)


def test_a_projection_that_begins_with_that_of_a_like_body_is_the_same():
    """Also where it begins with that of a body that has nothing to do with it."""
    rng, prior = np.random.default_rng(6), Prior.of(shape())
    mixture = prior_mixture(prior, 0.7, False)
    C = 0.01 * mixture.covariance
    F = np.linalg.cholesky(C)
    points = (prior.cells, prior.shares)
    for far in (0.1, 1.0, 10.0, 1000.0):
        phi = mixture.mean + far * F @ rng.normal(size=10)
        near = phi + 0.1 * F @ rng.normal(size=10)
        other = mixture.mean - 10.0 * F @ rng.normal(size=10)
        whole = projected(phi, C, *points, 0.7)
        for begin in (near, other):
            dual = projected(begin, C, *points, 0.8).dual
            found = projected(phi, C, *points, 0.7, dual)
            # as near as the search for it goes on: 1e-6 deviations, and 1e-5 of how
            # many the body is away
            tolerance = 1e-5 * (1.0 + whole.distance**0.5)
            off = np.linalg.solve(F, prior.cells @ (found.masses - whole.masses))
            assert np.abs(off).max() < tolerance
            assert found.distance == pytest.approx(whole.distance, rel=1e-4, abs=1e-8)


def test_a_projection_takes_fewer_steps_from_that_of_a_like_body(monkeypatch):
    steps = counted_lengths(monkeypatch)
    rng, prior = np.random.default_rng(7), Prior.of(shape())
    masses = rng.exponential(size=shape().n) * (rng.random(shape().n) < 0.3)
    phi = prior.cells @ masses
    C = np.diag((0.01 * phi) ** 2)
    dual = projected(phi, C, prior.cells, prior.shares, phi[0]).dual
    alone, steps[0] = steps[0], 0
    phi = phi * (1.0 + 1e-4 * rng.normal(size=10))
    projected(phi, C, prior.cells, prior.shares, phi[0], dual)
    assert steps[0] < 0.5 * alone


@pytest.mark.parametrize("seed", range(8))
def test_the_projection_is_the_most_even_of_its_parameters(seed):
    """By its optimality: what the masses are more or less than even is linear in each
    point's parameters, and where that would leave less than nothing there is
    nothing."""
    rng, prior = np.random.default_rng(seed), Prior.of(shape())
    masses = prior.shares * rng.exponential(size=shape().n) ** (1 + seed % 4)
    phi = prior.cells @ (masses * (rng.random(shape().n) < (1.0, 0.5, 0.3)[seed % 3]))
    root = np.diag(1e-3 * np.abs(phi)) @ np.linalg.qr(rng.normal(size=(10, 10)))[0]
    found, _, _ = projected(
        phi, root @ root.T, prior.cells, prior.shares, float(phi[0])
    )
    more, held = found / (phi[0] * prior.shares) - 1.0, found > 0.0
    M = (prior.cells / np.abs(phi)[:, None]).T
    z = np.linalg.lstsq(M[held], more[held], rcond=None)[0]
    # as near as the search for it goes on
    np.testing.assert_allclose(M[held] @ z, more[held], atol=1e-6)
    assert (M[~held] @ z <= -1.0 + 1e-6).all()


def test_the_projection_of_the_even_body_is_even():
    prior = Prior.of(shape())
    phi = 2.0 * prior.mean
    std = 1e-3 * np.repeat(
        (2.0, np.abs(phi[1:4]).max(), np.abs(phi[4:]).max()), (1, 3, 6)
    )
    found, distance, _ = projected(phi, np.diag(std**2), prior.cells, prior.shares, 2.0)
    np.testing.assert_allclose(found, 2.0 * prior.shares, rtol=1e-6)
    assert distance < 1e-9


def test_the_projection_leaves_out_what_is_certain_to_be_nothing():
    """Points in a plane: what they have no part in is known without error, and asks
    nothing of them."""
    rng = np.random.default_rng(0)
    points = np.column_stack((rng.uniform(-0.1, 0.2, (30, 2)), np.zeros(30)))
    cells = np.column_stack(
        [InertialParameters.from_points(p[None], [1.0]).vector for p in points]
    )
    phi = cells @ rng.exponential(size=30)
    std = 0.01 * np.abs(phi)  # zero for mc_z, Jxz and Jyz
    assert (std == 0.0).sum() == 3
    found, distance, _ = projected(
        phi, np.diag(std**2), cells, np.full(30, 1.0 / 30.0), float(phi[0])
    )
    np.testing.assert_allclose(cells @ found, phi, atol=1e-4 * np.abs(phi).max())
    assert distance < 1e-4


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


def test_normal_probabilities_and_quantiles_are_scipys():
    from scipy.special import ndtr, ndtri

    from hefting.estimators.bayes.mixture import normal_cdf, normal_quantile

    t = np.linspace(-8.0, 8.0, 1001)
    # as published
    np.testing.assert_allclose(
        normal_cdf(t, np.exp(-0.5 * t * t)), ndtr(t), atol=7.6e-8
    )
    for p in (1e-6, 0.025, 0.5, 0.7, 0.975, 1 - 1e-6):
        assert normal_quantile(p) == pytest.approx(ndtri(p), abs=1e-9)


@pytest.mark.parametrize("level", [0.1, 0.5, 0.95, 1.0 - 1e-5])
def test_ends_of_mixtures_whose_members_are_not_alike(level):
    """Tails have their probability to a thousandth of it, also where a member of hardly
    any weight is 10,000 times as wide as the others."""
    from scipy.special import ndtr

    from hefting.estimators.bayes.mixture import mixture_ends

    rng = np.random.default_rng(2)
    means, stds = rng.normal(size=(20, 8)), rng.uniform(0.1, 3.0, (20, 8))
    means[0, 4:], stds[0, 4:] = 500.0, 1e4
    weights = rng.uniform(size=20)
    weights[0] = 1e-6
    weights /= weights.sum()
    tail = 0.5 - 0.5 * level
    low, high = mixture_ends(means, stds, weights, tail)
    below = weights @ ndtr((low - means) / stds)
    above = weights @ ndtr((means - high) / stds)
    # the probability of a normal number is known to 7.5e-8
    np.testing.assert_allclose((below, above), tail, rtol=1e-3, atol=1e-7)


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

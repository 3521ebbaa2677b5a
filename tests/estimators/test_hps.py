"""HPS: against non-negative least squares on every near-static sample."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import nnls

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.core.regressor import reduced_regressor
from hefting.estimators import HPS, hps
from hefting.shapes import Shape
from random_problems import random_body, random_motion, with_wrench

NOISE = Noise(force=0.1, torque=0.005)
COVARIANCE = np.diag((0.01, 0.02, 0.03, 3e-5, 2e-5, 1e-5)) + 1e-6
BIAS = np.array((1.0, -2.0, 3.0, 0.1, -0.2, 0.3))


def parts(
    rng: np.random.Generator, count: int = 4, n: int = 80, reach: float = 0.1
) -> Shape:
    """A cloud of `n` points in `count` clusters, in random order, with labels of any
    value."""
    label = rng.permutation(np.arange(n) % count)
    centers = reach * rng.normal(size=(count, 3))
    names = rng.choice(np.arange(-50, 50), size=count, replace=False)
    positions = centers[label] + 0.2 * reach * rng.normal(size=(n, 3))
    return Shape(positions, volumes=rng.exponential(size=n), labels=names[label])


def masses_of(shape: Shape, part_masses: np.ndarray) -> np.ndarray:
    """Masses (n,) of the points when the parts, in the order of their labels, have
    `part_masses`."""
    volumes = np.ones(shape.n) if shape.volumes is None else shape.volumes
    masses = np.zeros(shape.n)
    for label, mass in zip(np.unique(shape.labels), part_masses, strict=True):
        masses[shape.labels == label] = (
            mass * volumes[shape.labels == label] / volumes[shape.labels == label].sum()
        )
    return masses


def stop_and_go(
    rng: np.random.Generator, shape: Shape, bias: np.ndarray | float = 0.0, K: int = 150
):
    """K noisy samples, one in three of them moving, of a body whose parts are
    homogeneous: the samples, its points."""
    masses = masses_of(shape, rng.exponential(size=len(np.unique(shape.labels))))
    motion = random_motion(rng, K, speed=0.2)
    fast = np.where(np.arange(K) % 3 == 0, 30.0, 1.0)[:, None]
    motion = replace(
        motion,
        linear_acceleration=motion.linear_acceleration * fast,
        angular_acceleration=motion.angular_acceleration * fast,
    )
    z = with_wrench(
        motion,
        InertialParameters.from_points(shape.positions, masses),
        bias,
        rng,
        0.1,
        0.005,
    )
    return z, masses


# the oracle: all near-static rows


def oracle(
    z: Measurements,
    shape: Shape,
    free_bias: bool = False,
    S: np.ndarray | None = None,
    limits=(1.0, 1.0),
):
    """Masses (parts,) and sum of squares of non-negative least squares on the raw rows,
    a bias as two unknowns >= 0."""
    a = np.linalg.norm(z.linear_acceleration, axis=1)
    alpha = np.linalg.norm(z.angular_acceleration, axis=1)
    z = z[(a < limits[0]) & (alpha < limits[1])]
    labels = np.unique(shape.labels)
    columns = [masses_of(shape, np.eye(len(labels))[i]) for i in range(len(labels))]
    M = np.column_stack(
        [InertialParameters.from_points(shape.positions, m).vector for m in columns]
    )
    A = reduced_regressor(replace(z, weights=None)) @ M
    weight = np.ones(len(z)) if z.weights is None else np.sqrt(z.weights)
    if free_bias:
        unit = np.broadcast_to(np.eye(6), (len(z), 6, 6))
        A = np.concatenate((A, unit, -unit), axis=2)
    W = np.eye(6) if S is None else np.linalg.inv(np.linalg.cholesky(S))
    A = weight[:, None, None] * (W @ A)
    b = weight[:, None] * (z.wrench @ W.T)
    solution, norm = nnls(A.reshape(-1, A.shape[2]), b.ravel(), maxiter=1000)
    count = len(labels)
    bias = solution[count : count + 6] - solution[count + 6 :] if free_bias else None
    return solution[:count], norm**2, bias, len(z)


def part_masses(found, shape: Shape) -> np.ndarray:
    return np.array(
        [
            found.point_masses[shape.labels == label].sum()
            for label in np.unique(shape.labels)
        ]
    )


def assert_agrees(found, z, shape, free_bias=False, S=None, limits=(1.0, 1.0)):
    expected, square, bias, samples = oracle(z, shape, free_bias, S, limits)
    assert found.samples == samples
    # double precision times the conditioning of parts as far apart as they are large,
    # far below
    np.testing.assert_allclose(
        part_masses(found, shape), expected, atol=1e-8 * expected.sum()
    )
    assert found.certificate.objective == pytest.approx(square, rel=1e-8)
    if free_bias:
        np.testing.assert_allclose(found.bias, bias, atol=1e-8 * np.abs(bias).max())
    else:
        assert found.bias is None
    assert_lawful(found, shape)


def assert_lawful(found, shape: Shape):
    """What holds of every estimate: a body, its points, a bound close below."""
    masses = found.point_masses
    assert found.physically_consistent
    assert masses.shape == (shape.n,)
    assert (masses >= 0.0).all()
    assert masses.sum() == pytest.approx(found.parameters.mass, rel=1e-12)
    body = InertialParameters.from_points(shape.positions, masses)
    np.testing.assert_allclose(
        body.vector, found.parameters.vector, atol=1e-12 * np.abs(body.vector).max()
    )
    np.testing.assert_allclose(
        masses_of(shape, part_masses(found, shape)), masses, atol=1e-12 * masses.sum()
    )
    assert 0.0 <= found.certificate.bound <= found.certificate.objective * (1.0 + 1e-12)
    # of rounding alone
    assert found.certificate.gap <= 1e-8 * found.certificate.objective


@pytest.mark.parametrize("bias", ["none", "estimate"])
@pytest.mark.parametrize(
    "noise", [None, NOISE, COVARIANCE], ids=["plain", "levels", "covariance"]
)
@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_equals_non_negative_least_squares_on_every_static_sample(bias, noise, count):
    S = (
        np.diag(np.repeat((NOISE.force**2, NOISE.torque**2), 3))
        if noise is NOISE
        else noise
    )
    at_zero = 0
    for seed in range(6):
        rng = np.random.default_rng([1, seed])
        shape = parts(rng, count)
        z, _ = stop_and_go(rng, shape, BIAS if bias == "estimate" else 0.0)
        # a body that is not what the parts say, one of them missing: some masses end at
        # zero
        if seed % 2:
            masses = rng.exponential(size=shape.n) ** 3 * (
                shape.labels != shape.labels[0] if count > 1 else 1.0
            )
            body = InertialParameters.from_points(
                shape.positions, masses / masses.sum()
            )
            z = with_wrench(
                z, body, BIAS if bias == "estimate" else 0.0, rng, 0.1, 0.005
            )
        if seed == 2:
            z = replace(z, weights=rng.uniform(size=len(z)))
        found = HPS(shape, bias, noise).fit(z)
        assert_agrees(found, z, shape, bias == "estimate", S)
        assert found.warnings == ()
        at_zero += int((part_masses(found, shape) == 0.0).sum())
    assert count < 4 or at_zero > 0


def test_streaming_merging_and_batch_agree():
    rng = np.random.default_rng(2)
    shape = parts(rng)
    z, _ = stop_and_go(rng, shape, BIAS)
    estimator = HPS(shape, "estimate", NOISE)
    batch = estimator.fit(z)
    single = estimator.start()
    for k in range(len(z)):
        single = estimator.update(single, z[k : k + 1])
    halves = [estimator.update(estimator.start(), z[i::2]) for i in (0, 1)]
    both = [estimator.merge(*p, one_bias=True) for p in (halves, halves[::-1])]
    for state in (single, *both):
        found = estimator.estimate(state)
        # rounding, far below a standard deviation
        np.testing.assert_allclose(
            found.point_masses, batch.point_masses, atol=1e-8 * batch.parameters.mass
        )
        np.testing.assert_allclose(found.bias, batch.bias, atol=1e-9)
        assert (found.samples, found.duration) == (batch.samples, batch.duration)


def test_without_noise_the_parts_have_their_masses():
    """A static pose is a pose at rest; the model knows nothing of what little moves."""
    for mass in (1e-3, 1.0, 50.0):
        rng = np.random.default_rng(3)
        shape = parts(rng)
        masses = masses_of(shape, mass * np.array((0.1, 0.2, 0.3, 0.4)))
        body = InertialParameters.from_points(shape.positions, masses)
        for bias, value in (("none", 0.0), ("estimate", BIAS)):
            found = HPS(shape, bias).fit(
                with_wrench(random_motion(rng, 20, speed=0.0), body, value)
            )
            # conditioning of the parts, about a thousand, times rounding of the wrench,
            # the bias included
            np.testing.assert_allclose(
                found.point_masses, masses, atol=1e-11 * (mass + np.abs(value).max())
            )
            np.testing.assert_allclose(
                found.parameters.vector,
                body.vector,
                atol=1e-11 * (mass + np.abs(value).max()),
            )


# which samples


def test_only_near_static_samples_count():
    rng = np.random.default_rng(4)
    shape = parts(rng)
    z, _ = stop_and_go(rng, shape)
    found = HPS(shape).fit(z)
    a = np.linalg.norm(z.linear_acceleration, axis=1)
    alpha = np.linalg.norm(z.angular_acceleration, axis=1)
    still = (a < 1.0) & (alpha < 1.0)
    assert 80 <= still.sum() == found.samples <= 100  # two in three
    ruined = replace(
        z,
        force=np.where(still[:, None], z.force, 1e3),
        torque=np.where(still[:, None], z.torque, 1e3),
    )
    np.testing.assert_array_equal(
        HPS(shape).fit(ruined).parameters.vector, found.parameters.vector
    )
    assert_agrees(HPS(shape, max_acceleration=0.3).fit(z), z, shape, limits=(0.3, 1.0))
    assert_agrees(
        HPS(shape, max_angular_acceleration=0.3).fit(z), z, shape, limits=(1.0, 0.3)
    )
    assert HPS(shape, max_acceleration=np.inf, max_angular_acceleration=np.inf).fit(
        z
    ).samples == len(z)


def test_no_static_samples():
    rng = np.random.default_rng(5)
    shape = parts(rng)
    moving = with_wrench(random_motion(rng, 50, speed=10.0), random_body(rng))
    fast = np.linalg.norm(moving.linear_acceleration, axis=1) >= 1.0
    with pytest.raises(NotIdentifiableError, match="near-static"):
        HPS(shape).fit(moving[fast])
    with pytest.raises(NotIdentifiableError, match="near-static"):
        HPS(shape).estimate(HPS(shape).start())


# what the parts may be


def test_labels_are_but_names():
    """In any order, of any value; of the same points in another order the estimate is
    the same."""
    rng = np.random.default_rng(6)
    shape = parts(rng)
    z, _ = stop_and_go(rng, shape)
    expected = HPS(shape).fit(z).point_masses
    index = np.unique(shape.labels, return_inverse=True)[1]
    for names in ((3, 2, 1, 0), (-7, 10**9, 0, 5), (1, 2, 4, 8)):
        renamed = replace(shape, labels=np.array(names)[index])
        np.testing.assert_allclose(
            HPS(renamed).fit(z).point_masses, expected, atol=1e-10 * expected.sum()
        )
    order = rng.permutation(shape.n)
    shuffled = Shape(shape.positions[order], shape.volumes[order], shape.labels[order])
    np.testing.assert_allclose(
        HPS(shuffled).fit(z).point_masses, expected[order], atol=1e-10 * expected.sum()
    )


def test_without_volumes_all_points_weigh_the_same():
    rng = np.random.default_rng(7)
    shape = parts(rng)
    bare = Shape(shape.positions, labels=shape.labels)
    z, _ = stop_and_go(rng, bare)
    found = HPS(bare).fit(z)
    assert_agrees(found, z, bare)
    for label in np.unique(bare.labels):
        masses = found.point_masses[bare.labels == label]
        np.testing.assert_allclose(masses, masses.mean(), rtol=1e-12)
    equal = Shape(shape.positions, np.full(shape.n, 7.0), shape.labels)
    np.testing.assert_allclose(
        HPS(equal).fit(z).point_masses, found.point_masses, rtol=1e-9
    )


def test_a_part_without_volume_has_no_mass():
    rng = np.random.default_rng(8)
    shape = parts(rng)
    z, _ = stop_and_go(rng, shape)
    empty = shape.labels == shape.labels[0]
    hollow = Shape(shape.positions, np.where(empty, 0.0, shape.volumes), shape.labels)
    found = HPS(hollow).fit(z)
    rest = Shape(shape.positions[~empty], shape.volumes[~empty], shape.labels[~empty])
    np.testing.assert_array_equal(found.point_masses[empty], 0.0)
    np.testing.assert_allclose(
        found.point_masses[~empty], HPS(rest).fit(z).point_masses, rtol=1e-9
    )
    assert found.warnings == ()  # three parts are left


@pytest.mark.parametrize(
    ("count", "bias"), [(5, "none"), (9, "estimate"), (40, "none")]
)
def test_more_than_four_parts(count, bias):
    """Gravity tells four numbers: the masses are not unique, but what they explain
    is."""
    for seed in range(5):
        rng = np.random.default_rng([9, seed])
        shape = parts(rng, count)
        z, _ = stop_and_go(rng, shape, BIAS if bias == "estimate" else 0.0)
        found = HPS(shape, bias).fit(z)
        assert found.warnings == (
            f"gravity does not tell the masses of {count} parts apart, only of 4",
        )
        expected, square, *_ = oracle(z, shape, bias == "estimate")
        assert found.certificate.objective == pytest.approx(square, rel=1e-8)
        body = InertialParameters.from_points(
            shape.positions, masses_of(shape, expected)
        )
        np.testing.assert_allclose(
            found.parameters.vector[:4], body.vector[:4], atol=1e-8 * body.mass
        )
        assert_lawful(found, shape)


def test_parts_in_line_are_told_apart_no_better():
    """The centroids of three parts in one line: mass and one moment for three
    masses."""
    rng = np.random.default_rng(10)
    positions = np.array(((0.1, 0.0, 0.0), (0.1, 0.1, 0.0), (0.1, 0.3, 0.0)))
    shape = Shape(positions, labels=np.arange(3))
    z = with_wrench(
        random_motion(rng, 30, speed=0.0),
        InertialParameters.from_points(positions, (0.2, 0.3, 0.1)),
    )
    found = HPS(shape).fit(z)
    assert found.warnings == (
        "gravity does not tell the masses of 3 parts apart, only of 2",
    )
    assert found.parameters.mass == pytest.approx(0.6, rel=1e-10)
    np.testing.assert_allclose(
        found.parameters.center_of_mass, (0.1, 0.1, 0.0), atol=1e-10
    )


# what no masses explain


def test_one_orientation_beside_a_bias():
    rng = np.random.default_rng(11)
    shape = parts(rng)
    one = random_motion(rng, 1, speed=0.0)[np.zeros(30, dtype=int)]
    z = with_wrench(one, random_body(rng), BIAS, rng, 0.1, 0.005)
    with pytest.raises(NotIdentifiableError, match="from a bias"):
        HPS(shape, "estimate").fit(z)
    found = HPS(shape).fit(z)
    assert found.warnings == (
        "gravity does not tell the masses of 4 parts apart, only of 3",
    )


def test_a_wrench_that_lifts():
    """With its sign wrong no mass is best, and that is no body."""
    rng = np.random.default_rng(12)
    shape = parts(rng)
    z, _ = stop_and_go(rng, shape)
    with pytest.raises(NotIdentifiableError, match="sign"):
        HPS(shape).fit(replace(z, force=-z.force, torque=-z.torque))


@pytest.mark.parametrize("seed", range(40))
def test_every_estimate_is_a_body(seed):
    """Few and many samples and parts, noise-free or not, single points, parts that are
    not homogeneous."""
    rng = np.random.default_rng([13, seed])
    count = int(rng.choice([1, 2, 4, 8]))
    shape = parts(
        rng, count, count * int(rng.choice([1, 10])), reach=10 ** rng.uniform(-2.5, 0.0)
    )
    masses = 10 ** rng.uniform(-1.0, 1.7) * rng.dirichlet(np.full(shape.n, 0.3))
    body = InertialParameters.from_points(shape.positions, masses)
    level = float(rng.choice([0.0, 0.01]))
    motion = random_motion(rng, int(rng.choice([2, 5, 40])), speed=0.1)
    z = with_wrench(motion, body, 0.0, rng, level, 0.05 * level)
    found = HPS(shape, noise=NOISE if seed % 2 else None).fit(z)
    masses = found.point_masses
    assert found.physically_consistent
    assert (masses >= 0.0).all()
    assert masses.sum() == pytest.approx(found.parameters.mass, rel=1e-12)
    size = float(np.sum(z.wrench**2)) * (NOISE.torque**-2 if seed % 2 else 1.0)
    assert found.certificate.bound <= found.certificate.objective + 1e-15 * size
    # of rounding
    assert found.certificate.gap <= 1e-8 * found.certificate.objective + 1e-12 * size


# input


def test_hyperparameters_are_checked():
    shape = parts(np.random.default_rng(14))
    with pytest.raises(InputError, match="labelled parts"):
        HPS(Shape(shape.positions))
    with pytest.raises(InputError, match="must be a Shape"):
        HPS(shape.positions)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="bias model"):
        HPS(shape, bias="some")  # type: ignore[arg-type]
    for noise in (Noise(), Noise(0.1, 0.0), np.zeros((6, 6)), np.eye(3)):
        with pytest.raises(InputError, match="noise"):
            HPS(shape, noise=noise)
    for limit in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="max_acceleration"):
            HPS(shape, max_acceleration=limit)
        with pytest.raises(InputError, match="max_angular_acceleration"):
            HPS(shape, max_angular_acceleration=limit)


def test_the_bound_holds_for_wrong_masses():
    """Random problems, masses with parts missing and five times too light: the optimum
    is never below the bound."""
    positive = 0
    for seed in range(200):
        rng = np.random.default_rng([15, seed])
        G, g = rng.normal(size=(11, 4)), rng.normal(size=11)
        best, norm = nnls(G, g)
        wrong = np.where(best == best.max(), best, 0.0) * 0.2
        # beyond the bound's reach
        if np.count_nonzero(best) < 2 or best.sum() > 10 * wrong.sum():
            continue
        bound = hps._bound(G, g, wrong)
        assert bound <= norm**2 * (1 + 1e-12)
        positive += bound > 0.0
    assert positive > 50


@pytest.mark.parametrize(("one", "two"), [(1.0, 2.0), (0.0, 3.0)])
def test_the_bound_holds_for_bodies_ten_times_as_heavy(one, two):
    """Of a third part that would explain what is left a thousandth at a time: half of
    the residual's gradient, for as much of it as ten times all others."""
    G = np.diag((1.0, 1.0, 1e-3))
    left = 1.0
    bound = hps._bound(G, np.array((one, two, left)), np.array((one, two, 0.0)))
    assert bound == pytest.approx(left**2 - 2.0 * 10.0 * (one + two) * left * 1e-3)
    m = np.linspace(0.0, 10.0 * (one + two), 50)
    assert bound <= np.min((left - 1e-3 * m) ** 2)
    exact = hps._bound(G, np.array((one, two, -1.0)), np.array((one, two, 0.0)))
    assert exact == pytest.approx(1.0)
    assert hps._bound(G, np.array((one, two, 0.0)), np.array((one, two, 0.0))) == 0.0

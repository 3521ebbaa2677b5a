"""Several recordings of one object, each with a wrench bias of its own: every method
finds what it finds on the same problem built densely, from all samples at once."""

from dataclasses import replace
from functools import reduce

import numpy as np
import pytest
from scipy.linalg import block_diag

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.measurements import Measurements, Noise
from hefting.core.moments import Moments
from hefting.core.regressor import (
    features,
    full_regressor,
    full_rows,
    reduced_regressor,
)
from hefting.estimators import METHODS, OLS, VARIANTS, method_named, pmd
from hefting.estimators.base import Estimator
from hefting.estimators.bayes import noise as bayes_noise
from hefting.estimators.bayes.groups import Groups
from hefting.estimators.bayes.samples import NOISE_FLOOR_SHARE, Samples
from hefting.estimators.bayes.time_samples import TimeSamples
from hefting.estimators.joint_state import JointState, join
from hefting.estimators.pmd import PMD
from hefting.estimators.quadratic import Quadratic, whitening
from hefting.estimators.sample_state import SampleState
from hefting.shapes import Shape
from random_problems import random_body, random_motion, with_wrench

LENGTHS = (128, 256, 128, 64, 128, 256, 64, 128, 128, 64)
"""Samples of each recording: powers of two, so that the Haar transform of the oracle
needs no rule for what is left over."""
LEVELS = Noise(0.1, 0.005)
EQUAL = 1e-9
"""Of the parameters, over those of a body of this mass and size, and of the ends of
intervals over their width: rounding, 5e-13 seen."""


@pytest.fixture(scope="module")
def body():
    return random_body(np.random.default_rng([16, 1]), 1.347)


@pytest.fixture(scope="module")
def shape(body):
    """Points about the body in three labelled parts."""
    points = body.center_of_mass + np.random.default_rng([16, 2]).uniform(
        -0.15, 0.15, (60, 3)
    )
    return Shape(
        points, labels=np.digitize(points[:, 0], np.quantile(points[:, 0], (0.3, 0.7)))
    )


@pytest.fixture(scope="module")
def biases():
    """Forces of +20 or -20 N on each axis, torques of 2 N m."""
    rng = np.random.default_rng([16, 3])
    return rng.choice((-1.0, 1.0), (10, 6)) * np.repeat((20.0, 2.0), 3)


@pytest.fixture(scope="module")
def recordings(body, biases):
    return [_recording(body, bias, i) for i, bias in enumerate(biases)]


def _recording(body, bias, i, speed=0.7) -> Measurements:
    rng = np.random.default_rng([16, 4, i])
    motion = random_motion(rng, LENGTHS[i], speed)
    z = with_wrench(motion, body, bias, rng, LEVELS.force, LEVELS.torque)
    return replace(z, weights=rng.uniform(0.5, 1.5, len(z)))


def _merged(estimator: Estimator, recordings):
    states = [estimator.update(estimator.start(), z) for z in recordings]
    return reduce(estimator.merge, states)


def _estimator(name: str, shape: Shape, **settings) -> Estimator:
    kind, own = method_named(name)
    known = {"bias": "estimate"} | own | settings
    if "shape" in kind.hyperparameters():
        known["shape"] = shape
    known |= {key: shape for key, value in own.items() if value == "shape"}
    if "c1" in kind.hyperparameters(known.get("model")):
        known["c1"] = 10.0
    return kind(**known)


# the oracle: all samples, dense


def _dense(estimator: Estimator, z: Measurements):
    """Regressor rows (12 K, 10), wrench (12 K,) and bias columns (12 K, 6) of both
    models, as the method weighs them."""
    w = np.broadcast_to(estimator.weight(z), len(z))
    if estimator.name == "HPS":
        slow = (
            np.linalg.norm(z.linear_acceleration, axis=1) < estimator.max_acceleration
        )
        slow &= (
            np.linalg.norm(z.angular_acceleration, axis=1)
            < estimator.max_angular_acceleration
        )
        return _stack(z, 1.0 * slow, 0.0 * w)
    return _stack(z, 1.0 - w, w)


def _stack(z: Measurements, *shares):
    """The same; `shares` (K,) are those of the reduced and the full model."""
    parts = []
    regressors = (reduced_regressor(z), full_regressor(z))
    root = np.sqrt(z.weights)[:, None, None]
    b = z.wrench[:, :, None] * root
    ones = np.broadcast_to(np.eye(6), (len(z), 6, 6)) * root
    for share, A in zip(shares, regressors, strict=True):
        s = share[:, None, None]
        parts.append((s * A, s * b, s * ones))  # the regressors hold the root already
    return parts


def _dense_quadratic(estimator, recordings):
    """What takes the place of `Quadratic.of`: biases out by orthogonal projection of
    all samples of a recording at once."""

    def of(state, noise=None, free_bias=False):
        assert free_bias
        W = whitening(noise)
        W = np.eye(6) if W is None else W
        A, b, C = ([], [], [])
        for z in recordings:
            each = _dense(estimator, z)
            A.append(
                np.concatenate([(W @ rows).reshape(-1, 10) for rows, _, _ in each])
            )
            b.append(np.concatenate([(W @ own).reshape(-1) for _, own, _ in each]))
            C.append(np.concatenate([(W @ one).reshape(-1, 6) for _, _, one in each]))
        whole = []
        for rows, own, one in zip(A, b, C, strict=True):
            basis, rows = np.linalg.qr(one)[0], np.column_stack((rows, own))
            whole.append(rows - basis @ (basis.T @ rows))
        R = np.linalg.qr(np.concatenate(whole), mode="r")
        return Quadratic(R[:, :10], R[:, 10], np.zeros((0, 6, 17)))

    return of


def _dense_rows(estimator, recordings):
    """What takes the place of the rows of PMD."""

    def of(state, free_bias):
        assert free_bias
        coupled, shares, reduced, full, size = [], [], [], [], 0.0
        for z in recordings:
            (A0, b0, C0), (A1, b1, C1) = _dense(estimator, z)
            o0, o1 = C0[:, 0, 0], C1[:, 0, 0]
            c0, c1 = np.linalg.norm(o0), np.linalg.norm(o1)
            rows0, rows1 = np.dstack((A0, b0)), np.dstack((A1, b1))
            size = np.hypot(size, np.sqrt((b0**2).sum() + (b1**2).sum()))
            mean0 = np.tensordot(o0, rows0, 1) / (c0 or 1.0)
            mean1 = np.tensordot(o1, rows1, 1) / (c1 or 1.0)
            c = np.hypot(c0, c1)
            u0, u1 = (o / (np.linalg.norm(o) or 1.0) for o in (o0, o1))
            coupled.append(c1 / c * mean0 - c0 / c * mean1)
            shares += [((c1 / c) ** 2, (c0 / c) ** 2)] * 6
            reduced.append(rows0 - u0[:, None, None] * mean0)
            full.append(rows1 - u1[:, None, None] * mean1)
        R0 = np.linalg.qr(np.concatenate(reduced).reshape(-1, 11), mode="r")
        R1 = np.linalg.qr(np.concatenate(full).reshape(-1, 11), mode="r")
        rows = np.concatenate((*coupled, R0, R1))
        K = np.array([*shares, *[(1.0, 0.0)] * len(R0), *[(0.0, 1.0)] * len(R1)]).T
        return rows[:, :10], rows[:, 10], K, float(size)

    return of


def _dense_samples(recordings):
    """What takes the place of `Samples.of`."""

    def of(state, free_bias):
        assert free_bias
        rows = [features(z) for z in recordings]
        ones = [x[:, 21] for x in rows]
        each = np.array([o @ o for o in ones])
        means = np.array([o @ x / k for o, x, k in zip(ones, rows, each, strict=True)])
        X = np.concatenate(
            [x - o[:, None] * m for x, o, m in zip(rows, ones, means, strict=True)]
        )
        wrench = np.concatenate(rows)[:, 15:21]
        sizes = np.sqrt((wrench**2).reshape(-1, 2, 3).sum(axis=(0, 2)) / 3 / each.sum())
        return Samples(
            full_rows(X),
            X[:, 15:21],
            each.sum() - len(rows),
            X[:, :3],
            NOISE_FLOOR_SHARE * np.repeat(np.maximum(sizes, 1e-3 * sizes.max()), 3),
            full_rows(means),
            means[:, 15:21],
            each / each.sum(),
            sum(np.ptp(z.time) for z in recordings) / (sum(map(len, rows)) - 1),
        )

    return of


def _dense_time(recordings):
    """What takes the place of `TimeSamples.of`: Haar details of each recording, and
    its stretches of 64 samples."""

    def of(state, free_bias):
        assert free_bias
        levels: list[list] = [[] for _ in range(8)]
        stretches = []
        for z in recordings:
            x = features(z)
            for part in x.reshape(-1, 64, 22):
                stretches.append(part - np.outer(part[:, 21], _mean(part)))
            x = x - np.outer(x[:, 21], _mean(x))
            for level in levels[: int(np.log2(len(x)))]:
                level.append((x[0::2] - x[1::2]) / np.sqrt(2.0))
                x = (x[0::2] + x[1::2]) / np.sqrt(2.0)
        details = [np.concatenate(level) for level in levels]
        return TimeSamples(
            Groups.of([_factor(x) for x in details], [len(x) for x in details], None),
            Groups.of([_factor(x) for x in stretches], [63] * len(stretches), None),
            float(max(map(len, recordings))),
            True,
        )

    return of


def _mean(x):
    return x[:, 21] @ x / (x[:, 21] @ x[:, 21])


def _factor(x):
    R = np.linalg.qr(x, mode="r")
    return np.concatenate((R, np.zeros((22 - len(R), 22))))


def _patch(monkeypatch, estimator, recordings):
    """The estimator on the problem built densely, whatever the state."""
    quadratic = _dense_quadratic(estimator, recordings)
    monkeypatch.setattr(Quadratic, "of", quadratic)
    monkeypatch.setattr(bayes_noise.Samples, "of", _dense_samples(recordings))
    monkeypatch.setattr(bayes_noise.TimeSamples, "of", _dense_time(recordings))
    if isinstance(estimator, PMD):
        A, b, K, size = _dense_rows(estimator, recordings)(None, True)
        own = pmd.ModelRows.of(_merged(estimator, recordings), free_bias=True)
        dense = replace(own, A=A, b=b, K=K, size=size)
        monkeypatch.setattr(pmd.ModelRows, "of", lambda *_, **__: dense)


def _off(found, expected) -> float:
    """Difference of parameters over those of the body's mass and a size of 10 cm."""
    unit = 1.347 * np.repeat((1.0, 0.1, 0.01), (1, 3, 6))
    return float(np.abs((found - expected) / unit).max())


# what must hold


WEIGHED = [n for n in (*METHODS, *VARIANTS) if not n.startswith("PMD")]
"""Methods that are tested with a scale's reading: one row more of the same equations,
which those of PMD, with two norms, have in one of them."""


@pytest.mark.parametrize(
    ("name", "mass"),
    [(n, None) for n in (*METHODS, *VARIANTS)] + [(n, "1.35kg±5g") for n in WEIGHED],
)
def test_ten_recordings_are_the_joint_problem_built_densely(
    name, mass, recordings, shape, monkeypatch
):
    estimator = _estimator(name, shape, mass=mass)
    state = _merged(estimator, recordings)
    found = estimator.estimate(state)
    _patch(monkeypatch, estimator, recordings)
    expected = estimator.estimate(state)
    assert _off(found.parameters.vector, expected.parameters.vector) < EQUAL
    for key, ends in expected.intervals.items():
        off = np.abs(found.intervals[key] - ends)
        assert (off <= EQUAL * np.ptp(ends, axis=0)).all(), key


def test_least_squares_is_that_with_sixty_columns_of_bias(recordings, body, biases):
    estimator = OLS("estimate", LEVELS, intervals=False)
    found = estimator.estimate(_merged(estimator, recordings))
    W = np.tile(1.0 / np.repeat((LEVELS.force, LEVELS.torque), 3), sum(LENGTHS))
    root = [np.sqrt(z.weights)[:, None, None] for z in recordings]
    A = np.concatenate([full_regressor(z).reshape(-1, 10) for z in recordings])
    C = block_diag(
        *[
            (r * np.broadcast_to(np.eye(6), (len(z), 6, 6))).reshape(-1, 6)
            for z, r in zip(recordings, root, strict=True)
        ]
    )
    b = [(z.wrench * r[:, 0]).ravel() for z, r in zip(recordings, root, strict=True)]
    rows = W[:, None] * np.column_stack((A, C))
    expected = np.linalg.lstsq(rows, W * np.concatenate(b))[0]
    covariance = np.linalg.inv(rows.T @ rows)
    assert _off(found.parameters.vector, expected[:10]) < EQUAL
    np.testing.assert_allclose(found.bias, expected[10:].reshape(10, 6), atol=1e-9)
    std = np.sqrt(covariance.diagonal())
    np.testing.assert_allclose(
        np.sqrt(found.covariance.diagonal()), std[:10], rtol=1e-9
    )
    # the truth: chi² of 10 and of 60 exceeds 30 and 100 once in 1,000 times
    off = found.parameters.vector - body.vector
    assert off @ np.linalg.solve(covariance[:10, :10], off) < 30.0
    assert (((found.bias - biases).ravel() / std[10:]) ** 2).sum() < 100.0
    assert found.samples == sum(LENGTHS)


def test_one_bias_for_all_would_be_another_body(body):
    """What merging did: two recordings about two orientations, zeroed in each."""
    rng = np.random.default_rng([16, 6])
    zeroed = []
    for side in (1.0, -1.0):
        motion = random_motion(rng, 200, 0.5)
        g = motion.gravity + np.array((0.0, 0.0, 20.0 * side))
        g *= 9.81 / np.linalg.norm(g, axis=1, keepdims=True)
        z = with_wrench(replace(motion, gravity=g), body, 0.0, rng, 0.1, 0.005)
        zero = z.wrench.mean(axis=0)
        zeroed.append(replace(z, force=z.force - zero[:3], torque=z.torque - zero[3:]))
    estimator = OLS("estimate")
    parts = [estimator.update(estimator.start(), z) for z in zeroed]
    silent = estimator.estimate(estimator.merge(*parts, one_bias=True))
    assert abs(silent.parameters.mass - body.mass) > 0.5 * body.mass
    found = estimator.estimate(estimator.merge(*parts))
    assert abs(found.parameters.mass - body.mass) < 3.0 * found.std["mass"]
    assert found.std["mass"] < 0.02 * body.mass


@pytest.mark.parametrize("name", [*METHODS, *VARIANTS])
def test_no_bias_of_any_recording_and_no_order_matters(name, recordings, shape):
    estimator = _estimator(name, shape)
    some = recordings[:4]
    rng = np.random.default_rng([16, 5])
    moved = [
        replace(z, force=z.force + f)
        for z, f in zip(some, 30.0 * rng.normal(size=(4, 3)), strict=True)
    ]
    states = [estimator.update(estimator.start(), z) for z in moved]
    tree = estimator.merge(
        estimator.merge(states[2], states[0]), estimator.merge(states[3], states[1])
    )
    expected = estimator.estimate(_merged(estimator, some)).parameters.vector
    # the floor of the noise, a millionth of the wrench, moves Bayes
    limit = 1e-6 if name == "Bayes" else 1e-8
    assert _off(estimator.estimate(tree).parameters.vector, expected) < limit


def test_a_recording_in_one_orientation_adds_nothing(recordings, body):
    """Its bias explains all of it, so that it determines nothing."""
    estimator = OLS("estimate", LEVELS)
    still = recordings[0]
    still = replace(
        still,
        gravity=np.tile(still.gravity[:1], (128, 1)),
        linear_acceleration=np.zeros((128, 3)),
        angular_velocity=np.zeros((128, 3)),
        angular_acceleration=np.zeros((128, 3)),
    )
    state = _merged(estimator, recordings[1:3])
    expected = estimator.estimate(state).parameters.vector
    more = estimator.merge(state, estimator.update(estimator.start(), still))
    assert _off(estimator.estimate(more).parameters.vector, expected) < EQUAL
    alone = _merged(estimator, [still, still])
    assert np.isinf(estimator.estimate(alone).covariance.diagonal()).all()
    with pytest.raises(NotIdentifiableError, match="nothing beside a bias"):
        METHODS["LMI"](bias="estimate").estimate(alone)


# what is refused


def test_moments_with_a_bias_each_do_not_merge(recordings):
    first, second = map(Moments.of, recordings[:2])
    with pytest.raises(InputError, match="a wrench bias of its own; merge `without"):
        first.merge(second)
    assert first.merge(second, one_bias=True).samples == sum(LENGTHS[:2])
    assert first.merge(Moments.empty()).samples == LENGTHS[0]
    both = first.without_bias().merge(second.without_bias())
    assert not both.ones.any()
    centred = []
    for z in recordings[:2]:
        x = features(z)
        centred.append(x - np.outer(x[:, 21], _mean(x)))
    x = np.concatenate(centred)
    np.testing.assert_allclose(
        both.factor.T @ both.factor, x.T @ x, atol=1e-12 * (x * x).sum()
    )


def test_states_with_a_bias_each_do_not_merge_into_one(recordings):
    first, second = map(SampleState.of, recordings[:2])
    with pytest.raises(InputError, match="a wrench bias of its own; use the estimator"):
        first.merge(second)
    estimator = OLS("estimate")
    joint = estimator.merge(first, second)
    assert isinstance(joint, JointState)
    assert len(joint.states) == 2
    with pytest.raises(InputError, match="has more than one bias"):
        estimator.merge(joint, first, one_bias=True)
    with pytest.raises(InputError, match="update the state of each recording"):
        estimator.update(joint, recordings[2])
    assert join(joint, SampleState.empty()).states == joint.states
    assert join(SampleState.empty(), first) is first


def test_without_a_bias_to_be_found_recordings_are_one(recordings, shape):
    """The wrench is taken at its word: merging is folding one after the other."""
    estimator = OLS("none", LEVELS)
    apart = _merged(estimator, recordings[:3])
    whole = reduce(estimator.update, recordings[:3], estimator.start())
    vectors = [estimator.estimate(state).parameters.vector for state in (apart, whole)]
    assert _off(*vectors) < EQUAL
    joint = _merged(OLS("estimate"), recordings[:3])
    assert _off(estimator.estimate(joint).parameters.vector, vectors[1]) < EQUAL


def test_recordings_have_a_bias_each_only_where_one_is_free():
    """Else they are one."""
    rng = np.random.default_rng(9)
    parts = [with_wrench(random_motion(rng, 20), random_body(rng)) for _ in range(3)]
    for bias in ("none", "estimate"):
        ols = OLS(bias=bias)
        states = [ols.update(ols.start(), z) for z in parts]
        both = ols.merge_all(states)
        assert isinstance(both, JointState) is (bias == "estimate")
        assert both.samples == 60
        assert ols.merge_all(states[:1]).samples == 20


def test_a_method_that_merges_in_its_own_way_merges_all_so():
    """Also beside free biases, where others join the states."""
    seen: list[tuple] = []

    class Own(OLS):
        def merge(self, first, second):
            seen.append((first, second))
            return super().merge(first, second)

    rng = np.random.default_rng(9)
    z = [with_wrench(random_motion(rng, 20), random_body(rng)) for _ in range(3)]
    for bias in ("none", "estimate"):
        seen.clear()
        own = Own(bias=bias)
        assert (
            own.merge_all([own.update(own.start(), part) for part in z]).samples == 60
        )
        assert len(seen) == 2

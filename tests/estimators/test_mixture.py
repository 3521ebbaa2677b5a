"""Mixture of the posterior's members: its evidence, mean, covariance and quantiles
against draws and scipy."""

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, norm

from hammers import shape
from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.estimators.bayes.likelihood import Likelihood
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.prior import Prior
from hefting.shapes import Shape
from hefting.simulation import hammer


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

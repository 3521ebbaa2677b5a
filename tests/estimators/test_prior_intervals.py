"""Intervals of a prior: what a shape says of a body before any sample."""

import numpy as np
import pytest

from hefting.estimators import LMI, OLS, PMD, Bayes
from hefting.estimators.bayes.mixture import prior_mixture
from hefting.shapes import Shape
from hefting.simulation import hammer


@pytest.fixture(scope="module")
def shape():
    return Shape.from_mesh(hammer().mesh(), points=200)


def test_they_hold_the_homogeneous_body_and_scale_with_the_mass(shape):
    bayes = Bayes(shape)
    one, two = bayes.prior_intervals(1.0), bayes.prior_intervals(2.0)
    body = shape.homogeneous
    for name in ("center_of_mass", "inertia_at_com"):
        low, high = one[name]
        value = getattr(body, name)
        assert (low <= value).all()
        assert (value <= high).all()
    assert one["mass"] == pytest.approx([1.0, 1.0])
    # Newton's method stops at 1 % of a spread
    assert two["center_of_mass"] == pytest.approx(one["center_of_mass"], abs=2e-3)
    size = np.abs(one["inertia_at_com"]).max()
    assert two["inertia_at_com"] == pytest.approx(
        2.0 * one["inertia_at_com"], abs=0.05 * size
    )


def test_they_are_the_quantiles_of_draws_from_the_prior(shape):
    """Oracle: 40,000 draws; the COM is linear in the parameters of a known mass."""
    bayes = Bayes(shape)
    draws = prior_mixture(bayes._prior, 1.5).draws(40_000)
    assert draws[:, 0] == pytest.approx(1.5)
    ends = np.quantile(draws[:, 1:4] / 1.5, (0.025, 0.975), axis=0)
    found = bayes.prior_intervals(1.5)["center_of_mass"]
    width = np.ptp(ends, axis=0)
    # of quantiles: by chance 1 %, by Newton's tolerance 1 %, by members left out 2 %
    assert (np.abs(found - ends) < 0.04 * width).all()


def test_a_better_known_pose_says_more(shape):
    sure = Bayes(shape, pose_std=(0.0, 0.0)).prior_intervals(1.0)["center_of_mass"]
    unsure = Bayes(shape, pose_std=(0.05, 0.1)).prior_intervals(1.0)["center_of_mass"]
    nothing = Bayes().prior_intervals(1.0)["center_of_mass"]
    assert (np.ptp(sure, axis=0) < np.ptp(unsure, axis=0)).all()
    assert (np.ptp(unsure, axis=0) < np.ptp(nothing, axis=0)).all()


def test_other_methods_have_none(shape):
    for estimator in (OLS(), LMI(), PMD(shape)):
        assert estimator.prior_intervals(1.0) is None

"""Accuracy: what draws of a posterior say, and what an estimate claims and keeps."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ndtri
from scipy.stats import chi, norm

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import NOISE_LEVELS
from hefting.estimators import Bayes
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.sample_state import SampleState
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, sinusoids, wield
from random_problems import random_body

NOISE = NOISE_LEVELS["moderate"]


def limits_of(accuracy: Accuracy | None) -> list[float]:
    """Of mass, COM and inertia."""
    assert accuracy is not None
    return [
        float(getattr(accuracy, name) or np.nan)
        for name in ("mass", "center_of_mass", "inertia")
    ]


# from draws


def test_draws_of_the_mass_alone():
    """With m = M (1 + s z), the error |s z| / (1 + s z) is at most q where -q / (1 + q)
    < s z < q / (1 - q).

    The same body made heavier has the same COM, and an inertia as much off as the mass.
    """
    body, s, level = hammer().parameters, 0.2, 0.95
    z = np.asarray(ndtri((np.arange(100_000) + 0.5) / 100_000), dtype=float)
    mass, com, inertia = limits_of(
        Accuracy.of_draws(np.outer(1.0 + s * z, body.vector), body, level)
    )
    exact = brentq(
        lambda q: norm.cdf(q / (1.0 - q) / s) - norm.cdf(-q / (1.0 + q) / s) - level,
        0.1,
        0.9,
    )
    # a hundred thousand draws, evenly spread
    assert mass == pytest.approx(exact, rel=1e-4)
    assert inertia == pytest.approx(exact, rel=1e-4)
    assert com < 1e-12


@pytest.mark.parametrize("level", [0.5, 0.95])
def test_draws_of_the_centre_of_mass_alone(level):
    """A distance in three dimensions; whatever the mass, and however far from the
    sensor."""
    rng, n, std = np.random.default_rng(3), 100_000, 0.004
    body = hammer().parameters
    c = body.center_of_mass + std * rng.normal(size=(n, 3))
    x, y, z = c.T
    steiner = np.stack(
        (y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y), axis=1
    )
    own = body.inertia_at_com[np.triu_indices(3)]
    draws = np.column_stack(
        (np.full(n, body.mass), body.mass * c, own + body.mass * steiner)
    )
    mass, com, inertia = limits_of(Accuracy.of_draws(draws, body, level))
    # a quantile of 100,000 draws: sqrt(level (1 - level) / n) over the density, some
    # 0.3 %; four of that
    assert com == pytest.approx(std * chi.ppf(level, 3), rel=0.012)
    assert mass < 1e-12
    assert inertia < 1e-9  # it is about the COM


@pytest.mark.parametrize("level", [0.5, 0.9, 0.95])
def test_a_claim_holds_for_as_many_draws_as_it_says(level):
    """The errors of each draw by its own tensors and COM: no fewer are within the
    claim, and hardly more."""
    rng, truth = np.random.default_rng(4), random_body(np.random.default_rng(5))
    bodies = [random_body(rng) for _ in range(200)]
    claims = limits_of(
        Accuracy.of_draws(np.array([body.vector for body in bodies]), truth, level)
    )
    J = [body.inertia_at_com for body in bodies]
    errors = (
        [abs(truth.mass - body.mass) / body.mass for body in bodies],
        [np.linalg.norm(truth.center_of_mass - body.center_of_mass) for body in bodies],
        [np.linalg.norm(truth.inertia_at_com - own) / np.linalg.norm(own) for own in J],
    )
    for claim, each in zip(claims, errors, strict=True):
        assert (np.array(each) <= claim * (1.0 + 1e-9)).mean() >= level
        assert (np.array(each) < claim * (1.0 - 1e-9)).mean() <= level


def test_draws_without_mass_leave_all_open():
    """Where 6 % have none, 95 % of no error are known; where 4 % have none, the others
    tell."""
    body = hammer().parameters
    masses = np.linspace(0.9, 1.1, 1000)
    for lost, least, most in ((60, np.inf, np.inf), (40, 0.0, 0.2)):
        negative = np.where(np.arange(1000) < lost, -1.0, masses)
        found = Accuracy.of_draws(np.outer(negative, body.vector), body, 0.95)
        assert all(least <= limit <= most for limit in limits_of(found))
        assert Accuracy(mass=1e6).met_by(found) is (lost == 40)


# a posterior's


def mixture(members: int, seed: int) -> Mixture:
    """Members whose means and spreads differ as much as they are wide."""
    rng, vector = np.random.default_rng(seed), hammer().parameters.vector
    size = 0.02 * np.abs(vector).max() * np.repeat((1.0, 0.2, 0.05), (1, 3, 6))
    means = vector + size * rng.normal(size=(members, 10))
    factors = size[:, None] * rng.normal(size=(members, 10, 10)) / 3.0
    weights = rng.random(members) ** 3
    weights[-1] = 1e-9  # and one that is as good as none
    return Mixture(weights / weights.sum(), means, factors)


@pytest.mark.parametrize(("members", "seed"), [(2, 6), (6, 7), (24, 8)])
def test_draws_have_the_moments_and_quantiles_of_the_mixture(members, seed):
    posterior, n = mixture(members, seed), 40_000
    draws = posterior.draws(n)
    assert draws.shape == (n, 10)
    scale = np.sqrt(posterior.covariance.diagonal())
    # a mean of 40,000 is known to 0.005 deviations, a variance to 0.007: five of each
    np.testing.assert_allclose(
        (draws.mean(axis=0) - posterior.mean) / scale, 0.0, atol=0.025
    )
    correlation = (np.cov(draws.T) - posterior.covariance) / np.outer(scale, scale)
    np.testing.assert_allclose(correlation, 0.0, atol=0.035)
    for level in (0.5, 0.95):
        low, high = posterior.intervals(level)["mass"]
        # shares of 40,000: at most 0.25 %; four of that
        assert (draws[:, 0] < low).mean() == pytest.approx(0.5 - level / 2.0, abs=0.01)
        assert (draws[:, 0] > high).mean() == pytest.approx(0.5 - level / 2.0, abs=0.01)


def test_draws_are_the_same_at_every_call():
    first = mixture(6, 7).draws()
    assert first.shape == (1000, 10)
    assert mixture(6, 7).draws(7).shape == (7, 10)
    np.testing.assert_array_equal(mixture(6, 7).draws(), first)


# an estimate's


@cache
def estimator(until: str) -> Bayes:
    return Bayes(Shape.from_mesh(hammer().mesh(), points=56), noise=NOISE, until=until)


@cache
def seen(samples: int) -> SampleState:
    z = wield(UR5.motion(sinusoids(1.5, 100.0, 1.5)), hammer().parameters).with_noise(
        NOISE, 9
    )
    return SampleState.of(z[:samples])


def estimate(until: str) -> Estimate:
    return estimator(until).estimate(seen(150))


def test_an_estimate_claims_what_its_intervals_do():
    found = estimate("mass=1%")
    assert found.intervals is not None
    mass, com, _ = limits_of(found.accuracy)
    off = (
        np.abs(found.intervals["mass"] - found.parameters.mass) / found.parameters.mass
    )
    # half of the interval: of 1,000 draws the quantile is known to 3 %; and the
    # estimate is not its middle
    assert mass == pytest.approx(off.mean(), rel=0.12)
    low, high = found.intervals["center_of_mass"]
    sides = (high - low) / 2.0
    aside = np.abs((high + low) / 2.0 - found.parameters.center_of_mass)
    # a distance is no less sure than the least sure coordinate, and no surer than if
    # all were at their ends
    assert 0.9 * sides.max() < com < 1.1 * np.linalg.norm(sides + aside)


def test_the_claim_is_of_the_body_that_is_shown():
    """Not of the posterior's mean, which with ten samples is no mass distribution in
    the shape."""
    found = estimator("mass=1%").estimate(seen(10))
    posterior = estimator("mass=1%").posterior(seen(10)).mixture
    own = Accuracy.of_draws(posterior.draws(), found.parameters, 0.95)
    assert limits_of(found.accuracy) == pytest.approx(limits_of(own), rel=1e-9)
    mean = Accuracy.of_draws(
        posterior.draws(), InertialParameters(posterior.mean), 0.95
    )
    assert limits_of(mean) != pytest.approx(limits_of(own), rel=1e-3)


def test_what_was_asked_for_decides_whether_it_suffices():
    mass, com, inertia = limits_of(estimate("mass=1%").accuracy)
    for words in (
        "mass={:%},com={:f}m,inertia={:%}",
        "mass={:%}",
        "mass={0:%},com={1:f}m",
    ):
        assert (
            estimate(words.format(1.01 * mass, 1.01 * com, 1.01 * inertia)).sufficient
            is True
        )
        assert (
            estimate(words.format(0.99 * mass, 1.01 * com, 1.01 * inertia)).sufficient
            is False
        )
    assert estimate("mass=1%").accuracy == estimate("mass=2%").accuracy
    with pytest.raises(InputError, match="until is an accuracy, not 5"):
        Bayes(Shape(np.eye(3)), until=5)  # type: ignore[arg-type]


@pytest.mark.parametrize("until", ["mass=50%", "mass=0.0001%"])
def test_a_file_keeps_what_was_reached(until, tmp_path):
    written = estimate(until)
    written.save(tmp_path / "e.json")
    read = Estimate.load(tmp_path / "e.json")
    assert read.accuracy == written.accuracy
    assert read.sufficient is written.sufficient is (until == "mass=50%")
    replace(written, accuracy=Accuracy(np.inf, 0.1, np.inf)).save(
        tmp_path / "open.json"
    )
    json.loads(
        (tmp_path / "open.json").read_text(),
        parse_constant=lambda name: pytest.fail(f"{name} is not JSON"),
    )
    assert Estimate.load(tmp_path / "open.json").accuracy == Accuracy(
        np.inf, 0.1, np.inf
    )
    replace(written, accuracy=None, sufficient=None).save(tmp_path / "none.json")
    assert Estimate.load(tmp_path / "none.json").accuracy is None
    assert Estimate.load(tmp_path / "none.json").sufficient is None


GOOD = {"mass": 0.01, "center_of_mass": 0.002, "inertia": 0.2}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(
            ("accuracy", value)
            for value in (
                5,
                0.0,
                True,
                "x",
                {},
                [],
                [0.1, 0.1, 0.1],
                "mass=1%",
                {"mass": 0.01},
            )
        ),
        *(
            ("accuracy", GOOD | {"inertia": value})
            for value in (
                -0.2,
                0,
                0.0,
                float("nan"),
                float("inf"),
                "0.2",
                "x",
                True,
                [0.2],
                {},
                10**400,
                -(10**400),
            )
        ),
        *(
            ("sufficient", value)
            for value in (0, 1, 0.0, "yes", "", [], {}, [True], float("nan"))
        ),
    ],
)
def test_nonsense_in_a_file_is_told_in_one_line(key, value, tmp_path):
    path, data = tmp_path / "spoiled.json", estimate("mass=1%").to_dict()
    assert set(data["accuracy"]) == set(GOOD)
    path.write_text(json.dumps(data | {key: value}))
    with pytest.raises(InputError) as caught:
        Estimate.load(path)
    assert str(caught.value).startswith(f"{path}: is not a whole estimate")
    assert "\n" not in str(caught.value)

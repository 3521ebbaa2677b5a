"""Bayes's noise: as it was found, in more samples, by time scale; and what of a
posterior is in doubt."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hefting.core.measurements import MotionNoise
from hefting.estimators.bayes.colour import Colour, response_errors
from hefting.estimators.bayes.likelihood import Equations
from hefting.estimators.bayes.noise_found import (
    MotionErrors,
    NoiseFound,
    inflation_of,
)
from hefting.estimators.bayes.passes import Pass, Passes
from hefting.estimators.bayes.posterior import doubtful_shape, warnings_of
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.sample_state import SampleState
from random_problems import random_body, random_motion, with_wrench

BIAS = np.array((1.0, -2.0, 3.0, 0.1, -0.2, 0.1))


def problem(K: int = 60, seed: int = 3):
    rng = np.random.default_rng(seed)
    return with_wrench(random_motion(rng, K), random_body(rng), BIAS, rng, 0.3, 0.02)


def samples_of(z, free_bias: bool = False) -> Samples:
    return Samples.of(SampleState.of(z), free_bias)


def noise_of(samples: Samples, phi, **more) -> NoiseFound:
    R = samples.residual_covariance(phi)
    equations = Equations.of(samples, phi, R, None)
    return NoiseFound(equations, R, False, 1.0, 1.0, phi, **more)


def colour_of(noise, white: bool = False) -> Colour:
    some = np.ones(3)
    return Colour(noise, 2.0, np.ones(4), 0.5, some, some, 1.0, white, False)


def test_noise_holds_where_residuals_are_at_most_a_tenth_larger():
    """Squared, in any channel."""
    samples = samples_of(problem(), True)
    phi = samples.least_squares
    found = noise_of(samples, phi)
    assert found.holds_for(samples)
    for factor, holds in ((1.0 / 1.09, True), (1.0 / 1.11, False)):
        R = found.residual_covariance.copy()
        R[4, 4] *= factor
        assert replace(found, residual_covariance=R).holds_for(samples) is holds


@pytest.mark.parametrize("K", [30, 120])
def test_noise_of_more_samples_has_errors_of_the_sensor_that_grow_with_them(K):
    """As the score does, squared; of fewer they stay as they are. Coloured noise grows
    by that of white noise, times its autocorrelation."""
    z, motion = problem(120), MotionErrors(None, 1.0)
    fewer, more = samples_of(z[:60]), samples_of(z[:K])
    phi = fewer.least_squares
    sensor = 0.1 * np.eye(10)
    noise = 3.0 * np.eye(10)
    found = noise_of(fewer, phi, sensor=sensor, colour=colour_of(noise))
    other = found.of_more(more, phi, motion)
    G, before = other.equations.G, found.equations.G
    growth = np.trace(G) / np.trace(before)
    assert (growth > 1.5) == (K == 120)
    np.testing.assert_allclose(other.sensor, max(growth, 1.0) ** 2 * sensor)
    np.testing.assert_allclose(other.colour.noise, noise + 2.0 * (G - before))
    plain = noise_of(fewer, phi).of_more(more, phi, motion)
    assert plain.sensor is None
    assert plain.colour is None
    assert plain.autocorrelation == 1.0
    assert found.autocorrelation == 2.0


def test_the_likelihood_is_that_of_all_that_is_noise():
    """H V^-1 H about the same parameters, whatever V; the inflation is of V."""
    samples = samples_of(problem(), True)
    phi = samples.least_squares
    white = noise_of(samples, phi)
    G, h = white.equations.G, white.equations.h
    noise, sensor = 2.0 * G + np.eye(10), 0.3 * G
    for found, V in (
        (white, G),
        (noise_of(samples, phi, colour=colour_of(noise, white=True)), G),
        (noise_of(samples, phi, colour=colour_of(noise)), noise),
        (noise_of(samples, phi, sensor=sensor), G + sensor),
        (
            noise_of(samples, phi, sensor=sensor, colour=colour_of(noise)),
            noise + sensor,
        ),
    ):
        for inflation in (1.0, 3.0):
            told = found.likelihood(inflation)
            half = np.linalg.solve(inflation * V, np.column_stack((G, h)))
            expected = G @ half
            size = np.sqrt(expected[:, :10].diagonal())
            np.testing.assert_allclose(
                told.precision / np.outer(size, size),
                expected[:, :10] / np.outer(size, size),
                atol=1e-6,
            )
            np.testing.assert_allclose(
                told.shift / size, expected[:, 10] / size, rtol=1e-5, atol=1e-6
            )
        np.testing.assert_array_equal(
            found.likelihood().precision, found.likelihood(1.0).precision
        )


def test_errors_of_the_motion_last_for_their_memory_over_the_interval():
    state = cast(Any, SimpleNamespace(duration=1.0, samples=101))
    errors = MotionErrors.of(MotionNoise(0.2, 3.0, 0.05), state)
    np.testing.assert_allclose(errors.variances, np.repeat((0.04, 9.0), 3))
    assert errors.memory == pytest.approx(5.0)
    assert not errors.white
    short = MotionErrors.of(MotionNoise(0.2, 0.0, 0.005), state)
    assert short.memory == 1.0
    assert short.white
    for none in (None, MotionNoise(0.0, 0.0, 0.05)):
        assert MotionErrors.of(none, state).variances is None
    one = cast(Any, SimpleNamespace(duration=0.0, samples=1))
    assert MotionErrors.of(MotionNoise(0.2, 3.0, 0.05), one).memory == 1.0
    assert (inflation_of(3.0), inflation_of(3.1)) == (1.0, 3.1)


def test_a_gain_of_a_time_scale_is_what_errors_of_the_motion_do_not_explain():
    """White ones attenuate all alike; what is beyond chance fades towards slower scales
    by the third root of a half, but for scales that bound it."""
    signal = np.array((1e6, 0.0, 1e4, 1e2))
    information = np.zeros((4, 10, 10))
    information[:, 0, 0] = signal
    phi = np.eye(10)[0]

    def errors(score, details=0.0, unit=1.0):
        scores = np.zeros((4, 10))
        scores[:, 0] = unit * np.asarray(score)
        found = cast(
            Any, SimpleNamespace(information=unit * information, scores=scores)
        )
        return response_errors(found, np.full(4, unit), np.full(4, unit * details), phi)

    fade = 0.5 ** (1.0 / 3.0)
    assert not errors(np.zeros(4)).any()
    shown = 0.1 * (1.0 - 12.0 / 1e4) ** 0.5
    for sign in (1.0, -1.0):
        found = errors(sign * np.array((1e5, 0.0, 0.0, 0.0)))
        expected = (shown, fade * shown, 0.02, fade * 0.02, fade**2 * 0.02)
        np.testing.assert_allclose(found, expected)
        # in any unit of what is whitened
        score = sign * np.array((1e5, 0.0, 0.0, 0.0))
        np.testing.assert_allclose(errors(score, unit=1e-7), expected)
    # by chance a gain of 12 squared deviations is seen
    assert not errors((3.4e3, 0.0, 0.0, 0.0)).any()
    assert errors((3.5e3, 0.0, 0.0, 0.0))[0] > 0.0
    # the same of each detail is attenuation, and what is added to it no gain
    attenuated = -np.array((1e5, 1e5, 1e5, 1e5))
    assert not errors(attenuated, 1e3).any()
    assert errors(-attenuated, 1e3)[3] > 0.1


# passes


def test_a_posterior_has_a_centre_where_its_mass_exceeds_its_deviation():
    com = np.zeros(3)
    center, told = (
        cast(Any, Pass.__dict__[name]).func for name in ("center", "tells_mass")
    )
    for mass, is_told in ((0.19, False), (0.21, True), (-1.0, False)):
        mean = np.append(mass, np.full(9, 0.1))
        mixture = SimpleNamespace(mean=mean, mass_std=0.2)
        assert told(SimpleNamespace(mixture=mixture)) == is_told
        found = SimpleNamespace(mixture=mixture, tells_mass=is_told, com=com)
        expected = np.full(3, 0.1 / mass) if is_told else com
        np.testing.assert_array_equal(center(found), expected)


def test_the_prior_s_mass_is_near_the_rough_one():
    """A fifth to twice as much."""
    passes = cast(Any, SimpleNamespace(rough_mass=2.0))
    for mass, scale in ((0.1, 0.4), (-1.0, 0.4), (0.5, 0.5), (3.9, 3.9), (9.0, 4.0)):
        assert Passes._scale(passes, np.full(10, mass)) == pytest.approx(scale)


def test_a_rough_mass_is_found_whatever_noise_three_samples_seem_to_have():
    """What errors of the motion explain may be more than all of it."""
    samples = SimpleNamespace(mass_scale=lambda force_std: force_std)
    for level, std in ((4.0, 2.0), (-4.0, 0.0)):
        noise = level * np.eye(6)
        source = SimpleNamespace(level=lambda given=noise: given, samples=samples)
        passes = Passes(cast(Any, source), cast(Any, None), None)
        assert passes.rough_mass == std


# doubts


def posterior(**more: Any):
    """Of a kilogram known to 1 %, of which nothing is in doubt."""
    return cast(
        Any,
        SimpleNamespace(
            **{
                "noise_known": True,
                "contradicted": False,
                "coloured": False,
                "excess": 1.0,
                "disagreement": 0.0,
                "response": 0.0,
                "mixture": SimpleNamespace(mean=np.ones(10), mass_std=0.01),
                "last": SimpleNamespace(likelihood=SimpleNamespace(mass=(1.0, 1e-4))),
                "settled": True,
                "shape_known": True,
                "misfit": 0.0,
                "evidence": 0.0,
                "instead": "",
                "scale_doubts": (),
                "bias": None,
            }
            | more
        ),
    )


@pytest.mark.parametrize(
    ("doubt", "distance", "code"),
    [
        ({}, 0.0, None),
        ({"noise_known": False}, 0.0, "noise-unknown"),
        ({"contradicted": True, "excess": 4.0}, 0.0, "noise-exceeds-claim"),
        ({"coloured": True}, 0.0, "noise-coloured"),
        ({"disagreement": 2.9}, 0.0, None),
        ({"disagreement": 3.1}, 0.0, "stretches-disagree"),
        ({"response": 0.0070}, 0.0, None),
        ({"evidence": -3.9}, 0.0, None),
        ({"evidence": -4.1}, 0.0, "shape-contradicts-wrench"),
        ({"response": 0.0072}, 0.0, "response-uneven"),
        ({"settled": False}, 0.0, "shape-not-found"),
        ({"misfit": 99.0, "shape_known": False}, 0.0, None),
        ({"misfit": 101.0}, 0.0, "shape-contradicts-wrench"),
        ({"misfit": 101.0, "shape_known": False}, 0.0, "shape-contradicts-wrench"),
    ],
)
def test_a_posterior_s_doubts_have_their_thresholds(doubt, distance, code):
    """An uneven response counts as the larger part of the mass's deviation, squared."""
    told = [m.code for m in warnings_of(posterior(**doubt), distance)]
    assert told == ([code] if code else [])


def test_a_shape_is_doubtful_by_both_distances_together():
    assert doubtful_shape(posterior(misfit=12.0), 7.9) == 0.0
    assert doubtful_shape(posterior(misfit=12.0), 8.1) == pytest.approx(20.1)
    for more in (
        {"shape_known": False},
        {"contradicted": True},
        {"coloured": True},
        {"disagreement": 3.1},
    ):
        assert doubtful_shape(posterior(misfit=12.0, **more), 30.0) == 0.0

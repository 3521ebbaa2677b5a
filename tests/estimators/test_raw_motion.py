"""White noise of accelerations of which nothing is said."""

from dataclasses import replace

import numpy as np
import pytest

from hammers import NOISE, exact, noisy
from hefting.core.measurements import MotionNoise, Noise
from hefting.estimators import OLS, Bayes
from hefting.estimators.joint_state import motion_record
from hefting.estimators.sample_state import SampleState
from hefting.simulation import UR5, hammer, trapezoids, wield


def record(z):
    found = SampleState.empty(with_record=True).fold(z).record
    assert found is not None
    return found


def with_errors(linear, angular, samples=1000):
    """Of accelerations (K, 3) of exact samples."""
    z = exact(samples)
    return replace(
        z,
        linear_acceleration=z.linear_acceleration + linear,
        angular_acceleration=z.angular_acceleration + angular,
    )


@pytest.mark.parametrize("samples", [100, 150, 1000])
def test_levels_of_white_noise_are_found(samples):
    """To four standard deviations of chance, which in fourth differences of three axes
    is that of a fifth of so many samples."""
    found = record(replace(noisy(1, samples), noise=None)).found_motion_noise
    tolerance = 4.0 / (2.0 * 0.2 * 3 * samples) ** 0.5
    assert found.linear == pytest.approx(NOISE.linear_acceleration, rel=tolerance)
    assert found.angular == pytest.approx(NOISE.angular_acceleration, rel=tolerance)
    assert found.memory == 0.0


def test_one_of_the_two_may_be_noisy():
    noise = Noise(angular_acceleration=0.3)
    found = record(replace(noisy(2, noise=noise), noise=None)).found_motion_noise
    assert found.linear == 0.0
    assert found.angular == pytest.approx(0.3, rel=0.1)


@pytest.mark.parametrize(
    "kind", ["exact", "rounded", "differentiated", "twice", "shuffled", "one axis"]
)
def test_nothing_is_found_in_motion_rounding_and_noise_of_another_colour(kind):
    rng, K = np.random.default_rng(3), 1000
    z, white = exact(K), 0.05 * rng.normal(size=(K, 3))
    if kind == "rounded":
        z = replace(
            z,
            linear_acceleration=np.round(z.linear_acceleration, 5),
            angular_acceleration=np.round(z.angular_acceleration, 5),
        )
    if kind == "differentiated":
        z = with_errors(white, np.diff(0.3 * rng.normal(size=(K + 1, 3)), axis=0))
    if kind == "twice":
        z = with_errors(white, np.diff(0.1 * rng.normal(size=(K + 2, 3)), 2, axis=0))
    if kind == "one axis":
        z = with_errors(0.0, 0.5 * rng.normal(size=(K, 3)) * (1.0, 0.0, 0.0))
    if kind == "shuffled":
        z = z[rng.permutation(K)]
    assert record(z).found_motion_noise is None


@pytest.mark.parametrize("rate", [100.0, 500.0])
@pytest.mark.parametrize(("speed", "acceleration"), [(0.6, 1.2), (1.5, 4.0)])
def test_jumps_at_the_corners_of_trapezoids_are_no_noise(rate, speed, acceleration):
    """But noise beside them is found: jumps that are a part of the differences' square
    may make it a third larger. Bayes had taken the jumps for noise of the motion, and its
    inertia was up to seven times as far off."""
    moves = trapezoids(12.0, rate, speed, acceleration, seed=3)
    z = wield(UR5.motion(moves), hammer().parameters)
    assert record(z).found_motion_noise is None
    said = replace(z, motion_noise=MotionNoise(0.0, 0.0))
    found, exactly = (Bayes().fit(each).inertia for each in (z, said))
    np.testing.assert_allclose(found, exactly)
    rng, levels, noisy_ones = np.random.default_rng(4), [], []
    for values in (z.linear_acceleration, z.angular_acceleration):
        levels.append(0.3 * values.std(axis=0).mean())
        noisy_ones.append(values + levels[-1] * rng.normal(size=values.shape))
    linear, angular = noisy_ones
    both = record(
        replace(z, linear_acceleration=linear, angular_acceleration=angular)
    ).found_motion_noise
    assert both is not None
    assert (both.linear, both.angular) == pytest.approx(levels, rel=0.33)


def test_what_is_said_is_not_looked_for():
    z = noisy(4)
    levels = NOISE.linear_acceleration, NOISE.angular_acceleration
    assert record(z).found_motion_noise is None
    assert vars(record(z).motion_noise) == pytest.approx(vars(MotionNoise(*levels)))
    claimed = replace(z, noise=None, motion_noise=MotionNoise(0.0, 0.0))
    assert record(claimed).found_motion_noise is None
    assert record(claimed).motion_noise == MotionNoise(0.0, 0.0)


@pytest.mark.parametrize("pieces", [[1] * 200, [64, 64, 72], [30, 170]])
def test_it_does_not_depend_on_how_samples_arrive(pieces):
    z = replace(noisy(5, 200), noise=None)
    state, first = SampleState.empty(with_record=True), 0
    for size in pieces:
        state, first = state.fold(z[first : first + size]), first + size
    assert state.record is not None
    np.testing.assert_allclose(
        state.record.rough_whole, record(z).rough_whole, rtol=1e-12
    )


def test_weights_do_not_matter_and_samples_left_out_are_no_neighbours():
    z, rng = replace(noisy(6, 640), noise=None), np.random.default_rng(6)
    weighed = record(replace(z, weights=rng.uniform(0.1, 3.0, 640)))
    np.testing.assert_allclose(weighed.rough_whole, record(z).rough_whole, rtol=1e-10)
    weights = np.ones(640)
    weights[70] = 0.0  # of the second block of 64
    left = record(replace(z, weights=weights)).rough_whole
    assert left[3, 0] == 640 - 64


def test_several_records_add_up():
    halves = [replace(noisy(seed, 300), noise=None) for seed in (7, 8)]
    ols = OLS(bias="estimate")
    joint = ols.merge(*(ols.update(ols.start(), z) for z in halves))
    seen = motion_record(joint)
    assert seen is not None
    np.testing.assert_allclose(
        seen.rough_whole, sum(record(z).rough_whole for z in halves)
    )


def test_bayes_tells_what_it_found():
    z = replace(noisy(9), noise=None)
    linear, angular = Bayes().fit(z).provenance["motion_noise"]
    assert linear == pytest.approx(NOISE.linear_acceleration, rel=0.1)
    assert angular == pytest.approx(NOISE.angular_acceleration, rel=0.1)

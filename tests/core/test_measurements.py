"""Measurements: shapes, choice of samples, frames, noise."""

from dataclasses import fields, replace

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from random_problems import random_motion, random_pose

ARRAYS = (
    "gravity",
    "linear_acceleration",
    "angular_velocity",
    "angular_acceleration",
    "force",
    "torque",
)


@pytest.fixture
def z() -> Measurements:
    rng = np.random.default_rng(1)
    return replace(
        random_motion(rng, 12), weights=rng.uniform(size=12), noise=NOISE_LEVELS["low"]
    )


def test_arrays_are_copied_and_read_only(z):
    force = np.ones((12, 3))
    copy = replace(z, force=force)
    force[:] = 7.0
    assert (copy.force == 1.0).all()
    for name in ("time", "weights", *ARRAYS):
        with pytest.raises(ValueError, match="read-only"):
            getattr(copy, name)[0] = 0.0


@pytest.mark.parametrize(
    "index", [slice(2, 9, 3), np.arange(12) % 2 == 0, np.array([3, 1, 1])]
)
def test_chosen_samples(z, index):
    part = z[index]
    assert part.noise == z.noise
    assert len(part) == len(z.time[index])
    for name in ("time", "weights", *ARRAYS):
        np.testing.assert_array_equal(getattr(part, name), getattr(z, name)[index])
    assert replace(z, weights=None)[index].weights is None


def test_one_sample_may_be_given_without_its_axis():
    vector = np.arange(3.0)
    one = Measurements(0.5, *[vector] * 6)
    assert len(one) == 1
    assert one.wrench.shape == (1, 6)


@pytest.mark.parametrize("name", [*ARRAYS, "weights"])
def test_wrong_shapes_and_values_name_the_field(z, name):
    with pytest.raises(InputError, match=rf"Measurements\.{name}: has shape"):
        replace(z, **{name: getattr(z, name)[:-1]})
    bad = np.array(getattr(z, name))
    bad[4] = np.inf
    with pytest.raises(
        InputError, match=rf"Measurements\.{name}: sample 4 is not finite"
    ):
        replace(z, **{name: bad})


def test_negative_weights_are_refused(z):
    with pytest.raises(InputError, match="weights"):
        replace(z, weights=-z.weights)


def test_wrench_is_force_then_torque(z):
    full = replace(z, force=np.ones((12, 3)), torque=2 * np.ones((12, 3)))
    np.testing.assert_array_equal(
        full.wrench, np.repeat([[1.0, 2.0]], 3, axis=1) * np.ones((12, 1))
    )


def test_moving_keeps_what_has_no_frame(z):
    moved = z.moved(random_pose(np.random.default_rng(2)))
    np.testing.assert_array_equal(moved.time, z.time)
    np.testing.assert_array_equal(moved.weights, z.weights)
    np.testing.assert_allclose(np.linalg.norm(moved.gravity, axis=1), 9.81, rtol=1e-14)


def test_noise_is_seeded_and_of_the_stated_levels():
    z = random_motion(np.random.default_rng(3), 20_000)
    noise = Noise(
        force=0.3, torque=0.02, linear_acceleration=0.1, angular_acceleration=1.5
    )
    noisy = z.with_noise(noise, 1)
    same = z.with_noise(noise, 1)
    other = z.with_noise(noise, 2)
    assert noisy.noise == noise
    differences = []
    for field in fields(Noise):
        difference = getattr(noisy, field.name) - getattr(z, field.name)
        np.testing.assert_array_equal(
            getattr(noisy, field.name), getattr(same, field.name)
        )
        assert not np.array_equal(
            getattr(noisy, field.name), getattr(other, field.name)
        )
        # 60,000 numbers: the standard deviation is known to 0.3 %, the mean to 0.4 % of
        # it
        assert difference.std() == pytest.approx(getattr(noise, field.name), rel=0.02)
        assert abs(difference.mean()) < 0.02 * getattr(noise, field.name)
        differences.append(difference)
    correlation = np.corrcoef(np.hstack(differences).T) - np.eye(12)
    assert np.abs(correlation).max() < 0.04  # 1/sqrt(20,000) = 0.007
    for name in ("time", "gravity", "angular_velocity"):
        np.testing.assert_array_equal(getattr(noisy, name), getattr(z, name))


def test_no_noise_changes_nothing(z):
    quiet = z.with_noise(NOISE_LEVELS["none"], 4)
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(quiet, name), getattr(z, name))


def test_noise_levels_of_the_paper():
    """Nadeau et al. 2022, table II: angular and linear acceleration, force, torque."""
    table = {
        "low": (0.25, 0.025, 0.05, 0.0025),
        "moderate": (0.5, 0.05, 0.1, 0.005),
        "high": (1.0, 0.1, 0.33, 0.0067),
    }
    for name, (angular, linear, force, torque) in table.items():
        assert NOISE_LEVELS[name] == Noise(force, torque, linear, angular)

"""The model of the wrench: about any clock offset and gravity it is that of the motion
at those times."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import GRAVITY, disturbed
from hefting.core.recording import Recording, Stream
from hefting.ingest.blocks import Blocks
from hefting.ingest.model import (
    LARGEST_TAYLOR_STEP,
    Layout,
    Model,
    Problem,
    tangents_of,
    tilt_gravity,
)
from hefting.ingest.path import path_of, static_path


@pytest.fixture(scope="module")
def problem():
    """Of blocks at single times, so that nothing is averaged."""
    recording = disturbed("clean", 1.0, 0, duration=2.0).recording
    wrench = recording["wrench"]
    blocks = Blocks.of(wrench.time, wrench.values, smooth=False)
    path = path_of(recording)
    assert path is not None
    return Problem(path, blocks, free_offset=True, free_gravity=True, knots=(1,))


@pytest.mark.parametrize("offset", [-0.05, 0.0, 0.02])
def test_features_are_those_of_the_motion_at_the_time_of_the_wrench(problem, offset):
    """a - g, alpha, and products of w in sensor axes; known inside alone."""
    model = Model.at(problem, offset, GRAVITY)
    first, last = problem.path.first, problem.path.last
    wanted = problem.time - offset
    inside = (wanted >= first) & (wanted <= last)
    m = problem.path.curves.alone.at(np.clip(wanted, first, last))
    np.testing.assert_array_equal(model.reading.known, inside)
    R = np.moveaxis(
        np.array([rotated(m.orientation, axis) for axis in np.eye(3)]), 0, 2
    )
    a = m.linear_acceleration - np.einsum("kij,j->ki", R, GRAVITY)
    np.testing.assert_allclose(model.features[:, :3], a, atol=1e-9)
    np.testing.assert_allclose(model.features[:, 3:6], m.angular_acceleration)
    squares = np.square(m.angular_velocity).sum(axis=1)
    products = np.einsum("ki,kj->kij", m.angular_velocity, m.angular_velocity)
    found = model.features[:, 6:]
    # the six products, in any order, each of them once
    for k in (0, 57):
        upper = products[k][np.triu_indices(3)]
        np.testing.assert_allclose(np.sort(found[k]), np.sort(upper), atol=1e-12)
    assert squares.max() > 0.1


def rotated(quaternions, vector):
    """(K, 3) a vector of the world in sensor axes."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(np.array(quaternions)).inv().apply(vector)


def test_the_model_about_one_offset_is_derived_from_that_about_another(problem):
    """A motion that was read within 8 ms, or 2 ms at last, is extrapolated: of the third
    order in the step, of 2 Hz 2e-4 and 3e-6."""
    about = Model.at(problem, 0.0, GRAVITY)
    size = about.features.std(axis=0)
    inner = slice(5, -5)
    for final, most, error in ((False, 8e-3, 2e-3), (True, 2e-3, 5e-5)):
        assert LARGEST_TAYLOR_STEP[True][final] == most
        for step, kept in ((0.95 * most, True), (1.05 * most, False)):
            for offset in (step, -step):
                near = Model.at(problem, offset, GRAVITY, about.reading, final=final)
                exact = Model.at(problem, offset, GRAVITY)
                assert (near.reading.time is about.reading.time) == kept
                apart = np.abs(near.features - exact.features)[inner] / size
                assert apart.max() < error
                # known at the times that are wanted, not at those that were read
                np.testing.assert_array_equal(near.reading.known, exact.reading.known)
    fewer = replace(problem, blocks=problem.blocks.every(50))
    assert len(Model.at(fewer, 0.0, GRAVITY, about.reading).features) <= 50


def test_rates_are_those_of_the_features(problem):
    """By differences of a millisecond either way."""
    model = Model.at(problem, 0.01, GRAVITY)
    early, late = (Model.at(problem, 0.01 + s, GRAVITY).features for s in (1e-3, -1e-3))
    rates = (late - early) / 2e-3
    inner = slice(8, -8)
    size = rates.std(axis=0)
    np.testing.assert_allclose(
        model.known[inner, 12:24] / size, rates[inner] / size, atol=0.02
    )


def test_static_poses_have_no_clock():
    """An offset does not move one wrench to the pose of another."""
    recording = disturbed("clean", 1.0, 0, duration=2.0).recording
    streams = {
        name: Stream(np.arange(15.0), s.values[::14][:15])
        for name, s in recording.streams.items()
    }
    poses = Recording(streams, static=True)
    wrench = poses["wrench"]
    blocks = Blocks.of(wrench.time, wrench.values, smooth=False)
    problem = Problem(static_path(poses), blocks, False, False, (1,))
    now, late = (Model.at(problem, offset, GRAVITY) for offset in (0.0, 1.3))
    expected = -rotated(poses["orientation"].values, GRAVITY)
    np.testing.assert_allclose(now.features[:, :3], expected, atol=1e-12)
    assert not now.features[:, 3:].any()
    np.testing.assert_array_equal(late.features, now.features)
    assert late.reading.known.all()


def test_where_unknowns_are():
    both = Layout.of(free_offset=True, free_gravity=True)
    assert (both.offset, both.tilt, both.core) == (10, slice(11, 13), 13)
    offset = Layout.of(free_offset=True, free_gravity=False)
    assert (offset.offset, offset.tilt, offset.core) == (10, None, 11)
    tilt = Layout.of(free_offset=False, free_gravity=True)
    assert (tilt.offset, tilt.tilt, tilt.core) == (None, slice(10, 12), 12)
    none = Layout.of(free_offset=False, free_gravity=False)
    assert (none.offset, none.tilt, none.core) == (None, None, 10)


def test_the_model_with_a_fixed_offset_is_that_without_one(problem):
    fixed = Model.at(problem, 0.01, GRAVITY).with_fixed_offset
    other = Model.at(replace(problem, free_offset=False), 0.01, GRAVITY)
    assert fixed.layout == other.layout
    np.testing.assert_allclose(fixed.known, other.known, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_gravity_is_tilted_across_itself_and_keeps_its_size(seed):
    gravity = np.random.default_rng(seed).normal(size=3) * 9.81
    tangents = tangents_of(gravity)
    np.testing.assert_allclose(tangents @ tangents.T, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(tangents @ gravity, 0.0, atol=1e-12)
    g = np.linalg.norm(gravity)
    moved = tilt_gravity(gravity, g * np.array((0.3, -0.4)))
    assert np.linalg.norm(moved) == pytest.approx(g)
    # the tangent of the angle is half
    np.testing.assert_allclose(tangents @ moved / (moved @ gravity / g), (0.3, -0.4))


def test_the_floor_of_residuals_is_a_billionth_of_the_wrench(problem):
    """Of force and torque; neither below a thousandth of the other's, nor 1e-15."""
    rng = np.random.default_rng(2)
    for force, torque in ((5.0, 0.3), (5.0, 1e-4), (1e-9, 1e-9), (1e-4, 50.0)):
        wrench = rng.normal(size=problem.wrench.shape) * np.repeat((force, torque), 3)
        own = replace(problem, blocks=replace(problem.blocks, wrench=wrench))
        size = np.sqrt(np.mean(wrench.reshape(-1, 2, 3) ** 2, axis=(0, 2)))
        least = 1e-12 * max(size.max(), 1e-3)
        np.testing.assert_allclose(own.floor, np.maximum(1e-9 * size, least))

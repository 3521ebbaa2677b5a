"""Recordings that can be read and are of no use: found by fuzzing, each once."""

from contextlib import suppress

import numpy as np
import pytest

from hefting.core.accuracy import errors_between
from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.estimators.bayes.mixture import _cholesky
from hefting.identification import identify
from hefting.inspection import inspect
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, simulate, sinusoids


@pytest.fixture(scope="module")
def recording():
    return simulate(UR5.motion(sinusoids(4.0, 20.0, 1.0)), hammer().parameters)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_hardly_any_wrench(recording, count):
    """The step between wrench samples was the median of none, which warns; a warning
    is an error in the tests."""
    wrench = recording["wrench"][20 : 20 + count]
    short = Recording(dict(recording.streams) | {"wrench": wrench})
    for action in (inspect, identify):
        with suppress(InputError):
            action(short)


def test_motion_that_dwarfs_everything(recording):
    """Velocities of 1e5 in one column: the precision spans more than rounding."""
    motion = UR5.motion(sinusoids(4.0, 20.0, 1.0))
    streams = dict(simulate(motion, hammer().parameters, exact=True).streams)
    for name in ("angular_velocity", "linear_acceleration"):
        values = np.array(streams[name].values)
        values[:, 2] = 1e5
        streams[name] = Stream(motion.time, values)
    with suppress(InputError):
        assert np.isfinite(
            identify(Recording(streams)).estimate.parameters.vector
        ).all()


@pytest.mark.parametrize("step", [1e-11, 1e-8])
def test_a_filter_of_endless_lag(recording, step):
    """0.1 s are 1e10 samples then: each would be a turn of a loop."""
    stretched = {
        name: Stream(step * np.arange(len(stream)), stream.values)
        for name, stream in recording.streams.items()
    }
    with pytest.raises(InputError, match=r"lag of 0\.1 s is .* samples"):
        identify(Recording(stretched), motion="filter")


@pytest.mark.parametrize("spread", [1.0, 1e10, 1e20, 1e40])
def test_factors_of_matrices_of_any_spread(spread):
    """R R' = M up to rounding of the largest entry, R lower triangular, where NumPy's
    own factorisation fails too."""
    rng = np.random.default_rng(3)
    turns = np.linalg.qr(rng.normal(size=(4, 10, 10)))[0]
    sizes = 1.0 + spread * rng.uniform(size=(4, 1, 10)) ** 30
    M = (turns * sizes) @ turns.transpose(0, 2, 1)
    R = _cholesky(M)
    assert np.array_equal(R, np.tril(R))
    assert (np.einsum("jii->ji", R) > 0.0).all()
    np.testing.assert_allclose(R @ R.transpose(0, 2, 1), M, atol=1e-12 * (1.0 + spread))


def test_errors_of_a_needle_are_finite():
    """Shares of the inertia of a box with sides a, b, c, which is m (b² + c²) / 12 about
    x: with a far longer that was zero up to rounding."""
    sides = np.array([1e9, 0.1, 0.2])
    body = InertialParameters.from_com(2.0, np.zeros(3), np.eye(3))
    more = InertialParameters.from_com(
        2.0, np.zeros(3), np.diag((1.0 + 1e-3, 1.0, 1.0))
    )
    share = 1e-3 / (2.0 / 12.0 * (sides[1] ** 2 + sides[2] ** 2))
    found = errors_between(more, body, sides).inertia_at_com
    # of six entries, one is wrong
    assert found == pytest.approx(100.0 * share / 6.0, rel=1e-9)


@pytest.mark.parametrize("size", [1e-10, 1e-187, 1e-300])
def test_clouds_smaller_than_anything(size):
    points = size * np.random.default_rng(1).uniform(size=(60, 3))
    with pytest.raises(InputError, match="the point cloud is only"):
        Shape.from_cloud(points)

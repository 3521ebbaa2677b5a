"""What is expected of new samples: chi-square while nothing changes, and the change of
a body as it is."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.online_streams import swapped

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import MotionNoise
from hefting.core.regressor import predict_wrench
from hefting.ingest.ingest import ingest
from hefting.online.expected import LARGEST, LARGEST_MISFIT, Expected, Watch


@pytest.fixture(scope="module")
def known():
    """What is expected by five seconds, and the motion of the four after."""
    case = swapped(2, change=False, duration=9.0)
    found = ingest(case.recording)
    whole = found.measurements
    split = int(np.searchsorted(whole.time, 5.0))
    first = replace(found, measurements=whole[:split], counts=found.counts[:split])
    later = whole[split:]
    good = np.flatnonzero(later.weights > 0.5)
    return case, Expected.of(first), later[good]


def drawn(expected, z, body, rng):
    """Samples of a body with the noise and the bias that are expected."""
    bias = expected.x[10:16] + np.outer(z.time - expected.end, expected.x[16:22])
    wrench = predict_wrench(z, body) + bias
    wrench += expected.noise * rng.normal(size=wrench.shape)
    return replace(z, force=wrench[:, :3], torque=wrench[:, 3:])


def test_size_is_chi_square_while_nothing_changes(known):
    """400 draws of body, bias and noise from what is expected: the mean of chi-square
    with four degrees of freedom is 4, its standard error 0.14; four of these."""
    _, expected, z = known
    white = replace(expected, scale=np.ones(2), offset_std=0.0)
    rng = np.random.default_rng(1)
    root = np.linalg.cholesky(white.covariance + 1e-18 * np.eye(22))
    sizes = []
    for _ in range(400):
        true = replace(white, x=white.x + root @ rng.normal(size=22))
        part = drawn(true, z[:100], true.x[:10], rng)
        sizes.append(white.of_latest(part, 0.9).size)
    # the drift may go on otherwise, which no draw does
    assert 2.5 < np.mean(sizes) < 4.56
    assert np.max(sizes) < LARGEST


def resting(z, rng):
    """Samples at rest, and the same as errors of their poses show them."""
    noise = MotionNoise(0.1, 0.5)
    none = np.zeros((len(z), 3))
    true = replace(
        z,
        gravity=np.broadcast_to(z.gravity[0], (len(z), 3)),
        linear_acceleration=none,
        angular_velocity=none,
        angular_acceleration=none,
        weights=np.ones(len(z)),
        motion_noise=noise,
    )
    errors = rng.normal(size=(2, *none.shape))
    return true, replace(
        true,
        linear_acceleration=noise.linear * errors[0],
        angular_acceleration=noise.angular * errors[1],
    )


@pytest.mark.parametrize(("share", "most"), [(0.0, 0), (-0.1, 20), (0.1, 20)])
def test_errors_of_accelerations_at_rest_are_no_change(known, share, most):
    """20 draws. Regressor and prediction have the same errors, which look as if the first
    moment along gravity were gone; a tenth of the mass is still told."""
    _, expected, z = known
    rng = np.random.default_rng(6)
    told = 0
    for _ in range(20):
        true, seen = resting(z[:100], rng)
        felt = drawn(expected, true, (1.0 + share) * expected.x[:10], rng)
        part = replace(seen, force=felt.force, torque=felt.torque)
        told += expected.of_latest(part, 0.9).size > LARGEST
    assert told == most


def test_noise_of_accelerations_does_not_tell_an_inertia():
    """Ten draws of 4 s without an angular acceleration but that of noise, which would tell
    that there is no inertia to its tenth; then the arm turns."""
    rng = np.random.default_rng(7)
    found = ingest(swapped(2, change=False, duration=9.0).recording)
    z = found.measurements
    body = InertialParameters.from_com(1.4, (0.0, 0.1, 0.2), 0.02 * np.eye(3)).vector
    split = int(np.searchsorted(z.time, 4.0))
    noise = MotionNoise(0.02, 0.1)
    turning = np.where(z.time < 4.0, 0.0, 1.0)[:, None]
    for _ in range(10):
        true = replace(
            z,
            angular_velocity=turning * z.angular_velocity,
            angular_acceleration=turning * z.angular_acceleration,
            weights=None,
            motion_noise=noise,
        )
        wrench = predict_wrench(true, body)
        wrench += np.repeat((0.05, 0.002), 3) * rng.normal(size=wrench.shape)
        errors = rng.normal(size=(2, len(z), 3))
        seen = replace(
            true,
            linear_acceleration=true.linear_acceleration + noise.linear * errors[0],
            angular_acceleration=true.angular_acceleration + noise.angular * errors[1],
            force=wrench[:, :3],
            torque=wrench[:, 3:],
        )
        first = replace(found, measurements=seen[:split], counts=found.counts[:split])
        expected = Expected.of(first)
        part = seen[split : split + 120]
        assert expected.of_latest(part, 0.9).size < LARGEST
        heavier = replace(part, force=1.1 * part.force, torque=1.1 * part.torque)
        assert expected.of_latest(heavier, 0.9).size > LARGEST


@pytest.mark.parametrize("share", [-0.1, 0.1])
def test_another_mass_is_told(known, share):
    """A tenth of 1.4 kg beside 0.1 N."""
    _, expected, z = known
    body = InertialParameters((1.0 + share) * expected.x[:10])
    part = drawn(expected, z[:100], body.vector, np.random.default_rng(2))
    found = expected.of_latest(part, 0.9)
    assert found.size > 10.0 * LARGEST
    assert found.misfit == pytest.approx(1.0, abs=0.3)


def test_a_long_body_is_another_object_and_no_push(known):
    """Two kilograms more, whose moments of inertia leave twelve times the noise beside
    mass and COM."""
    _, expected, z = known
    change = InertialParameters.from_com(2.0, (0.0, 0.1, 0.2), 0.1 * np.eye(3))
    body = expected.x[:10] + change.vector
    part = drawn(expected, z[:100], body, np.random.default_rng(5))
    # of white noise that is one
    assert expected.of_latest(part, 0.9).misfit < 1.5


def test_a_heavy_object_is_told_beside_errors_of_the_accelerations(known):
    """Ten kilograms more: errors of 0.04 m/s² in their accelerations are four times the
    noise of 0.1 N."""
    _, expected, z = known
    rng = np.random.default_rng(8)
    change = InertialParameters.from_com(10.0, (0.0, 0.1, 0.2), 0.02 * np.eye(3))
    part = drawn(expected, z[:100], expected.x[:10] + change.vector, rng)
    errors = 0.04 * rng.normal(size=(100, 3))
    seen = replace(part, linear_acceleration=part.linear_acceleration + errors)
    assert expected.of_latest(seen, 0.9).misfit < LARGEST_MISFIT


def test_a_push_is_explained_by_no_body(known):
    """5 N along the sensor's x axis, and none about it."""
    _, expected, z = known
    part = drawn(expected, z[:100], expected.x[:10], np.random.default_rng(3))
    pushed = replace(part, force=part.force + np.array((5.0, 0.0, 0.0)))
    found = expected.of_latest(pushed, 0.9)
    assert found.size > LARGEST
    assert found.misfit > 5.0
    watch = Watch()
    for end in range(20, 100, 10):
        watch = watch.looked(expected, pushed[:end])
    assert watch.onset is not None
    assert not watch.changed


def test_spikes_are_not_another_object(known):
    _, expected, z = known
    part = drawn(expected, z[:100], expected.x[:10], np.random.default_rng(4))
    force = part.force.copy()
    force[::20] += 20.0
    assert expected.of_latest(replace(part, force=force), 0.9).size < LARGEST


def test_too_short_a_recording_says_nothing(known):
    case, _, _ = known
    assert Expected.of(ingest(case.recording.slice(0.0, 2.0))) is None

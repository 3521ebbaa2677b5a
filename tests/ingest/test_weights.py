"""Recordings without positions: accelerations that nobody measured are noise, not one
mistake or another."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.given import correct
from scipy.spatial.transform import Rotation

from hefting import Recording, identify
from hefting.core.measurements import Measurements
from hefting.core.messages import codes
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.ingest.weights import weights_at_rest
from hefting.simulation import UR5, sinusoids
from hefting.simulation.faults import WRENCH_NOISE, Faults, Rates
from hefting.simulation.physics import wield_analytically
from hefting.simulation.record import record

MISTAKES = {
    "axes-turned",
    "change-part-used",
    "change-touched",
    "clock-offset-contradictory",
    "cross-talk",
    "gain-uneven",
    "sloshing",
    "unexplained",
}
"""Codes of what such recordings were said to be."""


def without_positions(recording: Recording) -> Recording:
    streams = {n: s for n, s in recording.streams.items() if n != "position"}
    return replace(recording, streams=streams)


def test_accelerations_are_not_taken_for_a_mistake():
    """Of 60 such recordings the 95 % intervals of mass and COM hold 96 to 100 %, and no
    mistake is named; here are ten."""
    for seed in range(10):
        given = correct(seed)
        found = identify(without_positions(given.recording)).estimate
        named = codes(found.verdict.reasons) & MISTAKES
        assert not named, seed
        low, high = found.intervals["center_of_mass"]
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        assert (abs(given.truth.center_of_mass - middle) < 2.0 * half).all(), seed


@pytest.mark.parametrize(
    ("code", "change"),
    [
        ("axes-turned", lambda _, w: w[:, [1, 0, 2, 4, 3, 5]] * (1, -1, 1, 1, -1, 1)),
        ("quaternion-order", None),
    ],
)
def test_what_no_acceleration_explains_is_named(code, change):
    given = correct(0)
    if change is not None:
        recording = given.wrench(change).recording
    else:
        turned = given.recording["orientation"]
        turned = replace(turned, values=turned.values[:, [3, 0, 1, 2]])
        streams = {**given.recording.streams, "orientation": turned}
        recording = replace(given.recording, streams=streams)
    found = identify(without_positions(recording))
    assert found.estimate.verdict.level == "do not use"
    assert code in codes(found.estimate.verdict.reasons)


@pytest.mark.parametrize(("speed", "doubted"), [(0.7, False), (3.0, True)])
def test_fast_motion_is_in_doubt(speed, doubted):
    """Accelerations are as the square of the speed."""
    wielding = wield_analytically(
        UR5, sinusoids(10.0, 100.0, speed), correct(0).truth, STANDARD_GRAVITY
    )
    recording = record(wielding, Faults(wrench_noise=WRENCH_NOISE["low"]), Rates(), 1)
    found = identify(without_positions(recording))
    reasons = codes(found.estimate.verdict.reasons)
    assert reasons == ({"accelerations-unmodelled"} if doubted else set())


def test_rests_serve_alone():
    """Of a stop-and-go motion the moves tell nothing but noise: the mass of these three
    is known to 1 %."""
    for seed in (5, 23, 41):
        given = correct(seed)
        found = identify(without_positions(given.recording)).estimate
        assert not found.verdict.reasons
        low, high = found.intervals["mass"]
        assert low < given.truth.mass < high
        assert high - low < 0.02 * given.truth.mass


def test_about_one_axis_gravity_has_two_directions_and_rests_serve_all_the_same():
    """The third variance is rounding, which must not decide."""
    K = 200
    turned = np.repeat(np.linspace(0.0, 2.0, 10), K // 10)
    gravity = 9.8 * np.stack((np.sin(turned), np.cos(turned), np.zeros(K)), axis=1)
    rng = np.random.default_rng(3)
    motion = SimpleNamespace(
        angular_velocity=np.zeros((K, 3)), angular_acceleration=np.zeros((K, 3))
    )
    motion.angular_velocity[::4] = 5.0
    z = Measurements(
        time=0.01 * np.arange(K),
        linear_acceleration=np.zeros((K, 3)),
        angular_velocity=np.zeros((K, 3)),
        angular_acceleration=np.zeros((K, 3)),
        gravity=gravity @ Rotation.random(random_state=1).as_matrix(),
        force=rng.normal(size=(K, 3)),
        torque=rng.normal(size=(K, 3)),
    )
    found = SimpleNamespace(parameters=np.array([1.0]))
    weights = weights_at_rest(motion, z, found)
    assert (weights[::4] == 0.0).all()
    assert (weights > 0.9).sum() == K - K // 4
    found.parameters[0] = 0.0  # nothing is held: nothing accelerates
    still = replace(z, force=np.zeros((K, 3)))
    assert (weights_at_rest(motion, still, found) == 1.0).all()

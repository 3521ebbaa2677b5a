"""Gravity's size is not known better than where a recording was made: what that does to
an estimate."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH, WORLD_STD, Gravity, GravityLike
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import full_regressor
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.identification import calibrate, identify
from hefting.ingest.ingest import ingest
from hefting.simulation import UR5, hammer, random_smooth, simulate

SIZE = 9.80665


def static(seed: int, noise: float = 1e-5) -> Recording:
    """Thirty poses in all orientations; hardly any noise."""
    rng = np.random.default_rng(seed)
    attitude, body = Rotation.random(30, rng=rng), hammer().parameters
    force = -body.mass * attitude.inv().apply(STANDARD_GRAVITY)
    wrench = np.hstack((force, np.cross(body.center_of_mass, force)))
    wrench += noise * rng.normal(size=wrench.shape)
    rows = np.arange(30)
    return Recording(
        {
            "orientation": Stream(rows.astype(float), attitude.as_quat(), rows),
            "wrench": Stream(rows.astype(float), wrench, rows),
        },
        static=True,
        source="poses",
    )


def moving(seed: int, speed: float = 2.5) -> Recording:
    motion = UR5.motion(random_smooth(3.0, 50.0, speed, seed=seed))
    return simulate(
        motion, hammer().parameters, noise=Noise(0.05, 0.0025), seed=seed, exact=True
    )


def identified(
    recording: Recording, gravity: GravityLike = ON_EARTH, method: str = "OLS"
) -> Estimate:
    return identify(
        recording,
        method=method,
        gravity=gravity,
        bias="none",
        sensor_accuracy="0%",
    ).estimate


def width(estimate: Estimate, name: str = "mass") -> Array:
    assert estimate.intervals is not None
    return np.ptp(estimate.intervals[name], axis=0)


@pytest.mark.parametrize("method", ["OLS", "LMI", "Bayes"])
def test_of_static_poses_the_mass_is_as_unsure_as_gravity_and_the_com_is_not(method):
    """m = |f| / g: its relative deviation is that of g, all else being exact."""
    recording = static(1)
    found = identified(recording, method=method)
    given = identified(recording, STANDARD_GRAVITY, method)
    np.testing.assert_allclose(
        found.parameters.vector[:4], given.parameters.vector[:4], rtol=1e-4
    )
    expected = 2.0 * 1.96 * WORLD_STD / SIZE * found.parameters.mass
    # of the second order in the noise, and the prior's skewness
    assert width(found) == pytest.approx(np.hypot(expected, width(given)), rel=0.01)
    assert width(given) < 0.05 * expected
    np.testing.assert_allclose(
        width(found, "center_of_mass"), width(given, "center_of_mass"), rtol=0.1
    )


@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_what_gravity_s_size_does_to_all_ten_parameters(bias):
    """Against another gravity in each sample itself, and another solver."""
    prepared = ingest(moving(2), bias=bias)
    z, step = prepared.measurements, 1e-4
    W = np.repeat((1.0 / prepared.fit.noise.force, 1.0 / prepared.fit.noise.torque), 3)

    def fitted(factor: float) -> Array:
        other = replace(z, gravity=factor * z.gravity, weights=None)
        A, b = full_regressor(other), other.wrench
        if bias == "estimate":
            A, b = A - A.mean(axis=0), b - b.mean(axis=0)
        rows, right = (W[:, None] * A).reshape(-1, 10), (W * b).ravel()
        return np.array(np.linalg.lstsq(rows, right, rcond=None)[0], dtype=float)

    slope = (fitted(1.0 + step) - fitted(1.0 - step)) / (2.0 * step)
    assert prepared.gravity_error is not None
    scale = np.sqrt(prepared.fit.covariance.diagonal()[:10])
    # of a thousandth of gravity, to the first order
    np.testing.assert_allclose(
        prepared.gravity_error / scale, WORLD_STD / SIZE * slope / scale, atol=0.02
    )
    mass = prepared.fit.vector[0]
    # the mass is partly what bears gravity, and partly what is accelerated
    assert -mass < slope[0] < -0.2 * mass
    assert prepared.common_errors is not None
    least = np.linalg.eigvalsh(
        prepared.common_errors
        - np.outer(prepared.gravity_error, prepared.gravity_error)
    ).min()
    assert least > -1e-12


def test_the_more_is_said_of_the_place_the_less_it_matters():
    recording = static(3)
    there = Gravity((0.0, 0.0, -SIZE), std=Gravity.at(45.0, 0.0).std)
    widths = [
        width(identified(recording, gravity))
        for gravity in (STANDARD_GRAVITY, there, Gravity.at(45.0), ON_EARTH)
    ]
    assert sorted(widths) == widths
    assert widths[3] > 5.0 * widths[2]
    assert widths[3] > 20.0 * widths[0]


def test_a_gravity_that_is_given_is_exact():
    recording = moving(4)
    for gravity in (STANDARD_GRAVITY, (0.0, 0.0, -9.81)):
        prepared = ingest(recording, gravity=gravity, bias="none")
        assert prepared.gravity_error is None
        assert prepared.provenance["gravity_std"] == 0.0
    found = ingest(recording, gravity="estimate", bias="none")
    assert found.gravity_error is not None
    assert found.provenance["gravity_std"] == WORLD_STD


def test_an_object_is_as_much_lighter_as_gravity_is_larger():
    recording = static(5)
    light, heavy = (
        identified(recording, Gravity.at(latitude)).parameters
        for latitude in (90.0, 0.0)
    )
    ratio = Gravity.at(90.0).vector[2] / Gravity.at(0.0).vector[2]
    assert heavy.mass / light.mass == pytest.approx(ratio, rel=1e-6)
    np.testing.assert_allclose(heavy.center_of_mass, light.center_of_mass, atol=1e-6)


def test_intervals_hold_in_all_the_world():
    """Thirty places of the spread that is assumed: 95 % of the intervals of a sensor
    without errors, 25 of 30 at the least (1 in 300)."""
    held = 0
    for seed in range(30):
        g = np.random.default_rng([8, seed]).normal(SIZE, WORLD_STD)
        recording = static(seed, noise=1e-4)
        wrench = recording["wrench"]
        there = replace(wrench, values=wrench.values * g / SIZE)
        streams = {**recording.streams, "wrench": there}
        found = identified(replace(recording, streams=streams))
        low, high = found.intervals["mass"]  # type: ignore[index]
        held += bool(low <= hammer().parameters.mass <= high)
    assert held >= 25


def test_a_tool_is_as_unsure_as_its_sensor_and_its_gravity():
    recording = moving(6, speed=0.5)
    variances = [
        calibrate(recording, gravity=gravity, sensor_accuracy=text).covariance[0, 0]  # type: ignore[index]
        for gravity, text in (
            (STANDARD_GRAVITY, "0%"),
            (ON_EARTH, "0%"),
            (ON_EARTH, "0.5%"),
            (ON_EARTH, "2%"),
        )
    ]
    assert sorted(variances) == variances
    mass = hammer().parameters.mass
    added = (WORLD_STD / SIZE * mass) ** 2
    # slow: the mass is what bears gravity
    assert variances[1] - variances[0] == pytest.approx(added, rel=0.3)
    # gain, of a channel by itself too, and slow errors that are twice as large and in
    # so slow a recording look like weight
    gain = (0.02 / 1.96 * mass) ** 2
    assert gain < variances[3] - variances[1] < (1.5 + 4.0) * gain

"""Ingest: what is understood of a recording, and what estimators are given of it."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import GRAVITY, NOISE, body, disturbed, undisturbed, with_wrench
from hefting.core.errors import InputError
from hefting.core.messages import error
from hefting.identification import calibrate, identify
from hefting.ingest.free_fit import fit_freely
from hefting.ingest.ingest import ingest
from hefting.ingest.tool import without_tool
from hefting.motion import measure, sample_weights
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, random_smooth, simulate, wield

pytestmark = pytest.mark.usefixtures("same_recordings")

BIAS = np.array((2.0, -1.0, 3.0, 0.1, 0.05, -0.2))


@pytest.fixture(scope="module")
def clean():
    return disturbed("clean", 1.5, 0, duration=4.0).recording


def biased(recording, bias=BIAS):
    wrench = recording["wrench"]
    return with_wrench(recording, wrench.time, wrench.values + bias)


def test_weights_are_by_the_motion_s_errors_and_one_on_average(clean):
    found = ingest(clean)
    weights = found.measurements.weights
    assert weights is not None
    assert weights.mean() == pytest.approx(1.0)
    motion = measure(found.conditioned.corrected(clean), GRAVITY).motion
    assert motion is not None
    noise = found.conditioned.noise
    expected = sample_weights(
        found.conditioned.parameters, motion, noise.force, noise.torque
    )
    np.testing.assert_allclose(weights, expected / expected.mean(), rtol=1e-6)
    assert np.ptp(weights) > 0.1


def test_a_time_in_milliseconds_is_said_once_and_first(clean):
    """As the reader found it, in place of what it imitates."""
    said = error("time-unit", "time seems to be in milliseconds")
    found = ingest(replace(clean, warnings=(said,)))
    assert found.doubt is not None
    assert found.doubt.makes_wrong
    assert [m for m in found.warnings if m.code == "time-unit"] == [said]
    assert found.warnings[0] == said


def test_the_error_of_the_motion_is_as_large_as_is_said():
    """Of both accelerations, pooled over five recordings of 10 s. Errors last for 0.15
    s, so that their size is known to some tenth; a quarter is allowed."""
    said, found = [], []
    for seed in range(5):
        given = disturbed("clean", 1.5, seed)
        exact = wield(undisturbed(1.5, seed, 10.4)[0], body(1.5))
        understood = ingest(given.recording)
        told, z = understood.motion_noise, understood.measurements
        at = np.searchsorted(exact.time, z.time - 1e-6)
        np.testing.assert_allclose(exact.time[at], z.time, atol=1e-6)
        assert told is not None
        said.append((told.linear, told.angular))
        errors = (
            z.linear_acceleration - exact.linear_acceleration[at],
            z.angular_acceleration - exact.angular_acceleration[at],
        )
        found.append([np.sqrt(np.mean(np.square(error))) for error in errors])
    ratio = np.sqrt(
        np.mean(np.square(said), axis=0) / np.mean(np.square(found), axis=0)
    )
    np.testing.assert_allclose(ratio, 1.0, atol=0.25)


def test_a_bias_is_kept_where_it_counts(clean):
    without, beside = ingest(clean), ingest(biased(clean))
    assert without.bias == "none"
    assert without.fit.bias is None
    assert beside.bias == "estimate"
    np.testing.assert_allclose(beside.fit.bias, BIAS, atol=0.05)
    given = ingest(biased(clean), bias=BIAS)
    assert given.bias == "none"
    # rounding
    np.testing.assert_allclose(
        given.measurements.wrench, without.measurements.wrench, atol=1e-12
    )


def test_what_is_left_of_the_wrench_is_without_the_bias(clean):
    """The noise, whatever the bias: that of OLS is known to two hundredths by four
    hundred samples."""
    for bias in ("estimate", BIAS):
        estimate = identify(biased(clean), method="OLS", bias=bias).estimate
        assert estimate.residual[0] == pytest.approx(NOISE.force, rel=0.1)
        assert estimate.residual[1] == pytest.approx(NOISE.torque, rel=0.1)


def test_a_drift_is_removed_unless_the_bias_is_given():
    drifting = disturbed("drift", 1.5, 0).recording
    free, known = ingest(drifting), ingest(drifting, bias="none")
    assert free.conditioned.bias.kind == "linear"
    change = free.measurements.wrench - known.measurements.wrench
    expected = free.conditioned.bias.change(free.measurements.time)
    # either sign; one offset or another
    np.testing.assert_allclose(np.abs(change), np.abs(expected), atol=0.02)


def test_the_tool_is_in_the_spread(clean):
    tool = calibrate(disturbed("clean", 0.3, 1, duration=4.0).recording)
    assert tool.covariance is not None
    alone, beside = ingest(clean), ingest(clean, tool=tool)
    own = fit_freely(
        without_tool(alone.measurements, tool), False, alone.fit.inflation
    ).covariance
    np.testing.assert_allclose(beside.fit.covariance, own + tool.covariance, rtol=1e-9)


def test_a_shape_no_robot_holds(clean):
    with pytest.raises(InputError, match="the shape is 200 m long; give it in metres"):
        identify(clean, Shape(200.0 * np.eye(3)))


def test_a_tilted_base_is_suspected_where_little_is_explained():
    """With gravity 15° off a quarter of the force is left over; where contact is to
    blame, gravity is not."""
    motion = UR5.motion(random_smooth(10.0, 100.0, 1.0, seed=3))
    gravity = 9.80665 * np.array(
        [np.sin(np.radians(15.0)), 0.0, -np.cos(np.radians(15.0))]
    )
    tilted = simulate(motion, hammer().parameters, gravity, noise=NOISE, seed=3)
    said = [line for line in ingest(tilted).warnings if line.code == "base-tilted"]
    assert len(said) == 1
    angle = float(str(said[0]).split("m/s², ")[1].split("°")[0])
    # 32 such angles are off by 0.11° (root mean square)
    assert angle == pytest.approx(15.0, abs=0.3)
    assert not any(
        "tilted" in line for line in ingest(tilted, gravity=gravity).warnings
    )
    assert not any(
        "tilted" in line for line in ingest(tilted, gravity="estimate").warnings
    )
    touched = disturbed("contact", 1.5, 1).recording
    found = ingest(touched)
    assert found.conditioned.rejected.mean() > 0.1
    assert not any("tilted" in line for line in found.warnings)

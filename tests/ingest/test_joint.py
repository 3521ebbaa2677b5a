"""Recordings taken together: twice the same is as one, known twice as well."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import disturbed, with_wrench
from hefting.core.measurements import MotionNoise, Noise
from hefting.core.messages import error, warning
from hefting.core.regressor import ONE
from hefting.ingest.ingest import ingest
from hefting.ingest.joint import (
    _concatenated,
    _mean_noise,
    _merged_messages,
    _weighed,
    ingest_all,
    names_of,
    together,
)
from hefting.ingest.rivals.consequence import Doubt
from hefting.ingest.systematic import common_errors


@pytest.fixture(scope="module")
def recording():
    return disturbed("tilt", 1.5, 0, duration=4.0).recording


@pytest.fixture(scope="module")
def one(recording):
    return ingest(recording, gravity="estimate")


@pytest.fixture(scope="module")
def twice(recording):
    return ingest_all(
        [recording, replace(recording, source="again")], gravity="estimate"
    )


def test_measurements_are_counted_once_for_each_recording(one, twice):
    assert one.duration == pytest.approx(4.0, abs=0.2)  # ends are left out
    assert twice.duration == pytest.approx(2.0 * one.duration)
    assert twice.rows == 2 * one.rows
    assert twice.samples == pytest.approx(2.0 * one.samples)
    np.testing.assert_allclose(twice.wrench_rms, one.wrench_rms, rtol=1e-9)
    for name in ("force", "torque"):
        expected = getattr(one.noise, name)
        assert getattr(twice.noise, name) == pytest.approx(expected, rel=1e-9)


def test_a_recording_of_more_noise_counts_less(recording):
    """By the variance; samples count one on average."""
    wrench, rng = recording["wrench"], np.random.default_rng(4)
    noise = 10.0 * np.repeat((0.1, 0.005), 3) * rng.normal(size=wrench.values.shape)
    loud = with_wrench(recording, wrench.time, wrench.values + noise)
    parts = [
        ingest(each, gravity="estimate", bias="none") for each in (recording, loud)
    ]
    quiet, weak = _weighed(parts)
    variance = [part.fit.noise.force**2 for part in parts]
    ratio = (
        quiet.state.full.factor[:, ONE]
        @ quiet.state.full.factor[:, ONE]
        / (weak.state.full.factor[:, ONE] @ weak.state.full.factor[:, ONE])
    )
    # of force and torque together, which differ alike, by fits of their own
    assert ratio == pytest.approx(variance[1] / variance[0], rel=0.2)
    assert _weighed([parts[0], parts[0]]) == [parts[0], parts[0]]


def test_errors_of_both_recordings_do_not_average(one, twice):
    """Of two alike each moves the answer by half its error: gravity's size stays as
    wrong as it is."""
    assert one.gravity_error is not None
    _, size = common_errors(twice.parts, twice.fit.noise, None)
    np.testing.assert_allclose(
        size, one.gravity_error, atol=1e-6 * np.abs(one.gravity_error).max()
    )


def test_recordings_are_called_by_what_tells_them_apart():
    assert names_of(["a/x.csv", "a/y.csv"]) == ["x.csv", "y.csv"]
    assert names_of(["a/x.csv", "b/x.csv"]) == ["a/x.csv", "b/x.csv"]
    assert names_of(["/", "x.csv"]) == ["/", "x.csv"]
    assert names_of(["x.csv", "x.csv"]) == ["x.csv (1)", "x.csv (2)"]


def with_noise(part, force, torque):
    """With other levels of noise told of it, and of the fit."""
    noise = Noise(force, torque)
    return replace(part, noise=noise, fit=replace(part.fit, noise=noise))


def test_recordings_are_weighed_from_variances_half_as_large_again(one):
    """The mean of those of force and torque, each over what they are on average;
    weights are one on average, and at most a hundred times another."""
    quiet = with_noise(one, 1.0, 0.1)
    for ratio, weighed in ((1.49, False), (1.51, True), (10.0, True), (1e6, True)):
        loud = with_noise(one, ratio**0.5, 0.1 * ratio**0.5)
        parts = _weighed([quiet, loud])
        assert (parts[0] is not quiet) == weighed
        if weighed:
            own = [float(p.state.full.ones @ p.state.full.ones) for p in parts]
            before = float(one.state.full.ones @ one.state.full.ones)
            weights = np.array(own) / before
            assert weights.mean() == pytest.approx(1.0)
            # a hundredth of what they are on average: here about half of the larger
            most = ratio if ratio < 100.0 else 200.0
            assert weights[0] / weights[1] == pytest.approx(most, rel=1e-3)
    # force and torque differ the other way round: neither is better
    parts = [with_noise(one, 3.0, 0.1), with_noise(one, 1.0, 0.3)]
    assert _weighed(parts) == parts


def test_what_is_told_of_all_is_by_the_samples_of_each(one):
    """Of noise and what is within averages; the sign is that of the least certain, the
    doubt that which is fatal, the motion that of most rows."""
    parts = [
        replace(
            with_noise(one, 1.0, 0.1), within=np.eye(6), bias_found=not one.bias_found
        ),
        replace(with_noise(one, 2.0, 0.5), within=3.0 * np.eye(6)),
    ]
    parts[0] = replace(parts[0], sign=replace(one.sign, t=-20.0), static=True)
    mild, fatal = (Doubt(say("x", "is so"), False) for say in (warning, error))
    for order in ((mild, fatal), (fatal, mild), (None, fatal)):
        doubtful = [replace(p, doubt=d) for p, d in zip(parts, order, strict=True)]
        assert together(doubtful, ["a", "b"]).doubt is fatal
    found = together(parts, ["a", "b"])
    assert found.noise.force == pytest.approx(2.5**0.5)
    assert found.noise.torque == pytest.approx(0.13**0.5)
    np.testing.assert_allclose(found.within, 2.0 * np.eye(6))
    assert found.sign.t == -20.0
    assert not found.static
    assert found.bias_found is not one.bias_found
    assert found.sign_found is parts[0].sign_found
    assert found.log == "a, b"
    assert together([parts[0]], ["a"]) is parts[0]
    assert together(parts * 2, list("abcd")).log == "a and 3 more"


def test_samples_of_all_stand_one_after_the_other_with_a_pause(one):
    """Of a second; each counts as in its own recording, or once."""
    z = one.measurements
    plain = replace(z, weights=None)
    joined = _concatenated([z, plain, z])
    K = len(z)
    np.testing.assert_allclose(joined.time[:K], z.time - z.time[0], atol=1e-12)
    assert joined.time[K] - joined.time[K - 1] == pytest.approx(1.0)
    assert joined.time[2 * K] - joined.time[2 * K - 1] == pytest.approx(1.0)
    np.testing.assert_allclose(np.diff(joined.time[2 * K :]), np.diff(z.time))
    assert (joined.weights[K : 2 * K] == 1.0).all()
    for name in ("gravity", "linear_acceleration", "angular_velocity", "force"):
        np.testing.assert_array_equal(getattr(joined, name)[2 * K :], getattr(z, name))
    two = [MotionNoise(3.0, 0.5, 0.1), MotionNoise(4.0, 1.2, 0.3)]
    mean = _mean_noise(two)
    assert mean is not None
    assert (mean.linear, mean.angular) == pytest.approx((12.5**0.5, 0.845**0.5))
    assert mean.memory == pytest.approx(0.2)
    assert _mean_noise([*two, None]) is None


def test_messages_name_the_recordings_unless_they_are_about_all():
    same, other = warning("a", "is so"), warning("b", "is not")
    told = _merged_messages([[same, other], [same], [other, same]], ["x", "y", "z"])
    assert told[0] is same
    assert "x" in told[1]
    assert "z" in told[1]
    assert "y" not in told[1]
    assert len(told) == 2

"""Recordings taken together: twice the same is as one, known twice as well."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import disturbed, with_wrench
from hefting.core.regressor import ONE
from hefting.ingest.ingest import ingest
from hefting.ingest.joint import _weighed
from hefting.ingest.several import ingest_all, names_of
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


def test_errors_of_each_recording_average_and_errors_of_both_do_not(one, twice):
    """Of two alike each moves the answer by half its error: what each has of its own is
    halved in variance, gravity's size stays as wrong as it is."""
    C = one.covariance_with_gravity
    assert C is not None
    np.testing.assert_allclose(
        twice.covariance_with_gravity / np.sqrt(np.outer(C.diagonal(), C.diagonal())),
        0.5 * C / np.sqrt(np.outer(C.diagonal(), C.diagonal())),
        atol=1e-6,
    )
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

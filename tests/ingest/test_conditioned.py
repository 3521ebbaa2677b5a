"""What conditioning found, taken out of the recording."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import disturbed
from hefting.core.recording import Recording, Stream
from hefting.ingest import condition
from hefting.ingest.conditioned import WrenchSign, mass_over_std
from hefting.ingest.drift import Drift


@pytest.fixture(scope="module")
def recording():
    return disturbed("clean", 1.0, 0, duration=2.0).recording


@pytest.fixture(scope="module")
def found(recording):
    found = condition(recording, clock=False, changes=False)
    return replace(found, rejected=np.zeros_like(found.rejected), offset=0.0)


def drifting(found, recording):
    """With a bias of 1 to 3 N along all axes from start to end."""
    knots = np.array((recording.start, recording.start + 2.0))
    values = np.array((1.0, 3.0))[:, None] * np.ones(6)
    bias = Drift(knots, values, np.zeros((2, 6)), np.full(6, 1.5))
    return replace(found, bias=bias)


def test_nothing_is_corrected_where_nothing_was_found(found, recording):
    assert found.bias.kind == "constant"
    assert found.corrected(recording) is recording
    assert drifting(found, recording).corrected(recording, drift=False) is recording


def test_a_late_wrench_is_earlier_and_nothing_else(found, recording):
    late = replace(found, offset=0.03).corrected(recording)
    wrench = recording["wrench"]
    np.testing.assert_array_equal(late["wrench"].time, wrench.time - 0.03)
    np.testing.assert_array_equal(late["wrench"].values, wrench.values)
    np.testing.assert_array_equal(late["wrench"].rows, wrench.rows)
    for name in set(recording.streams) - {"wrench"}:
        assert late[name] is recording[name]


@pytest.mark.parametrize("drift", [True, False])
def test_what_drifts_is_removed_and_the_mean_bias_stays(found, recording, drift):
    """Where it is asked for; with what was rejected, and without a delay."""
    wrench = recording["wrench"]
    rejected = np.arange(len(wrench.time)) % 3 == 1
    given = replace(drifting(found, recording), rejected=rejected)
    corrected = given.corrected(recording, drift)["wrench"]
    since = wrench.time - recording.start
    left = wrench.values - drift * (np.clip(1.0 + since, 1.0, 3.0) - 1.5)[:, None]
    np.testing.assert_array_equal(corrected.time, wrench.time[~rejected])
    np.testing.assert_allclose(corrected.values, left[~rejected], atol=1e-12)
    np.testing.assert_array_equal(corrected.rows, wrench.rows[~rejected])
    # where all were rejected, all are kept
    given = replace(given, rejected=np.ones_like(rejected))
    assert len(given.corrected(recording, drift)["wrench"]) == len(wrench)


def test_a_static_pose_is_left_out_with_its_wrench(found, recording):
    streams = {
        name: Stream(np.arange(20.0), s.values[:20])
        for name, s in recording.streams.items()
    }
    poses = Recording(streams, static=True)
    rejected = np.arange(20) % 4 == 2
    corrected = replace(found, rejected=rejected).corrected(poses)
    for name, stream in corrected.streams.items():
        np.testing.assert_array_equal(stream.values, poses[name].values[~rejected])
        np.testing.assert_array_equal(stream.time, np.flatnonzero(~rejected))


def test_a_sign_is_certain_from_ten_deviations_on():
    for t, certain in ((9.99, False), (10.0, True), (-9.99, False), (-10.0, True)):
        sign = WrenchSign(t > 0.0, t)
        assert sign.certain is certain
        assert sign.name == ("on-object" if t > 0.0 else "on-sensor")
    assert WrenchSign(True, -3.14).doubt == (
        "the mass is 3.1 standard deviations from zero, and 10 would tell"
    )


def test_a_mass_without_noise_is_finitely_many_deviations_from_zero():
    assert mass_over_std(-6.0, 2.0) == -3.0
    assert mass_over_std(-6.0, 0.0) == pytest.approx(-1e12)
    assert mass_over_std(0.0, 0.0) == 0.0
    assert mass_over_std(1.0, np.inf) == 0.0


def test_the_autocorrelation_is_that_of_the_known_parameters(found):
    """On average; one where none is known."""
    covariance = np.eye(10)
    covariance[3, 3] = covariance[9, 9] = np.inf
    inflation = np.append(np.arange(1.0, 11.0), np.full(6, 100.0))
    given = replace(found, covariance=covariance, inflation=inflation)
    assert given.autocorrelation == pytest.approx((55.0 - 4.0 - 10.0) / 8.0)
    open_ = replace(given, covariance=np.diag(np.full(10, np.inf)))
    assert open_.autocorrelation == 1.0
    np.testing.assert_array_equal(given.std**2, covariance.diagonal())

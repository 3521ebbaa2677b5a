"""Drift: its hat functions and knots, and what tells it from a constant bias."""

import numpy as np
import pytest

from conditioned import condition
from disturbances import disturbed, with_wrench
from hefting.ingest.drift import Drift, HatFunctions, candidates
from hefting.ingest.ingest import ingest

pytestmark = pytest.mark.usefixtures("same_poses")


@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_hats_are_what_interpolation_says(n):
    rng = np.random.default_rng(n)
    time = np.sort(rng.uniform(0.0, 30.0, 200))
    time = time[(time < 10.0) | (time > 16.0)]  # an interval may be empty
    hats = HatFunctions.over(time, n)
    values = rng.normal(size=(n, 2))
    dense = np.column_stack([np.interp(time, hats.knots, unit) for unit in np.eye(n)])
    rows, weights = rng.normal(size=(len(time), 3)), rng.random(len(time))
    for found, expected in (
        (hats.combine(values), dense @ values),
        (hats.project(rows), dense.T @ rows),
        (hats.gram(weights), dense.T @ (dense * weights[:, None])),
        (hats.part(slice(30, 120)).combine(values), (dense @ values)[30:120]),
    ):
        np.testing.assert_allclose(found, expected, atol=1e-12)  # rounding


def test_drift_between_and_beyond_its_knots():
    drift = Drift(
        np.array([1.0, 3.0]),
        np.array([np.zeros(6), np.full(6, 4.0)]),
        np.ones((2, 6)),
        np.full(6, 2.0),
    )
    np.testing.assert_allclose(drift(np.array([0.0, 2.0, 9.0]))[:, 0], (0.0, 2.0, 4.0))
    np.testing.assert_allclose(drift.change(np.array([2.5]))[0], 1.0)
    assert drift.kind == "linear"
    np.testing.assert_array_equal(drift.range, 4.0)


def test_numbers_of_knots_to_try():
    assert candidates(5.0, 0.0) == (1,)
    assert candidates(10.0, 0.0) == (1, 2)
    assert candidates(180.0, 0.0) == (1, 2, 3, 5, 9, 16)
    # of two at most, a bias as slow as can be leaves as many
    assert candidates(23.9, 0.0) == candidates(23.9, 1e6) == (1, 2)
    assert candidates(180.0, 60.0) == (1, 2, 3, 4)  # 180 s in three lines, no more
    for duration, numbers in (
        (7.8, (1,)),
        (7.995, (1, 2)),  # 8 s at 200 Hz
        (8.0, (1, 2)),
        (12.0, (1, 2)),
        (24.0, (1, 2, 3)),
        (36.0, (1, 2, 3, 4)),
    ):
        # of 12 s and more each, once the drift may bend
        assert candidates(duration, 0.0) == numbers
    assert candidates(48.0, 0.0) == (1, 2, 3, 5)
    assert candidates(1e5, 0.0) == (1, 2, 3, 5, 9, 17, 33, 65, 81)


def test_no_drift_is_no_drift():
    assert (
        condition(disturbed("clean", 1.5, 0, duration=30.0).recording).bias.kind
        == "constant"
    )


@pytest.mark.parametrize(("seconds", "kind"), [(7.8, "constant"), (7.99, "linear")])
def test_a_drift_takes_eight_seconds_to_tell(seconds, kind):
    recording = disturbed("drift", 1.5, 0, duration=seconds + 0.01).recording
    assert np.ptp(recording["wrench"].time) == pytest.approx(seconds)
    assert condition(recording).bias.kind == kind


def test_a_drift_that_is_too_short_to_be_removed_is_told():
    """A bias that drifts by 3 N in 5 s, in a line, or bending as that of a sensor that
    warms up; what swings at 1 Hz is not taken for it."""
    clean = disturbed("clean", 0.3, 0, duration=5.0).recording
    wrench = clean["wrench"]
    past = (wrench.time - wrench.time[0])[:, None]
    drift = past / 5.0 * (2.0, -1.5, 2.0, 0.1, 0.05, -0.1)
    warming = drift[-1] * (1.0 - np.exp(-past / 1.5))
    swinging = drift[-1] * np.sin(2.0 * np.pi * past)
    for added, told in ((drift, True), (warming, True), (swinging, False)):
        doubt = ingest(with_wrench(clean, wrench.time, wrench.values + added)).doubt
        assert doubt is not None
        assert (doubt.message.code == "drift-in-short") == told

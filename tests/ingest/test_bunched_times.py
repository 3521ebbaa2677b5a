"""Samples that arrived in bunches are given the times at which they were taken."""

from dataclasses import replace

import numpy as np
import pytest

from given_cases import correct
from hefting.core.messages import codes
from hefting.core.recording import Recording, Stream
from hefting.identification import identify
from hefting.ingest.mended_times import spread_bunches, with_mended_times

STEP = 0.002


def delayed(time, *stalls, apart=1e-4):
    """Times at which samples arrive that wait from the start to the end of each stall
    and then come one after the other."""
    late = np.array(time)
    for start, end in stalls:
        late[(late >= start) & (late < end)] = end
    for i in range(1, len(late)):
        late[i] = max(late[i], late[i - 1] + apart)
    return late


def test_the_samples_beside_a_bunch_may_be_late_themselves():
    time = STEP * np.arange(500)
    arrived = delayed(time, (0.4005, 0.4305))
    arrived[np.searchsorted(time, 0.4005) - 1] += 0.4 * STEP
    found, moved = spread_bunches(arrived)
    assert moved.sum() > 10
    assert np.abs(found - time).max() < 0.5 * STEP


@pytest.mark.parametrize(
    "stalls",
    [((0.4005, 0.4305),), ((0.2011, 0.2071),), ((0.3003, 0.3203), (0.3101, 0.3391))],
    ids=["long", "of three", "two in a row"],
)
def test_bunches_are_spread_over_the_pause_before_them(stalls):
    time = STEP * np.arange(500)
    arrived = delayed(time, *stalls)
    assert np.abs(arrived - time).max() > STEP
    found, moved = spread_bunches(arrived)
    np.testing.assert_allclose(found, time, atol=1e-6)
    assert moved[np.abs(arrived - time) > 1e-5].all()


def test_other_times_stay_as_they_are():
    """With jitter, lost rows, a pause, pairs of samples, one of which was late, bunches
    without a pause or after one that is longer than they last, and three at a time
    throughout half of them."""
    rng, time = np.random.default_rng(1), STEP * np.arange(500)
    pairs = np.repeat(2.0 * time[:250], 2) + np.tile((0.0, 1e-5), 250)
    missing = np.delete(delayed(time, (0.4005, 0.4305)), [199, 200])
    late = 6e-3 * np.arange(1, 85)[:, None] - 1e-4 * np.arange(2, -1, -1)
    end = 0.2 + late[-1, -1]
    threes = np.concatenate((time[:101], 0.2 + late.ravel(), end + time[1:100]))
    crowded = np.insert(time, 250, time[249] + 1e-5 * np.arange(1, 9))
    for each in (
        time,
        time + 0.2 * STEP * rng.uniform(-1.0, 1.0, 500),
        np.delete(time, rng.integers(1, 499, 40)),
        time + 0.3 * (time > 0.5),
        pairs,
        delayed(time, (0.2011, 0.2051)),
        crowded,
        missing,
        threes,
        time[:3],
    ):
        found, moved = spread_bunches(each)
        assert found is each
        assert not moved.any()


def with_late_poses(recording: Recording, every: float) -> Recording:
    """Poses of twice the rate, whose queue stalls for 90 ms `every` so many seconds."""
    streams = dict(recording.streams)
    for name in ("position", "orientation"):
        stream = streams[name]
        stalls = [(t, t + 0.09) for t in np.arange(0.5, stream.time[-1] - 1.0, every)]
        streams[name] = replace(stream, time=delayed(stream.time, *stalls))
    return replace(recording, streams=streams)


def test_an_answer_is_that_of_the_right_times():
    """COMs of hand-guided recordings with such stalls had been up to 28 mm off, *good*."""
    right = correct(1).recording
    late = with_late_poses(right, 1.5)
    found, expected = (identify(each).estimate for each in (late, right))
    assert codes(found.warnings) == codes(expected.warnings)
    np.testing.assert_allclose(
        found.parameters.vector, expected.parameters.vector, rtol=1e-4, atol=1e-6
    )


def test_it_is_noted_of_how_many():
    right = correct(1).recording
    found = with_mended_times(with_late_poses(right, 3.0))
    (said,) = found.notes
    assert said.code == "times-bunched"
    assert said.severity == "note"
    assert "of 1000 times of the " in said
    assert found["wrench"].time is right["wrench"].time


def test_angles_keep_the_times_of_the_orientation():
    late = with_late_poses(correct(1).recording, 1.5)
    orientation = late["orientation"]
    angles = Stream(orientation.time, orientation.values[:, :3])
    found = with_mended_times(replace(late, angles=angles))
    assert found.angles is not None
    np.testing.assert_array_equal(found.angles.time, found["orientation"].time)

"""What is played: poses and wrench at each frame are those of the recording."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.regressor import predict_wrench
from hefting.ingest.ingest import ingest
from hefting.logs import read_log
from hefting.viewer import MOST_FRAMES, RATE, Playback, Settings
from recordings import DATA, needs_recordings
from viewing import recorded, viewed


def test_frames_have_the_poses_of_the_recording_at_their_time():
    _, playback, recording = viewed()
    poses = recording["position"]
    for index in (0, 37, len(playback) - 1):
        frame = playback[index]
        k = np.argmin(np.abs(poses.time - playback.instants[index]))
        np.testing.assert_array_equal(frame.position, poses.values[k])
        turned = recording["orientation"].values[k]
        np.testing.assert_array_equal(frame.orientation, turned)
        wrench = playback.found.measurements.wrench[frame.sample]
        np.testing.assert_array_equal(frame.measured, wrench)
    assert playback.times[0] == 0.0
    assert playback.instants[-1] == playback.found.measurements.time[-1]


def test_no_more_frames_than_a_page_can_hold():
    recording = recorded()
    found = ingest(recording)
    assert len(Playback(recording, found)) <= 2 + RATE * found.duration
    z = found.measurements
    slow = replace(found, measurements=replace(z, time=1e4 * z.time))
    many = Playback(recording, slow)
    assert len(many) == min(MOST_FRAMES, len(z))


def test_the_nearest_frame_and_the_predicted_wrench():
    session, playback, _ = viewed()
    assert playback.nearest(-5.0) == 0
    assert playback.nearest(float(playback.times[12]) + 1e-4) == 12
    estimate = session.answer(10.0, Settings("OLS")).estimate
    predicted = playback.predicted(estimate, 40)
    z = playback.found.measurements
    whole = predict_wrench(z, estimate.sensed_vector)
    # BLAS may add in another order for one row
    np.testing.assert_allclose(predicted, whole[40], rtol=1e-12, atol=1e-12)


@needs_recordings
@pytest.mark.parametrize("log", ["kuka-ati/static_poses", "axia80/dwells"])
def test_logs_without_time_or_position(log):
    recording = read_log(DATA / f"{log}.csv")
    playback = Playback(recording, ingest(recording))
    assert not playback[3].position.any()
    if playback.static:
        assert playback.times[0] >= 1.0
        numbers = playback.found.measurements.time + 1.0
        np.testing.assert_array_equal(playback.times, numbers[playback.samples])

"""Static poses that have times, as where a program logs one row a pose."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.messages import NO_DOUBT, codes
from hefting.core.recording import Recording, Stream
from hefting.logs.static_poses import without_times

ROWS = 12
RNG = np.random.default_rng(17)
TURNS = Rotation.random(ROWS, random_state=2)
POSE = np.hstack((RNG.uniform(-1.0, 1.0, (ROWS, 3)), TURNS.as_quat()))
WRENCH = RNG.normal(size=(ROWS, 6))
NAMES = ["px", "py", "pz", "qx", "qy", "qz", "qw", "fx", "fy", "fz", "tx", "ty", "tz"]
JOINTS = RNG.uniform(-2.0, 2.0, (ROWS, 6))


@pytest.mark.parametrize("name", ["time", "timestamp"])
@pytest.mark.parametrize("begin", [0.0, 1.7e9])
@pytest.mark.parametrize("step", [1.0, 2.5, 8.0, 30.0])
def test_rows_far_apart_are_static_poses(name, begin, step):
    """Of a time without a unit steps of 8 had been milliseconds, and the recording too
    short."""
    times = begin + step * (np.arange(ROWS) + RNG.uniform(-0.05, 0.05, ROWS))
    frame = pd.DataFrame(np.hstack((POSE, WRENCH)), columns=NAMES)
    got = hefting.as_recording(frame.assign(**{name: times}))
    assert got.static
    np.testing.assert_array_equal(got["wrench"].time, np.arange(ROWS))
    np.testing.assert_array_equal(got["position"].values, POSE[:, :3])
    assert "poses-static" in codes(got.warnings)
    doubts = codes(got.warnings) - NO_DOUBT
    assert doubts == ({"columns-doubtful"} if name != "time" and not begin else set())


def test_so_are_arrays_and_joint_angles():
    time = 8.0 * np.arange(ROWS)
    got = hefting.as_recording(time=time, pose=POSE, wrench=WRENCH)
    assert got.static
    got = hefting.as_recording(
        time=time, joint_positions=JOINTS, joint_velocities=0 * JOINTS, wrench=WRENCH
    )
    assert got.static
    assert not got.has("joint_velocities")


def test_what_moves_or_is_measured_between_poses_keeps_its_times():
    time = np.arange(float(ROWS))
    slow = Rotation.from_rotvec(0.3 * time[:, None] * (0.0, 0.0, 1.0)).as_quat()
    streams = {"orientation": Stream(time, slow), "wrench": Stream(time, WRENCH)}
    moving = Recording(streams)
    fast = Recording(
        {
            "orientation": Stream(0.1 * time, TURNS.as_quat()),
            "wrench": Stream(0.1 * time, WRENCH),
        }
    )
    between = Stream(np.linspace(0, 11, 50), RNG.normal(size=(50, 6)))
    apart = Recording({"orientation": Stream(time, TURNS.as_quat()), "wrench": between})
    for recording in (moving, fast, apart):
        assert without_times(recording) is recording

"""Static poses that have times, as where a program logs one row a pose."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import hefting
from hefting.core.messages import NO_DOUBT, codes
from hefting.core.recording import Recording, Stream
from hefting.logs.static_poses import without_times, without_unit

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


def test_rows_without_time_are_said_to_be_static_poses():
    got = hefting.as_recording(pd.DataFrame(np.hstack((POSE, WRENCH)), columns=NAMES))
    assert got.static
    assert got.warnings == ()
    (said,) = got.notes
    assert (said.code, said.severity) == ("no-time-column", "note")
    assert "each of 12 rows is taken as a static pose; of rows in motion give" in said


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


def swaying(rows, step, turn=1.5, period=300.0):
    """A recording of an arm that sways by `turn` [rad], `rows` rows at `step` [s]."""
    count = np.arange(float(rows))
    angles = np.outer(turn * np.sin(2 * np.pi * count / period), (0.6, 0.0, 0.8))
    quaternions = Rotation.from_rotvec(angles).as_quat()
    wrench = RNG.normal(size=(rows, 6))
    time = step * count
    return Recording(
        {"orientation": Stream(time, quaternions), "wrench": Stream(time, wrench)}
    )


@pytest.mark.parametrize("step", [4.0, 8.0, 20.0])
def test_an_arm_that_sways_for_hours_is_in_milliseconds(step):
    """Of 1200 rows at 4 ms it takes 1.2 s for each period, or 20 minutes of seconds."""
    got = without_unit(swaying(1200, step))
    [said] = [m for m in got.warnings if m.code == "time-unit"]
    assert said.severity == "error"
    assert "milliseconds" in said
    assert not got.static


@pytest.mark.parametrize(
    ("rows", "step", "change"),
    [
        (1200, 1.0, {}),  # once a second
        (300, 4.0, {}),  # may be poses that differ little
        (1200, 4.0, {"turn": 0.1}),  # creep
        (1200, 2.0, {"turn": 3.0}),  # some degrees a second, as arms are moved slowly
        (1200, 8.0, {"period": 2.3}),  # poses at random
    ],
)
def test_slow_logs_are_in_seconds(rows, step, change):
    got = without_unit(swaying(rows, step, **change))
    assert "time-unit" not in codes(got.warnings)


def test_uneven_rows_are_in_seconds():
    moving = swaying(1200, 8.0)
    time = np.sort(RNG.uniform(0.0, 9600.0, 1200))
    apart = {n: Stream(time, s.values) for n, s in moving.streams.items()}
    assert "time-unit" not in codes(without_unit(Recording(apart)).warnings)


def test_a_stated_unit_is_believed(tmp_path):
    """Arrays and canonical columns state none; a column map does."""
    moving = swaying(1200, 4.0)
    turns, wrench = moving["orientation"].values, moving["wrench"].values
    frame = pd.DataFrame(np.hstack((turns, wrench)), columns=NAMES[3:])
    frame.insert(0, "time", moving["wrench"].time)
    frame.to_csv(tmp_path / "log.csv", index=False)
    told = hefting.read_log(tmp_path / "log.csv")
    assert "time-unit" in codes(told.warnings)
    arrays = hefting.as_recording(
        time=frame["time"].to_numpy(), orientation=turns, wrench=wrench
    )
    assert "time-unit" in codes(arrays.warnings)
    lines = [
        'time = { column = "time", unit = "s" }',
        'orientation = ["qx", "qy", "qz", "qw"]',
        'wrench = ["fx", "fy", "fz", "tx", "ty", "tz"]',
    ]
    (tmp_path / "map.toml").write_text("\n".join(lines))
    got = hefting.read_log(tmp_path / "log.csv", tmp_path / "map.toml")
    assert "time-unit" not in codes(got.warnings)

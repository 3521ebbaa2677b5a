"""Arrays in memory become the recording that a log of the same numbers is; what cannot
be one is refused in one line."""

from datetime import UTC, timedelta, timezone

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

import hefting
from hefting.core.errors import InputError
from hefting.logs.given import as_recording

COUNT = 40
TIME = 0.1 * np.arange(COUNT)
TURNS = Rotation.random(COUNT, random_state=3)
QUATERNIONS = TURNS.as_quat()
POSITION = np.random.default_rng(4).normal(size=(COUNT, 3))
WRENCH = np.random.default_rng(5).normal(size=(COUNT, 6))
MATRICES = np.tile(np.eye(4), (COUNT, 1, 1))
MATRICES[:, :3, :3], MATRICES[:, :3, 3] = TURNS.as_matrix(), POSITION


def angle(orientation) -> float:
    """Largest angle [rad] to the rotations that were given."""
    return float((TURNS.inv() * Rotation.from_quat(orientation)).magnitude().max())


@pytest.mark.parametrize(
    "poses",
    [
        {"position": POSITION, "orientation": QUATERNIONS},
        {"position": POSITION, "orientation": TURNS},
        {"position": POSITION, "orientation": TURNS.as_matrix()},
        {"position": POSITION.tolist(), "orientation": (-QUATERNIONS).tolist()},
        {"pose": MATRICES},
        {"pose": np.hstack((POSITION, QUATERNIONS))},
        {"position": POSITION, "orientation": list(TURNS)},
        {"pose": RigidTransform.from_matrix(MATRICES)},
    ],
    ids=[
        "quaternions",
        "Rotation",
        "matrices",
        "lists",
        "poses",
        "seven",
        "Rotations",
        "RigidTransform",
    ],
)
def test_every_form_of_a_pose_is_the_same(poses):
    recording = as_recording(time=TIME, wrench=WRENCH, **poses)
    assert not recording.static
    assert recording.warnings == ()
    np.testing.assert_array_equal(recording["position"].values, POSITION)
    np.testing.assert_array_equal(recording["wrench"].values, WRENCH)
    np.testing.assert_array_equal(recording["wrench"].time, TIME)
    assert angle(recording["orientation"].values) < 1e-7  # of arccos near 1


@pytest.mark.parametrize("static", [False, True])
def test_samples_of_a_dictionary_that_hold_nan_were_not_measured(static):
    """As in a table; a static pose that lacks one of its streams is none."""
    wrench, pose = WRENCH.copy(), MATRICES.copy()
    wrench[3, 5] = pose[7] = np.nan
    masked = np.ma.masked_invalid(wrench)
    for given in (wrench, masked):
        arrays = {"pose": pose, "wrench": given} | ({} if static else {"time": TIME})
        recording = as_recording(arrays)
        left = {"wrench": {3}, "position": {7}, "orientation": {7}}
        for name, rows in left.items():
            rows = {3, 7} if static else rows
            assert {*range(COUNT)} - {*recording[name].rows} == rows
        kept = recording["wrench"]
        np.testing.assert_array_equal(kept.values, WRENCH[kept.rows])
    with pytest.raises(InputError, match="is nan"):
        as_recording(orientation=TURNS, wrench=masked)


def test_a_wrench_may_have_times_of_its_own():
    recording = as_recording(
        time=TIME, pose=MATRICES, wrench=WRENCH[:7], wrench_time=TIME[:7] + 0.03
    )
    np.testing.assert_array_equal(recording["wrench"].time, TIME[:7] + 0.03)
    np.testing.assert_array_equal(recording["orientation"].time, TIME)


def test_force_and_torque_are_a_wrench():
    halves = {"force": WRENCH[:, :3], "torque": WRENCH[:, 3:]}
    recording = as_recording(time=TIME, pose=MATRICES, **halves)
    np.testing.assert_array_equal(recording["wrench"].values, WRENCH)


def test_without_time_each_sample_is_a_static_pose():
    recording = as_recording(orientation=TURNS, wrench=WRENCH)
    assert recording.static
    assert not recording.has("position")


def test_dates_count_from_the_first_of_all_and_durations_are_seconds():
    dates = np.datetime64("2024-05-01T12:00:00") + (1e9 * TIME).astype("m8[ns]")
    later = dates - np.timedelta64(50, "ms")
    recording = as_recording(
        time=dates, pose=MATRICES, wrench=WRENCH, wrench_time=later
    )
    np.testing.assert_allclose(recording["wrench"].time, TIME, atol=1e-9)
    np.testing.assert_allclose(recording["position"].time, TIME + 0.05, atol=1e-9)
    for zone in (None, UTC, timezone(timedelta(hours=2))):
        of_python = [
            date.replace(tzinfo=zone) for date in dates.astype("M8[us]").tolist()
        ]
        listed = as_recording(time=of_python, pose=MATRICES, wrench=WRENCH)
        # dates of Python count microseconds
        np.testing.assert_allclose(listed["wrench"].time, TIME, atol=1e-6)
    lasted = as_recording(time=dates - dates[0], pose=MATRICES, wrench=WRENCH)
    np.testing.assert_allclose(lasted["wrench"].time, TIME, atol=1e-9)


def test_times_since_1970_start_at_zero_for_all_streams_alike():
    recording = as_recording(
        time=TIME + 1.7e9, pose=MATRICES, wrench=WRENCH, wrench_time=TIME + 1.7e9 + 1
    )
    assert [m.code for m in recording.warnings] == ["time-shifted"]
    assert recording["position"].time[0] == 0.0
    assert recording["wrench"].time[0] == pytest.approx(1.0, abs=1e-6)


def test_other_streams_and_repeated_samples():
    again = np.r_[0, np.arange(COUNT)]
    recording = as_recording(
        time=TIME[again],
        pose=MATRICES[again],
        wrench=WRENCH[again],
        gyroscope=POSITION[again],
    )
    assert len(recording["gyroscope"]) == COUNT
    assert [m.code for m in recording.warnings] == ["rows-repeated"]


def test_what_is_given_is_copied():
    wrench = WRENCH.copy()
    recording = as_recording(time=TIME, pose=MATRICES, wrench=wrench)
    wrench[:] = 0.0
    np.testing.assert_array_equal(recording["wrench"].values, WRENCH)


def with_value(array, index, value):
    changed = array.copy()
    changed[index] = value
    return changed


GOOD = {"time": TIME, "orientation": QUATERNIONS, "wrench": WRENCH}


class NeedsGradient:
    """An array of torch that belongs to a computation."""

    def __array__(self, dtype=None, copy=None):
        raise RuntimeError("Can't call numpy() on Tensor that requires grad")


BAD = {
    "a tensor that requires grad": (
        {"wrench": NeedsGradient()},
        r"wrench is not an array of numbers \(Can't call numpy\(\) on Tensor",
    ),
    "nothing": (dict.fromkeys(GOOD), "no recording is given; give the path"),
    "no orientation": ({"orientation": None}, "there is no orientation; give"),
    "no wrench": ({"wrench": None}, "there is no wrench; give an array wrench"),
    "wrench too short": (
        {"wrench": WRENCH[:-3]},
        r"wrench has 37 samples, but time has 40; give `wrench_time`",
    ),
    "orientation too long": (
        {"time": TIME[:-1]},
        "orientation has 40 samples, but time has 39",
    ),
    "wrench_time too short": (
        {"wrench_time": TIME[:5]},
        "wrench has 40 samples, but wrench_time has 5",
    ),
    "wrench_time alone": (
        {"time": None, "wrench_time": TIME},
        "wrench_time is given without time",
    ),
    "wrench transposed": ({"wrench": WRENCH.T}, r"\(6, 40\), not \(K, 6\); turn it"),
    "three numbers": ({"wrench": WRENCH[:, :3]}, "give 6 numbers a sample"),
    "force alone": (
        {"wrench": None, "force": WRENCH[:, :3]},
        "force is given alone; give force and torque, or wrench",
    ),
    "force beside wrench": ({"force": WRENCH[:, :3]}, "force is given beside wrench"),
    "torque too short": (
        {"wrench": None, "force": WRENCH[:, :3], "torque": WRENCH[:5, 3:]},
        r"force has shape \(40, 3\), torque \(5, 3\); give \(K, 3\) of each",
    ),
    "quaternions transposed": ({"orientation": QUATERNIONS.T}, r"shape \(4, 40\)"),
    "one number": ({"wrench": 3.0}, r"wrench has shape \(\)"),
    "nan": (
        {"wrench": with_value(WRENCH, (12, 3), np.nan)},
        r"wrench\[12, 3\] is nan; leave those samples out",
    ),
    "infinite time": ({"time": with_value(TIME, 3, np.inf)}, r"time\[3\] is inf"),
    "unsorted": ({"time": with_value(TIME, 5, 0.3)}, "row 5.*before 0.4 s of row 4"),
    "repeated": ({"time": np.minimum(TIME, TIME[4])}, "row 5.*repeats that of row 4"),
    "backwards": ({"time": TIME[::-1]}, "sort the rows by time"),
    "nanoseconds": ({"time": 1.7e18 + 1e9 * TIME}, "looks like nanoseconds"),
    "norm": (
        {"orientation": with_value(QUATERNIONS, 7, 0.5 * QUATERNIONS[7])},
        "sample 7 has norm 0.5, not 1; give unit quaternions x, y, z, w",
    ),
    "zero quaternion": (
        {"orientation": with_value(QUATERNIONS, 7, 0.0)},
        "sample 7 has norm 0, not 1",
    ),
    "no rotation": (
        {"orientation": with_value(TURNS.as_matrix(), 2, np.diag([1, 1, -1]))},
        r"orientation\[2\] is no rotation matrix",
    ),
    "transposed poses": (
        {"orientation": None, "pose": MATRICES.transpose(0, 2, 1)},
        r"the last row of pose\[0\] is not 0, 0, 0, 1; are its matrices transposed",
    ),
    "wrong pose": ({"orientation": None, "pose": POSITION}, "give matrices"),
    "pose and parts": ({"pose": MATRICES}, "pose and orientation are both given"),
    "text": ({"wrench": "forces"}, "wrench is not an array of numbers"),
    "complex": ({"wrench": WRENCH + 0j}, "wrench is not an array of numbers"),
    "ragged": ({"wrench": [[1.0], [1.0, 2.0]]}, "wrench is not an array of numbers"),
    "empty": (
        {"time": [], "orientation": np.empty((0, 4)), "wrench": np.empty((0, 6))},
        "is empty",
    ),
    "misspelled": ({"gyroscop": POSITION}, "did you mean 'gyroscope'"),
    "half dates": (
        {"time": TIME.astype("M8[s]"), "wrench_time": TIME},
        "one of time and wrench_time is a date",
    ),
    "two-dimensional time": ({"time": TIME[:, None]}, r"time has shape \(40, 1\)"),
    "static, unequal": (
        {"time": None, "wrench": WRENCH[:4]},
        "wrench has 4 samples, but orientation has 40; give `time`",
    ),
    "huge": ({"wrench": WRENCH * 1e30}, "beyond"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_a_recording_is_refused_in_one_line(case):
    changes, match = BAD[case]
    with pytest.raises(InputError, match=match) as refused:
        as_recording(**(GOOD | changes))
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 350


def test_a_recording_is_one_thing():
    recording = as_recording(**GOOD)
    assert as_recording(recording) is recording
    with pytest.raises(InputError, match="both a recording and `time`"):
        as_recording(recording, time=TIME)
    assert hefting.as_recording is as_recording

"""Faulty poses are left out of a recording before its motion is found, and told; other
recordings stay as they are."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks import pose_faults
from disturbances import disturbed
from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.core.recording import Recording, Stream
from hefting.ingest.ingest import ingest
from hefting.ingest.unmeasured import MANY_LEFT_OUT, without_faulty_poses
from hefting.logs import read_log
from recordings import LOGS, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")


def with_poses(recording, position=None, orientation=None):
    """A recording with other positions and quaternions, at the same times."""
    streams = dict(recording.streams)
    for name, values in (("position", position), ("orientation", orientation)):
        if values is not None:
            streams[name] = Stream(streams[name].time, values)
    return replace(recording, streams=streams)


@pytest.mark.usefixtures("nothing_looked_for")
def test_answers_are_as_good_as_without_the_fault(monkeypatch):
    """Glitches, stalls and silent drivers in three strengths, each once, spread over
    three kinds of motion; nine of ten answers are within 1.3 times the errors of the
    recording without the fault, 95 of a hundred where an oracle loses the same poses;
    95 of a hundred faults are named. Taken as they are, one answer in twenty is as
    good.
    """
    faults, motions, found = pose_faults.FAULTS, pose_faults.MOTIONS, []
    for i, motion in enumerate(motions):
        chosen = {
            name: (strengths[(i + j) % 3],)
            for j, (name, strengths) in enumerate(faults.items())
        }
        monkeypatch.setattr(pose_faults, "MOTIONS", (motion,))
        monkeypatch.setattr(pose_faults, "FAULTS", chosen)
        found += pose_faults.outcomes(range(2, 3), noises=(1e-4,))
    assert len(found) == 18
    good, but_for_lost, named = pose_faults.shares(found)
    print(good, but_for_lost, named)
    assert good >= 0.85
    assert but_for_lost >= 0.92
    assert named >= 0.95


def test_joint_angles_without_a_robot_are_refused():
    recording = disturbed("clean", 1.5, 1).recording
    angles = {"joint_positions": Stream(np.arange(20) / 100, np.ones((20, 6)))}
    joints = Recording({"wrench": recording["wrench"], **angles})
    with pytest.raises(InputError, match=r"no orientation.*give `urdf`"):
        ingest(joints)


@pytest.mark.parametrize("kind", ["clean", "drift", "spikes", "dropped", "contact"])
def test_a_recording_without_faults_is_returned_itself(kind):
    recording = disturbed(kind, 1.5, 1).recording
    assert without_faulty_poses(recording) is recording


@needs_recordings
def test_recordings_of_robots_are_returned_themselves():
    """None of them has a fault that matters: stalls of 3 to 8 ms at 1 kHz do not."""
    for path in LOGS:
        recording = read_log(path)
        assert without_faulty_poses(recording, "smooth") is recording, path


def test_both_streams_lose_a_pose():
    """They share their times; the note tells how many of which, and where."""
    recording = disturbed("clean", 1.5, 1).recording
    p = recording["position"].values.copy()
    p[[100, 500]] += 10.0
    checked = without_faulty_poses(with_poses(recording, position=p))
    for name in ("position", "orientation"):
        lost = np.setdiff1d(recording[name].rows, checked[name].rows)
        np.testing.assert_array_equal(lost, [101, 501])
    (said,) = checked.notes
    assert codes(checked.notes) == {"pose-glitches"}
    assert said.startswith("2 positions (0.19 %)")
    assert said.endswith("at 1.00, 5.00 s")
    assert checked.warnings == ()


def test_many_are_warned_of():
    recording = disturbed("clean", 1.5, 1).recording
    p, rng = recording["position"].values.copy(), np.random.default_rng(1)
    bad = rng.random(len(p)) < 2.0 * MANY_LEFT_OUT
    p[bad] += rng.normal(size=(int(bad.sum()), 3))
    found = ingest(with_poses(recording, position=p))
    assert "many-poses-left-out" in codes(found.warnings)
    assert "pose-glitches" in codes(found.notes)


def test_implausible_poses_are_left_in():
    """A frame that jumps by metres every 0.4 s: no part is more worth than another, so
    nothing is left out, and a warning tells."""
    recording = disturbed("clean", 1.5, 1).recording
    p = recording["position"].values.copy()
    p += 3.0 * np.random.default_rng(2).normal(size=(50, 3))[np.arange(len(p)) // 40]
    checked = without_faulty_poses(with_poses(recording, position=p))
    assert codes(checked.warnings) == {"poses-implausible"}
    assert len(checked["position"]) == len(p)
    assert len(checked["orientation"]) == len(p)


def test_a_jump_of_the_frame_is_told():
    recording = disturbed("clean", 1.5, 1).recording
    p = recording["position"].values.copy()
    p[len(p) // 2 :] += (3.0, 0.0, 0.0)
    checked = without_faulty_poses(with_poses(recording, position=p))
    assert codes(checked.warnings) == {"poses-jump"}
    assert len(checked["position"]) == len(p)


def test_streams_with_times_of_their_own_lose_their_own_samples():
    recording = disturbed("clean", 1.5, 1).recording
    position = recording["position"]
    p = position.values.copy()
    p[200] += 5.0
    moved = Stream(position.time + 0.004, p)
    streams = {**recording.streams, "position": moved}
    checked = without_faulty_poses(Recording(streams))
    assert len(checked["position"]) == len(p) - 1
    assert checked["orientation"] is streams["orientation"]


def test_static_poses_and_logged_accelerations_are_left_alone():
    """Static poses jump from one to the next; logged accelerations need no
    smoothing."""
    rng = np.random.default_rng(3)
    q = rng.normal(size=(20, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    time = np.arange(20.0)
    streams = {
        "orientation": Stream(time, q),
        "wrench": Stream(time, rng.normal(size=(20, 6))),
    }
    static = Recording(streams, static=True)
    assert without_faulty_poses(static) is static
    assert without_faulty_poses(Recording(streams)) is not None
    columns = {
        name: Stream(time, rng.normal(size=(20, 3)))
        for name in ("linear_acceleration", "angular_velocity", "angular_acceleration")
    }
    logged = Recording({**streams, **columns})
    assert without_faulty_poses(logged) is logged


def test_a_position_that_stands_still_while_the_sensor_turns_is_left_out():
    """As of pose messages in which only the orientation was written. Answers had been
    *good*, with inertias up to ten times too large."""
    recording = disturbed("clean", 1.5, 1).recording
    unwritten = with_poses(recording, np.zeros_like(recording["position"].values))
    usable = without_faulty_poses(unwritten)
    assert codes(usable.warnings) - codes(recording.warnings) == {"position-constant"}
    assert not usable.has("position")
    found = ingest(unwritten)
    assert found.source == "orientation"


def test_a_sensor_that_hardly_turns_may_stay_where_it_is():
    recording = disturbed("clean", 1.5, 1).recording
    still = np.tile(recording["orientation"].values[:1], (len(recording["wrench"]), 1))
    held = with_poses(recording, np.zeros_like(recording["position"].values), still)
    assert without_faulty_poses(held) is held


def test_a_recording_of_joints_alone_is_refused_in_a_line():
    """Where no arm gave its poses: it had ended in a `KeyError`."""
    recording = disturbed("clean", 1.5, 1).recording
    streams = {"wrench": recording["wrench"]}
    time, turned = recording["wrench"].time, np.zeros((len(recording["wrench"]), 6))
    joints = Recording({**streams, "joint_positions": Stream(time, turned)})
    assert without_faulty_poses(joints) is joints
    with pytest.raises(InputError, match="has no orientation"):
        ingest(joints)

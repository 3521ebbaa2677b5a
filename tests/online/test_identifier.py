"""The live identifier: fed from a loop, which never waits."""

import threading
import time

import numpy as np
import pytest
from benchmarks.online_streams import parts, swapped

import hefting
from hefting.core.messages import note, warning
from hefting.logs import write_log
from hefting.online import identifier
from hefting.online.samples import Samples

pytestmark = pytest.mark.usefixtures("same_recordings")


@pytest.fixture(scope="module")
def recording():
    return swapped(5, change=False, duration=5.0).recording


def feed(live, recording, speed=10.0):
    """As a robot would, but faster."""
    period = 0.05
    for together in parts(recording, period):
        for samples in together:
            live.add(samples)
        time.sleep(period / speed)


def test_fed_from_a_loop_it_answers_and_ends_with_all_samples(recording):
    whole = hefting.identify(recording)
    with hefting.LiveIdentifier(rate=20.0) as live:
        feed(live, recording)
        found = None
        for _ in range(600):  # the process may take its time
            found = live.wait(0.2)
            if found is not None and found.estimate is not None:
                break
        assert found.state == "identified"
        assert found.counts["dropped"] == 0
        last = live.close()
    np.testing.assert_allclose(
        last.estimate.parameters.vector, whole.estimate.parameters.vector, rtol=1e-9
    )
    assert last.counts["samples"] == sum(len(s) for s in recording.streams.values())


def test_the_final_answer_may_be_that_of_a_log(recording, tmp_path):
    """The record of a stream that is too long to be kept."""
    path = tmp_path / "log.csv"
    write_log(recording, path)
    live = hefting.LiveIdentifier(in_process=False)
    for together in parts(recording.slice(0.0, 3.0), 0.1):
        for samples in together:
            live.add(samples)
        live.step()
    assert live.close(path).estimate.mass == hefting.identify(path).mass


def test_of_a_log_whose_clock_begins_anew_the_last_object_s_part_is_used():
    """The stream's stamps begin at 4 s, those of its record at zero."""
    log = swapped(0, duration=7.0, time=4.0).recording
    found = []
    for record in (None, log):
        live = hefting.LiveIdentifier(in_process=False)
        for together in parts(log, 0.1):
            for name, stamps, values in together:
                live.add(Samples(name, stamps + 4.0, values))
            live.step()
        assert live.latest.object == 2
        found.append(live.close(record).estimate)
    # the same samples; the clocks differ by rounding
    assert found[1].mass == pytest.approx(found[0].mass, rel=1e-6)


def test_a_stream_that_is_not_kept_ends_with_the_last_live_answer(
    recording, monkeypatch
):
    monkeypatch.setattr("hefting.online.history.MOST_NUMBERS", 1000)
    live = hefting.LiveIdentifier(in_process=False)
    for together in parts(recording, 0.1):
        for samples in together:
            live.add(samples)
        live.step()
    before = live.latest.estimate
    last = live.close()
    assert last.estimate.mass == before.mass
    assert "live-not-kept" in hefting.core.messages.codes(last.messages)


def test_the_queue_is_bounded_and_what_is_dropped_is_counted(monkeypatch):
    monkeypatch.setattr(identifier, "QUEUE", 10)
    live = hefting.LiveIdentifier(in_process=False)
    for k in range(25):
        live.add("wrench", 0.01 * k, np.zeros(6))
    live.step()
    assert live.latest.counts["dropped"] == 15
    assert live.latest.counts["samples"] == 10


def test_samples_are_added_from_many_threads():
    live = hefting.LiveIdentifier(in_process=False)

    def add(number):
        for k in range(200):
            live.add("wrench", 0.001 * (5 * k + number), np.zeros(6))

    threads = [threading.Thread(target=add, args=(n,)) for n in range(5)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    live.step()
    counts = live.latest.counts
    late = counts["skipped"].get("late", 0)
    assert counts["samples"] == 1000
    assert counts["dropped"] == 0
    assert late == 0


def test_a_lost_source_is_the_state_until_it_is_back():
    live = hefting.LiveIdentifier(in_process=False)
    live.say(warning("source-lost", "the robot was switched off"))
    assert live.step().state == "lost source"
    live.say(note("source-back", "it is there again"))
    live.say(warning("source-silent", "no samples for 2 s"))
    assert live.step().state == "lost source"
    live.say(note("source-back", "it is there again"))
    live.add("wrench", 0.0, np.zeros(6))
    assert live.step().state == "waiting"


@pytest.mark.parametrize("rate", [10.0, 100.0])
def test_each_estimate_waits_for_samples_that_just_came(monkeypatch, rate):
    """So that none is of samples that are as old as the pause between two batches. Its
    end waits for nothing."""
    monkeypatch.setattr(identifier, "LONGEST_WAIT", 120.0)
    told, tell = [], hefting.LiveIdentifier._publish

    def note_time(live, found):
        told.append(found.time)
        tell(live, found)

    monkeypatch.setattr(hefting.LiveIdentifier, "_publish", note_time)
    live = hefting.LiveIdentifier(rate=rate)
    for k in range(1, 21):
        live.add("wrench", 0.1 * k, np.zeros(6))
        time.sleep(0.03)
    found, begin = list(told), time.monotonic()
    live.close()
    assert time.monotonic() - begin < 100.0
    assert len(found) > 1
    assert found == sorted(set(found))


def test_of_a_source_that_gives_nothing_the_state_is_told_all_the_same():
    with hefting.LiveIdentifier() as live:
        live.say(warning("source-lost", "the robot was switched off"))
        assert live.wait(60.0).state == "lost source"


def test_joint_positions_become_poses(recording, tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        '<robot name="r"><link name="base"/><link name="tool"/>'
        '<joint name="j" type="continuous"><parent link="base"/>'
        '<child link="tool"/><axis xyz="1 0 0"/></joint></robot>'
    )
    robot = hefting.Robot.from_urdf(urdf, sensor_frame="tool")
    live = hefting.LiveIdentifier(robot=robot, in_process=False)
    live.add(Samples("joint_positions", np.array([0.0, 0.1]), np.array([[0.0], [1.0]])))
    live.add("wrench", 0.1, np.zeros(6))
    live.step()
    series = live._pipeline.history.series
    np.testing.assert_allclose(
        series["orientation"].values[1], [np.sin(0.5), 0, 0, np.cos(0.5)], atol=1e-15
    )
    assert set(series) == {"position", "orientation", "wrench"}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"rate": 0.0}, "rate is 0.0"),
        ({"sign": "up"}, "unknown sign 'up'"),
        ({"method": "OSL"}, "unknown method 'OSL'"),
        ({"method": "OLS", "until": "mass=1%"}, "accuracy"),
        ({"shape": "missing.stl"}, "missing.stl"),
        ({"tool": "missing.json"}, "missing.json"),
        ({"bias": "nonsense"}, "unknown bias model 'nonsense'"),
        ({"bias": [1.0, 2.0, 3.0]}, "six finite numbers"),
        ({"bias": "missing.json"}, "missing.json"),
        ({"gravity": "down"}, "down"),
        ({"until": "weight=1%"}, "no accuracy"),
        ({"mass": "heavy"}, "heavy"),
        ({"nonsense": 1}, "no 'nonsense'"),
        ({"method": "PMD"}, "PMD needs"),
        ({"method": hefting.OLS(), "bias_": 1}, "beside an estimator"),
    ],
)
def test_what_cannot_be_right_is_refused_in_one_line(options, words):
    with pytest.raises(hefting.InputError, match=words) as refused:
        hefting.LiveIdentifier(in_process=False, **options)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("force", np.zeros(3), "no stream 'force'.*use position, orientation"),
        ("wrench", np.zeros(3), r"wrench has shape \(1, 3\), not \(1, 6\)"),
        ("orientation", np.zeros((2, 4)), r"not \(1, 4\) for 1 times"),
        ("joint_positions", np.zeros((2, 7)), r"not \(1, n\)"),
    ],
)
def test_samples_of_no_stream_are_refused(name, values, words):
    live = hefting.LiveIdentifier(in_process=False)
    with pytest.raises(hefting.InputError, match=words):
        live.add(name, 0.0, values)


def test_a_failure_of_the_thread_is_raised_to_the_user(recording, monkeypatch):
    def fail(self):
        raise hefting.HeftingError("the pipeline failed")

    monkeypatch.setattr(identifier.Pipeline, "step", fail)
    live = hefting.LiveIdentifier()
    live.add("wrench", 0.0, np.zeros(6))
    with pytest.raises(hefting.HeftingError, match="the pipeline failed"):
        live.wait(60.0)


def played(events):
    """The last live estimate and the final one of parts of streams."""
    live = hefting.LiveIdentifier(in_process=False)
    for k, (name, stamps, values) in enumerate(events):
        live.add(name, stamps, values)
        if k % 30 == 0:
            live.step()
    return live.step(), live.close()


@pytest.mark.parametrize("back", [0.8, np.spacing(4.0)])
def test_stamps_that_repeat_but_for_rounding_leave_the_answer(recording, back):
    """A clock that is set back by whole steps, and poses that are sent twice."""
    events = []
    for together in parts(recording, 0.05):
        for name, stamps, values in together:
            late = back if back > 0.1 and stamps[0] >= 3.0 else 0.0
            events.append((name, stamps - late, values))
            if back < 0.1 and name != "wrench":
                events.append((name, np.nextafter(stamps, 9.0), values))
    for found in played(events):
        assert found.state == "identified"
        low, high = found.estimate.intervals["mass"]
        mass = hefting.identify(recording).mass
        assert low < mass < high
        said = [reason.code for reason in found.estimate.verdict.reasons]
        assert ("clock-set-back" in said) == (back > 0.1)


def test_what_ends_live_estimates_is_told_by_the_final_answer(recording, monkeypatch):
    live = hefting.LiveIdentifier(in_process=False)
    for name, stream in recording.streams.items():
        live.add(name, stream.time, stream.values)
    live._failure = hefting.HeftingError("the process was killed")
    last = live.close()
    assert last.estimate is not None
    assert "live-failed" in hefting.core.messages.codes(last.messages)


def test_streams_that_are_no_recording_are_a_cause_that_is_named(recording):
    live = hefting.LiveIdentifier(in_process=False)
    time = np.arange(100) * 0.01
    for name, stream in recording.streams.items():
        live.add(name, stream.time, stream.values)
    live.add("joint_positions", time, np.zeros((100, 6)))
    live.add("joint_velocities", time, np.zeros((100, 7)))
    said = live.close().messages[-1]
    assert "no final answer" in said
    assert "differ in number" in said


def test_a_restart_among_samples_that_come_at_once_loses_none():
    """Of all streams what is before comes first, whatever waits."""
    live = hefting.LiveIdentifier(in_process=False)
    time = np.arange(300) * 0.01
    for begin in (0, 100, 200, 0, 100, 200):
        part = time[begin : begin + 100]
        live.add("wrench", part, np.ones((100, 6)))
        live.add("orientation", part, np.tile([0.0, 0.0, 0.0, 1.0], (100, 1)))
    found = live.step()
    live.close()
    assert found.counts["samples"] == 1200
    assert not +found.counts["skipped"]
    assert [m.code for m in found.messages].count("clock-jumped") == 1


@pytest.mark.parametrize("poses", ["flange", "turned"])
def test_poses_of_another_frame_become_those_of_the_sensor(recording, poses):
    """As of a recording; also by a log that was written of the stream."""
    pose = hefting.parse_pose("0.02,0,0.05,0,0,-0.38268,0.92388")
    given = {"sensor_pose_in_log": pose}
    if poses == "turned":
        given, pose = (
            {"sensor_turned": "z:-45"},
            hefting.parse_pose("0,0,0,0,0,-0.3826834324,0.9238795325"),
        )
    # some frame of which the sensor is at `pose`
    logged = hefting.with_sensor_pose(recording, np.linalg.inv(pose))
    found = []
    for log in (None, logged):
        live = hefting.LiveIdentifier(in_process=False, **given)
        for together in parts(logged, 1.0):
            for samples in together:
                live.add(samples)
            live.step()
        last = live.step().estimate
        found.append(live.close(log).estimate)
    whole = hefting.identify(logged, **given).estimate
    for each in found:
        np.testing.assert_allclose(
            each.parameters.vector, whole.parameters.vector, rtol=1e-9
        )
    low, high = last.intervals["mass"]
    assert low < whole.mass < high
    assert last.verdict.usable


def test_the_final_answer_is_past_waiting(recording):
    """Of a stream that came faster than it was looked at."""
    live = hefting.LiveIdentifier(in_process=False, until="mass=50%")
    for name, stream in recording.streams.items():
        live.add(name, stream.time, stream.values)
    assert live.step().state == "waiting"
    last = live.close()
    assert last.state == "sufficient"
    assert not last.messages

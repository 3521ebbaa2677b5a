"""Rows that were lost from a log whose time is made of the row number."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import correct

from disturbances import disturbed
from hefting import identify, predict
from hefting.core.messages import codes
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask
from hefting.ingest.ingest import ingest
from hefting.ingest.mended_times import (
    MANY,
    ROWS_FOR_DIGIT,
    _noise_of_steps,
    with_time_of_lost_rows,
)
from hefting.logs import read_log
from recordings import LOGS, needs_recordings

pytestmark = pytest.mark.usefixtures("same_poses")


def rows_of(recording: Recording, rows: Mask | Array, interval: float) -> Recording:
    """The recording of some of its rows, with time made of their number."""
    streams = {n: stream[rows] for n, stream in recording.streams.items()}
    made = {
        n: Stream(interval * np.arange(len(stream)), stream.values)
        for n, stream in streams.items()
    }
    return replace(recording, streams=made)


@pytest.mark.parametrize(
    ("seed", "share"), [(0, 0.005), (0, 0.02), (0, 0.06), (3, 0.01), (9, 0.02)]
)
def test_time_is_given_back_and_the_answer_is_that_of_the_log_with_time(seed, share):
    """To the interval's half-width; as logged, the inertia is off by several
    half-widths. A row that is lost at rest, or where the arm is slow, is not seen."""
    right = correct(seed).recording
    time = right["wrench"].time
    kept = np.random.default_rng(1).random(len(time)) >= share
    logged = rows_of(right, kept, time[1] - time[0])
    found = with_time_of_lost_rows(logged)
    (message,) = (*found.notes, *found.warnings)[len(logged.notes + logged.warnings) :]
    assert message.code == "rows-lost"
    lost = int(message.split()[0])
    assert 0.8 * (~kept).sum() <= lost <= (~kept).sum()
    many = lost > MANY * kept.sum()
    assert message.severity == ("warning" if many else "note")
    true = time[kept] - time[kept][0]
    # lost rows that are not seen are few
    assert np.abs(found["wrench"].time - true).max() < 0.2 * (~kept).sum() * time[1]
    answer, wanted = identify(logged).estimate, identify(right).estimate
    low, high = (np.array(side) for side in wanted.interval("inertia"))
    inertia = [each.parameters.inertia_at_com for each in (answer, wanted)]
    assert (np.abs(inertia[0] - inertia[1]) < 0.5 * (high - low)).all()
    assert answer.verdict.level == ("usable with care" if many else "good")


def logged_without(share=0.02, seed=0):
    """A right recording, and what is logged of it by a logger that loses rows."""
    right = correct(seed).recording
    kept = np.random.default_rng(1).random(len(right["wrench"])) >= share
    return right, rows_of(right, kept, 0.01)


def test_nothing_is_said_to_be_left_out():
    """Where samples are shown that were not used, those of a lost row are none."""
    _, logged = logged_without()
    assert ingest(logged).left_out == ()


def test_the_wrench_is_predicted_on_the_same_time():
    """Of all samples and of those of a log that lost rows: to a fifth of the noise, of
    which the motion of the second has more where a row is not seen."""
    right, logged = logged_without()
    estimate = identify(right).estimate
    whole, some = predict(estimate, right), predict(estimate, logged)
    rows = np.flatnonzero(np.random.default_rng(1).random(len(right["wrench"])) >= 0.02)
    off = some.wrench[:, :3] - whole.wrench[rows, :3]
    assert np.sqrt(np.mean(off**2)) < 0.02
    assert "rows-lost" in codes(some.notes)


def test_angles_keep_their_time_beside_a_part():
    """They are those of the whole log."""
    _, logged = logged_without()
    angles = Stream(logged["wrench"].time, np.zeros((len(logged["wrench"]), 3)))
    part = replace(logged, angles=angles).slice(2.0, 4.0)
    found = with_time_of_lost_rows(part)
    assert found.angles is not None
    assert (np.diff(found.angles.time) > 0.009).all()
    inside = np.isin(angles.time, part["wrench"].time)
    np.testing.assert_allclose(found.angles.time[inside], found["wrench"].time)


@pytest.mark.parametrize("scale", [5e-324, 1e-20])
def test_positions_next_to_nothing_give_no_warning(scale):
    """And a jump of 1e8 m, as a glitch is not left out yet."""
    _, logged = logged_without()
    p = scale * np.round(logged["position"].values)
    p[500] = 1e8
    streams = dict(logged.streams) | {"position": Stream(logged["wrench"].time, p)}
    with_time_of_lost_rows(replace(logged, streams=streams))


@pytest.mark.parametrize("kind", ["clean", "drift", "spikes", "dropped", "contact"])
def test_a_recording_that_lost_none_is_returned_itself(kind):
    recording = disturbed(kind, 1.5, 1).recording
    assert with_time_of_lost_rows(recording) is recording


@pytest.mark.parametrize("nth", [5, 10, 100])
@pytest.mark.parametrize("seed", [0, 2])
def test_poses_of_a_faster_clock_are_no_lost_rows(seed, nth):
    """Every nth pose of one that has 125 a second, or fewer, is not read by a logger of
    100: its time is right. In the second recording the arm stops and goes."""
    right = correct(seed).recording
    rows = np.flatnonzero(np.arange(len(right["position"])) % nth != 2)
    read = rows_of(right, rows, 0.0125)
    assert with_time_of_lost_rows(read) is read


def test_poses_read_now_early_now_late_are_no_lost_rows():
    """As many are repeated as are passed over."""
    right = disturbed("clean", 1.5, 1).recording
    count = len(right["position"])
    late = np.random.default_rng(2).random(count) < 0.05
    held = np.maximum.accumulate(np.where(late, 0, np.arange(count)))
    read = rows_of(right, held, 0.01)
    assert with_time_of_lost_rows(read) is read


@pytest.mark.parametrize("digit", [1e-4, 1e-3])
def test_rounded_poses_are_no_lost_rows(digit):
    """A slow arm changes by one digit of a rounded position, and now and then by two."""
    right = disturbed("clean", 1.5, 1).recording
    time, p = 0.01 * np.arange(1000), np.zeros((1000, 3))
    p[:, 0] = np.round(1.2 * np.arange(1000)) * digit
    orientation = np.tile(right["orientation"].values[:1], (1000, 1))
    streams = {"position": Stream(time, p), "orientation": Stream(time, orientation)}
    recording = Recording({**streams, "wrench": Stream(time, np.ones((1000, 6)))})
    assert with_time_of_lost_rows(recording) is recording


def test_the_memory_that_it_takes_is_that_of_the_steps():
    """Of slow poses with noise, where two steps in five are odd and none is clear: 118
    bytes a row, of which the steps are 48 and their lengths 24. All odd steps at once
    took 619."""
    count, rng = 200_000, np.random.default_rng(0)
    time = 0.001 * np.arange(count)
    position, turn = 1e-6 * rng.normal(size=(2, count, 3))
    position[:, 0] += 7e-6 * np.arange(count)
    orientation = np.column_stack((turn, np.sqrt(1.0 - np.square(turn).sum(axis=1))))
    values = {"position": position, "orientation": orientation}
    streams = {name: Stream(time, each) for name, each in values.items()}
    recording = Recording({**streams, "wrench": Stream(time, np.ones((count, 6)))})
    tracemalloc.start()
    try:
        assert with_time_of_lost_rows(recording) is recording
        assert tracemalloc.get_traced_memory()[1] < 200 * count
    finally:
        tracemalloc.stop()


@needs_recordings
def test_recordings_of_robots_are_returned_themselves():
    """Two of them have even time, and poses that are read now early, now late."""
    for path in LOGS:
        recording = read_log(path)
        assert with_time_of_lost_rows(recording, "smooth") is recording, path


def test_rows_lost_before_the_part_that_is_asked_for_do_not_count():
    right = correct(0).recording
    kept = np.ones(len(right["wrench"]), dtype=bool)
    kept[[120, 150, 180]] = False
    logged = rows_of(right, kept, 0.01)
    assert "rows-lost" in codes(ingest(logged).read_notes)
    assert "rows-lost" not in codes(ingest(logged, start=2.0).read_notes)


@pytest.mark.parametrize("share", [0.005, 0.05])
def test_joints_tell_it_where_there_are_no_poses(share):
    """Of angles that go on at -pi beyond pi too."""
    time = np.arange(3000) / 100.0
    swing = np.array([0.3, 0.5, 0.7])
    angles = 2.5 + np.sin(swing * time[:, None] + swing)
    noise = 1e-5 * np.random.default_rng(3).normal(size=angles.shape)
    wrapped = (angles + noise + np.pi) % (2.0 * np.pi) - np.pi
    whole = Recording(
        {
            "joint_positions": Stream(time, wrapped),
            "joint_torques": Stream(time, np.sin(angles)),
        }
    )
    kept = np.random.default_rng(1).random(len(time)) >= share
    kept[0] = True
    found = with_time_of_lost_rows(rows_of(whole, kept, 0.01))
    late = found["joint_torques"].time - time[kept]
    # where all three turn back nearly at once a row is not seen
    assert np.abs(late).max() < 0.06 * (~kept).sum() * 0.01 + 0.011
    (message,) = (*found.notes, *found.warnings)
    assert message.code == "rows-lost"
    assert "the joints step by several rows" in message
    assert with_time_of_lost_rows(whole) is whole


def test_noise_of_steps():
    """Of a body at rest a step is the difference of two values; the smallest change of a
    number counts wherever it stands."""
    rng = np.random.default_rng(5)
    still = 1e-4 * rng.normal(size=(5000, 3))
    # of 5,000 second differences the median absolute one is known to 2 %
    assert _noise_of_steps(still, np.diff(still, axis=0)) == pytest.approx(
        1e-4, rel=0.03
    )
    # rounding in place of noise: half the smallest step counts as one
    coarse = np.round(np.linspace(0.0, 1.0, 4000), 2)[:, None] * np.ones(3)
    assert _noise_of_steps(coarse, np.diff(coarse, axis=0)) == pytest.approx(0.005)
    # a smaller step that is met after more rows than are read at a time
    late = np.repeat(np.arange(0.0, 60.0, 1.0), 500)[:, None] * np.ones(3)
    late[ROWS_FOR_DIGIT + 100 :] += 0.25
    assert _noise_of_steps(late, np.diff(late, axis=0)) == pytest.approx(0.125)

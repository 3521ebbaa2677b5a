"""Mistakes in recordings of static poses, which are few and whose noise nothing tells."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.bodies import FILLINGS, random_body
from benchmarks.given import Given
from benchmarks.mistaken import mistakes
from scipy.spatial.transform import Rotation

from hefting.core.inertia import InertialParameters
from hefting.core.messages import codes
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.identification import identify
from hefting.ingest.ingest import ingest
from hefting.ingest.rivals import axes_turned, cable, judge
from hefting.logs import read_log
from recordings import DATA, needs_recordings

NOISE = np.repeat((0.01, 0.0006), 3)
"""[N, N m] of an average over some seconds."""


def poses(seed: int, count: int = 24) -> Given:
    """Static poses of an object of 1.2 kg with a biased sensor."""
    rng = np.random.default_rng([3, seed])
    body = random_body(next(iter(FILLINGS)), 500 + seed)
    thing = InertialParameters(body.parameters.vector * 1.2 / body.parameters.mass)
    turns = Rotation.random(count, rng=rng)
    force = np.asarray(-thing.mass * turns.inv().apply(STANDARD_GRAVITY), dtype=float)
    wrench = np.hstack((force, np.cross(thing.center_of_mass, force)))
    wrench += rng.normal(size=6) * np.repeat((3.0, 0.2), 3)
    wrench += rng.normal(size=wrench.shape) * NOISE
    index = np.arange(count, dtype=float)
    streams = {
        "wrench": Stream(index, wrench),
        "position": Stream(index, rng.uniform(-0.3, 0.3, (count, 3))),
        "orientation": Stream(index, turns.as_quat()),
    }
    return Given(Recording(streams, static=True, source="poses"), body.shape, thing)


def made(name: str, strength: str, seed: int, count: int = 24) -> Given:
    """One of the benchmark's mistakes."""
    (mistake,) = (m for m in mistakes() if (m.name, m.strength) == (name, strength))
    return mistake.make(poses(seed, count), np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(6))
def test_right_poses_are_good(seed):
    """Also the fewest in which mistakes are looked for."""
    for count in (6, 8, 12, 24):
        assert str(identify(poses(seed, count).recording).verdict) == "good"


@pytest.mark.parametrize("seed", range(4))
def test_noise_as_of_a_real_sensor_hides_no_clear_mistake(seed):
    """Nothing tells the noise of static poses, so that it counts as unexplained: a
    mistake may explain less than half of that, and all that any could."""
    given, rng = poses(seed), np.random.default_rng(seed)
    noise = rng.normal(size=(24, 6)) * 8.0 * NOISE
    right = given.wrench(lambda _, w: w + noise)
    assert str(identify(right.recording).verdict) == "good"
    wrong = right.wrench(lambda _, w: w * (1, 1, 1, 1, 2, 1))
    found = identify(wrong.recording).verdict
    assert found.level == "do not use"
    assert "channel-wrong" in codes(found.reasons)


@needs_recordings
def test_a_doubled_torque_is_named_in_poses_of_a_real_sensor():
    """Its centre of mass is twice as far away: it had been good."""
    log = read_log(DATA / "kuka-ati" / "static_poses.csv")
    wrench = log["wrench"].values * (1, 1, 1, 1, 2, 1)
    found = identify(orientation=log["orientation"].values, wrench=wrench)
    assert found.verdict.level == "do not use"
    assert codes(found.verdict.reasons) == {"channel-wrong"}


@needs_recordings
def test_few_poses_of_real_sensors_are_good():
    """Seven of one sensor, each six of these, and some of 24 of another."""
    rng, six = np.random.default_rng(0), np.arange(7)
    seven = read_log(DATA / "axia80" / "poses7.csv")
    kuka = read_log(DATA / "kuka-ati" / "static_poses.csv")
    some = [(seven, six), *((seven, np.delete(six, left_out)) for left_out in six)]
    some += [(kuka, rng.choice(24, n, replace=False)) for n in (6, 7, 8, 9, 10, 11)]
    for log, rows in some:
        poses, wrench = log["orientation"].values[rows], log["wrench"].values[rows]
        found = identify(orientation=poses, wrench=wrench)
        assert str(found.verdict) == "good"


@needs_recordings
def test_a_turn_is_named_in_few_poses_of_a_real_sensor():
    log = read_log(DATA / "axia80" / "poses7.csv")
    turn = Rotation.from_euler("x", 20.0, degrees=True).as_matrix()
    wrench = log["wrench"].values @ np.kron(np.eye(2), turn).T
    found = identify(orientation=log["orientation"].values, wrench=wrench)
    assert found.verdict.level == "do not use"
    assert "axes-turned" in codes(found.verdict.reasons)


@pytest.mark.parametrize("count", [6, 8, 11])
@pytest.mark.parametrize(
    ("name", "strength", "code"),
    [
        ("turned about z", "30°", "axes-turned"),
        ("axis flipped", "fx", "axis-flipped"),
        ("quaternion order", "w first", "quaternion-order"),
        ("wrench in base axes", "", "wrench-in-base-axes"),
        ("base tilted", "15°", "base-tilted"),
        ("inverse pose", "whole", "pose-inverse"),
    ],
)
def test_a_mistake_is_named_in_few_poses(name, strength, code, count):
    """Of fewer than twelve none had been looked for: answers were *good* and wrong."""
    given = made(name, strength, 0, count)
    doubt = ingest(given.recording).doubt
    assert doubt is not None
    assert doubt.message.code == code
    assert doubt.makes_wrong


def test_no_mistake_of_many_unknowns_is_looked_for_in_few_poses(monkeypatch):
    """Among six to eleven, noise alone would be explained."""
    looked = []
    monkeypatch.setattr(judge, "each_of", lambda _, some: looked.extend(some) or some)
    for count in (11, 12):
        ingest(made("wrench in base axes", "", 0, count).recording)
        assert (cable.explain in looked) == (count == 12)
        assert axes_turned.explain in looked


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("name", "strength", "code"),
    [
        ("cable", "20 N/m", "cable-force"),
        ("wrench in base axes", "", "wrench-in-base-axes"),
        ("wrench in base axes", "about the base", "wrench-in-base-axes"),
    ],
)
def test_a_mistake_is_named_as_of_a_moving_sensor(name, strength, code, seed):
    """A cable had made 4 of 8 answers that were called good wrong."""
    given = made(name, strength, seed)
    doubt = ingest(given.recording).doubt
    assert doubt is not None
    assert doubt.message.code == code


def weight(given: Given) -> tuple[np.ndarray, np.ndarray]:
    """Force (K, 3) on the object and its torque (K, 3) by the weight."""
    turns = Rotation.from_quat(np.array(given.recording["orientation"].values))
    force = -given.truth.mass * turns.inv().apply(STANDARD_GRAVITY)
    return force, np.cross(given.truth.center_of_mass, force)


def changed(given: Given, change: np.ndarray, first: int) -> Recording:
    """With the wrench changed from one pose on."""
    after = np.arange(len(given.recording["wrench"])) >= first
    return given.wrench(lambda _, w: w + after[:, None] * change).recording


@pytest.mark.parametrize("first", [6, 12, 18])
def test_an_object_that_slips_between_two_poses_is_told(first):
    """By 10 mm: COMs between the two places had been called good."""
    given, by = poses(1), np.array((0.0, 0.01, 0.0))
    force, _ = weight(given)
    slipped = np.hstack((np.zeros_like(force), np.cross(by, force)))
    recording = changed(given, slipped, first)
    (reason,) = identify(recording).verdict.reasons
    assert reason.code == "object-changing"
    assert f"move by 10 mm in the gripper from row {first + 1} on" in str(reason)
    # as is advised
    com = identify(recording, start=first).center_of_mass
    np.testing.assert_allclose(com, given.truth.center_of_mass + by, atol=1e-3)


def test_an_object_that_is_swapped_between_two_poses_is_told():
    """For one that weighs a tenth less."""
    given = poses(2)
    recording = changed(given, -0.1 * np.hstack(weight(given)), 10)
    (reason,) = identify(recording).verdict.reasons
    assert reason.code == "object-changing"
    assert "1.2 kg at the start of the recording and 1.08 kg from row 11 on" in reason


def test_a_bias_that_jumps_between_two_poses_is_no_object_that_changes():
    """Poses that are few tell the one from the other."""
    given = poses(3)
    found = identify(changed(given, np.array((1.0, 0, -0.5, 0.05, 0, 0)), 12))
    assert "object-changing" not in codes(found.verdict.reasons)


def test_the_order_of_rows_is_of_no_matter_to_right_poses():
    given = poses(4).recording
    order = np.random.default_rng(1).permutation(len(given["wrench"]))
    streams = {
        name: Stream(s.time, np.array(s.values)[order])
        for name, s in given.streams.items()
    }
    assert str(identify(replace(given, streams=streams)).verdict) == "good"

"""Joint angles and torques that stand out alone, of damaged messages, or are repeated, as
none came, and those that do not."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array
from hefting.torques.samples import (
    LARGEST_SHARE,
    TorqueSamples,
    samples_of,
    without_held,
    without_spikes,
)
from torque_runs import dynamics, fitted, runs

TIME = np.arange(3000) / 100.0
SWING = 20.0 * np.sin(0.7 * TIME)[:, None] * (1.0, 0.3)
RNG = np.random.default_rng(4)


def log(position: Array, torque: Array, **more) -> Recording:
    time = np.arange(len(position)) / 100.0
    streams = {
        "joint_positions": Stream(time, position),
        "joint_torques": Stream(time, torque),
    }
    return Recording(streams, **more)


@pytest.mark.parametrize("stream", ["joint_positions", "joint_torques"])
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_spikes_of_up_to_three_in_a_row_are_what_the_neighbours_are(noise, stream):
    """At the ends too."""
    right = SWING + noise * RNG.normal(size=SWING.shape)
    values = right.copy()
    rows = np.array((0, 100, 500, 501, 900, 901, 902, 2999))
    values[rows, 0] += (40.0, 30.0, -9.0, -9.0, 40.0, 30.0, 40.0, 50.0)
    given = log(SWING, SWING)
    streams = {**given.streams, stream: Stream(TIME, values)}
    found = without_spikes(replace(given, streams=streams))
    changed = found[stream].values != values
    assert np.flatnonzero(changed[:, 0]).tolist() == rows.tolist()
    assert not changed[:, 1].any()
    # three steps of the swing, and three deviations of each noise
    assert np.abs(found[stream].values - right)[rows].max() < 0.5 + 6.0 * noise
    (said,) = found.warnings
    assert (said.code, said.severity) == ("joint-spikes", "note")
    assert f"{stream.replace('_', ' ')} (8 of " in said


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_friction_that_turns_over_is_none(noise):
    friction = 5.0 * np.sign(np.cos(0.7 * TIME))[:, None]
    torque = SWING + friction + noise * RNG.normal(size=SWING.shape)
    given = log(SWING, torque)
    assert without_spikes(given) is given


@pytest.mark.parametrize("rate", [4.0, 20.0])
def test_no_motion_is_one_however_seldom_it_is_sampled(rate):
    """Four times a second, of a swing that takes 2.5 s."""
    time = np.arange(200) / rate
    position = np.sin(2.5 * time)[:, None] * (1.0, 0.3) + 1e-4 * time[:, None]
    given = log(position, position)
    assert without_spikes(given) is given


@pytest.mark.parametrize(("rate", "share"), [(100.0, 1.0), (20.0, 0.0)])
def test_a_brief_acceleration_is_none(rate, share):
    """Of 0.15 s, at 20 samples a second; of 0.03 s, at a hundred, it is one."""
    time = np.arange(400) / rate
    torque = 20.0 * np.sin(0.7 * time)[:, None] * (1.0, 0.3)
    torque[200:203, 0] += 15.0
    streams = {
        "joint_positions": Stream(time, torque),
        "joint_torques": Stream(time, torque),
    }
    found = without_spikes(Recording(streams))
    changed = found["joint_torques"].values != torque
    assert changed[200:203, 0].mean() == share


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_few_rows_are_as_they_were(rows):
    given = log(SWING[:rows], SWING[:rows])
    assert without_held(without_spikes(given)) is given


def test_a_joint_of_which_too_many_stand_out_is_left_alone():
    torque = SWING + 0.1 * RNG.normal(size=SWING.shape)
    hit = RNG.random(len(TIME)) < 1.5 * LARGEST_SHARE
    torque[hit, 0] += 50.0
    given = log(SWING, torque)
    assert without_spikes(given) is given


def test_runs_with_spikes_answer_as_without():
    """One torque in a hundred of each joint 20 N m off had made the interval eight times
    as wide, and rows of zeros put the mass 11 % off."""
    own = dynamics("ur5e")
    case = runs("ur5e", 2, 100.0)
    rng = np.random.default_rng(5)

    def damaged(run: TorqueSamples) -> TorqueSamples:
        hit = rng.random(run.torque.shape) < 0.01
        torque = run.torque + 20.0 * hit * rng.choice((-1.0, 1.0), run.torque.shape)
        lost = rng.random(len(torque)) < 0.005
        rows = (np.where(lost[:, None], 0.0, x) for x in (run.position, torque))
        return samples_of(without_spikes(log(*rows)), own)

    clean = fitted("ur5e", 2, 100.0)
    loaded, empty = (tuple(map(damaged, each)) for each in (case.loaded, case.empty))
    found = replace(case, loaded=loaded, empty=empty).fit()
    std = clean.covariance[0, 0] ** 0.5
    assert abs(found.common[-10] - clean.common[-10]) < 0.5 * std
    assert found.covariance[0, 0] ** 0.5 < 1.2 * std


def test_a_run_without_spikes_is_as_it_was():
    run = runs("ur5e", 2, 100.0).loaded[0]
    given = log(run.position, run.torque)
    assert without_spikes(given) is given


@pytest.mark.parametrize(
    ("stream", "begin", "end"),
    [
        ("joint_positions", 1000, 1020),
        ("joint_positions", 2980, 3000),
        ("joint_positions", 0, 20),
        ("joint_torques", 1000, 1200),
    ],
)
def test_rows_that_a_logger_repeats_are_left_out(stream, begin, end):
    """Angles that stand for 0.1 s in the middle or at the end had put masses 9 to 99 %
    off, as their jump made all of the motion rough."""
    values = SWING.copy()
    values[begin:end] = values[begin]
    given = log(SWING, SWING)
    given = replace(given, streams={**given.streams, stream: Stream(TIME, values)})
    found = without_held(given)
    kept = (np.arange(len(TIME)) < begin) | (np.arange(len(TIME)) >= end)
    np.testing.assert_array_equal(found[stream].time, TIME[kept])
    np.testing.assert_array_equal(found[stream].values, SWING[kept])
    (said,) = found.warnings
    assert (said.code, said.severity) == ("joint-held", "note")
    assert f"{end - begin} of 3000 {stream.replace('_', ' ')}" in said


def test_joints_that_rest_or_are_read_seldom_are_not_repeated():
    """A rest is left as it began, slowly; each of ten readings in a row is one."""
    rests = np.clip(np.linspace(-1.0, 2.0, 3000), 0.1, 0.9)[:, None] + [0.0, 1.0]
    between = np.concatenate((rests, rests[::-1]))[1500:4500]
    seldom = SWING[::10].repeat(10, axis=0)
    for position in (between, seldom):
        given = log(position, SWING)
        assert without_held(given) is given
    given = log(SWING, seldom)
    assert without_held(given) is given

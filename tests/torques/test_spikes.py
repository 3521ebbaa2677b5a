"""Torques that stand out alone, of damaged messages, and those that do not."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.recording import Recording, Stream
from hefting.torques.samples import TorqueSamples, samples_of, spikes
from hefting.torques.spikes import LARGEST_SHARE, without_spikes
from torque_runs import dynamics, fitted, runs

TIME = np.arange(3000) / 100.0
SWING = 20.0 * np.sin(0.7 * TIME)[:, None] * (1.0, 0.3)
RNG = np.random.default_rng(4)


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_spikes_of_up_to_three_in_a_row_are_what_the_neighbours_are(noise):
    right = SWING + noise * RNG.normal(size=SWING.shape)
    torque = right.copy()
    rows = np.array((100, 500, 501, 900, 901, 902))
    torque[rows, 0] += (30.0, -9.0, -9.0, 40.0, 30.0, 40.0)
    found, where = without_spikes(torque)
    assert np.flatnonzero(where[:, 0]).tolist() == rows.tolist()
    assert not where[:, 1].any()
    # three steps of the swing, and three deviations of the noise
    assert np.abs(found - right)[rows].max() < 0.5 + 3.0 * noise
    np.testing.assert_array_equal(found[~where], torque[~where])


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_friction_that_turns_over_is_none(noise):
    friction = 5.0 * np.sign(np.cos(0.7 * TIME))[:, None]
    torque = SWING + friction + noise * RNG.normal(size=SWING.shape)
    assert not without_spikes(torque)[1].any()


def test_a_joint_of_which_too_many_stand_out_is_left_alone():
    torque = SWING + 0.1 * RNG.normal(size=SWING.shape)
    hit = RNG.random(len(TIME)) < 1.5 * LARGEST_SHARE
    torque[hit, 0] += 50.0
    assert not without_spikes(torque)[1].any()


def test_runs_with_spikes_answer_as_without():
    """One sample in a hundred of each joint, of 20 N m, had made the interval eight times
    as wide; their number is said."""
    own = dynamics("ur5e")
    case = runs("ur5e", 2)
    rng = np.random.default_rng(5)

    def log(run: TorqueSamples) -> Recording:
        hit = rng.random(run.torque.shape) < 0.01
        torque = run.torque + 20.0 * hit * rng.choice((-1.0, 1.0), run.torque.shape)
        streams = {
            "joint_positions": Stream(run.time, run.position),
            "joint_torques": Stream(run.time, torque),
        }
        names = tuple(own.names)
        return Recording(streams, joint_names=names, source="held.csv")

    (loaded,), (empty,) = ([log(r) for r in each] for each in (case.loaded, case.empty))
    gains = None
    (said,) = spikes(loaded, own, gains)
    assert (said.code, said.severity) == ("torque-spikes", "note")
    assert "of joint6 stand out" in said
    clean = fitted("ur5e", 2)
    found = replace(
        case,
        loaded=(samples_of(loaded, own, gains),),
        empty=(samples_of(empty, own, gains),),
    ).fit()
    std = clean.covariance[0, 0] ** 0.5
    assert abs(found.common[-10] - clean.common[-10]) < 0.5 * std
    assert found.covariance[0, 0] ** 0.5 < 1.2 * std


def test_a_run_without_spikes_says_nothing():
    own = dynamics("ur5e")
    run = runs("ur5e", 2).loaded[0]
    streams = {
        "joint_positions": Stream(run.time, run.position),
        "joint_torques": Stream(run.time, run.torque),
    }
    names = tuple(own.names)
    assert spikes(Recording(streams, joint_names=names), own, None) == ()

"""Channels of the wrench that measure nothing."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import correct
from scipy.spatial.transform import Rotation

from hefting import identify
from hefting.core.errors import InputError
from hefting.core.recording import Stream
from hefting.ingest.channels import (
    dead_channel_message,
    require_changing_wrench,
    rounding_error,
    still_pose_message,
)
from hefting.inspection import inspect


def changed(change):
    """The message of a correct recording whose wrench (K, 6) is changed."""
    return dead_channel_message(correct(0).wrench(lambda _, w: change(w)).recording)


def filled(channel, value):
    def change(wrench):
        wrench[:, channel] = value
        return wrench

    return change


@pytest.mark.parametrize(("channel", "name"), [(2, "fz"), (3, "tx")])
@pytest.mark.parametrize("value", [0.0, 1.5])
def test_a_channel_that_never_changes_is_named(channel, name, value):
    message = changed(filled(channel, value))
    assert message is not None
    assert (message.code, message.severity) == ("channel-dead", "error")
    assert message.startswith(f"{name} never changes: is the channel connected")


def test_a_copied_channel_is_named():
    message = changed(lambda w: w[:, [0, 0, 2, 3, 4, 5]])
    assert message is not None
    assert "fy is the same as fx" in message


def test_nothing_is_said_of_a_correct_recording_nor_of_one_that_rests_without_noise():
    assert dead_channel_message(correct(0).recording) is None
    still = correct(0).recording
    wrench = still["wrench"]
    held = np.tile(np.arange(6.0), (len(wrench), 1))
    swinging = held + np.sin(wrench.time)[:, None] * (1.0, 0.0, 1.0, 0.0, 1.0, 0.0)
    for values in (held, swinging):
        streams = {**still.streams, "wrench": Stream(wrench.time, values)}
        assert dead_channel_message(replace(still, streams=streams)) is None


@pytest.mark.parametrize("value", [1.0, -0.3])
def test_a_wrench_that_never_changes_is_refused(value):
    """What a fit made of it depended on how the machine rounds."""
    given = correct(1).wrench(lambda _, w: np.full_like(w, value))
    with pytest.raises(InputError, match="never changes, although the sensor turns"):
        identify(given.recording)
    assert "never changes" in inspect(given.recording).missing["conditioning"]


def test_a_wrench_that_changes_in_one_sample_is_not_refused_as_constant():
    recording = correct(1).recording
    values = np.ones_like(recording["wrench"].values)
    wrench = Stream(recording["wrench"].time, values)
    require_changing_wrench(resting(replaced(recording, wrench=wrench)))
    values[7, 2] = 1.5
    touched = Stream(wrench.time, values)
    require_changing_wrench(replaced(recording, wrench=touched))


def replaced(recording, **streams):
    return replace(recording, streams={**recording.streams, **streams})


def resting(recording):
    """The same recording of a sensor that is turned by 9 degrees at most."""
    orientation = recording["orientation"]
    turn = Rotation.from_rotvec(
        np.linspace(0.0, np.radians(9.0), len(orientation))[:, None] * (1.0, 0.0, 0.0)
    )
    return replaced(recording, orientation=Stream(orientation.time, turn.as_quat()))


def test_the_answer_is_not_to_be_used():
    given = correct(0).wrench(lambda _, w: filled(4, 0.0)(w))
    found = identify(given.recording, given.shape)
    assert found.estimate.verdict.level == "do not use"
    assert found.estimate.warnings[0].code == "channel-dead"


def test_no_other_mistake_is_named_beside_torques_that_are_not_measured():
    """A lever to the COM would explain them."""
    given = correct(0).wrench(lambda _, w: w * np.repeat((1.0, 0.0), 3))
    reasons = identify(given.recording).verdict.reasons
    codes = [reason.code for reason in reasons]
    assert codes[0] == "channel-dead"
    assert "lever-arm" not in codes


def still(names):
    """A correct recording in which streams of poses never change."""
    recording = correct(0).recording
    held = {
        name: Stream(s.time, np.tile(s.values[:1], (len(s), 1)))
        for name in names
        for s in (recording[name],)
    }
    return replace(recording, streams={**recording.streams, **held})


def test_a_pose_that_never_changes_is_named():
    assert still_pose_message(still([])) is None
    assert still_pose_message(still(["position"])) is None
    said = [
        still_pose_message(still(names))
        for names in (["orientation"], ["orientation", "position"])
    ]
    assert [message.code for message in said] == ["pose-constant"] * 2
    turned = still(["orientation", "position"])
    position = turned["position"].values.copy()
    position[0] += 0.1  # before the first sample of a stream that stopped
    first = Stream(turned["position"].time, position)
    turned = replace(turned, streams={**turned.streams, "position": first})
    assert still_pose_message(turned).startswith("the orientation never changes in ")
    assert said[0].startswith("the orientation never changes in ")
    assert said[1].startswith("the pose never changes in ")


@pytest.mark.filterwarnings("error")
def test_where_the_wrench_changes_and_the_pose_does_not():
    recording = still(["orientation", "position"])
    assert "pose-constant" in [m.code for m in inspect(recording).warnings]
    found = identify(recording).estimate
    assert found.verdict.level == "do not use"
    first, *others = [reason.code for reason in found.verdict.reasons]
    assert first == "pose-constant"
    assert "unexplained" not in others


def test_two_channels_of_noise_tell_of_a_third_that_has_none():
    """One alone does not."""
    for rests, told in (([0, 1, 2, 3], True), ([0, 1, 2, 3, 4], False)):

        def still(wrench, rests=rests):
            wrench[:, rests] = 1.0
            return wrench

        assert (changed(still) is not None) is told


def test_the_error_of_rounding_is_uniform_over_a_step():
    """Of a slow wave through many steps, which tells both the step and the error."""
    time = np.linspace(0.0, 1.0, 20_000)
    exact = np.sin(2.0 * np.pi * time)[:, None] * (9.0, 8.0, 7.0, 0.9, 0.8, 0.7)
    steps = np.array((0.1, 0.2, 0.4, 0.01, 0.02, 0.04))
    rounded = steps * np.round(exact / steps)
    expected = [
        np.sqrt(np.mean(np.square((rounded - exact)[:, channels])))
        for channels in (slice(3), slice(3, 6))
    ]
    # the slow wave dwells at its turns: the errors are uniform to a few percent
    np.testing.assert_allclose(rounding_error(rounded), expected, rtol=0.05)


def dead_zone(wrench, size=(1.5, 0.05)):
    """Small values are zero, and others that much smaller, as by a threshold filter."""
    less = np.abs(wrench) - np.repeat(size, 3)
    return np.sign(wrench) * np.maximum(less, 0.0)


def test_a_dead_zone_is_named():
    """It had been *good* with a mass 11 % too small, or *usable with care*."""
    message = changed(dead_zone)
    assert message is not None
    assert (message.code, message.severity) == ("channel-dead", "error")
    assert "dead zone" in message
    found = identify(correct(0).wrench(lambda _, w: dead_zone(w)).recording)
    assert found.verdict.level == "do not use"
    assert found.verdict.reasons[0].code == "channel-dead"


@pytest.mark.parametrize(
    ("rows", "values", "digits", "named"),
    [
        (55, [0.3], 0.0, True),
        (45, [0.3], 0.0, False),  # less than a twentieth
        (300, [0.3, 0.4], 0.0, False),  # as of a channel that is measured more slowly
        (300, [9.0], 0.0, False),  # the end of the range
        (300, [0.3], 0.05, True),
        (300, [0.3], 1.4, False),  # more than the noise
    ],
)
def test_a_channel_rests_at_one_value_within_its_range(rows, values, digits, named):
    wrench = np.random.default_rng(1).normal(size=(1000, 6))
    if digits:
        wrench = digits * np.round(wrench / digits)
    for value, part in zip(
        values, np.array_split(np.arange(rows), len(values)), strict=True
    ):
        wrench[100 + part, 1] = value
    for held in (1, 25):  # repeated rows change nothing
        recording = correct(0).recording
        time = np.arange(1000.0 * held)
        stream = Stream(time, np.repeat(wrench, held, axis=0))
        log = replace(recording, streams={**recording.streams, "wrench": stream})
        message = dead_channel_message(log)
        assert (message is not None) == named
        if message is not None:
            assert message.startswith("fy often has one value,")

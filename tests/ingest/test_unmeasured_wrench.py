"""Stretches of the wrench that a stream repeated, having stalled."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import correct

from hefting import identify
from hefting.core.recording import Stream
from hefting.ingest.unmeasured import MANY_LEFT_OUT, without_stalled_wrench


def stalled(start, end, value="last"):
    """A correct recording whose wrench stands still from one share of it to another."""

    def change(_, wrench):
        first, last = (int(share * len(wrench)) for share in (start, end))
        wrench[first:last] = wrench[first] if value == "last" else value
        return wrench

    return correct(0).wrench(change)


@pytest.mark.parametrize(
    ("start", "end", "value"),
    [(0.0, 0.1, 0.0), (0.4, 0.55, "last"), (0.45, 1.0, "last"), (0.5, 1.0, 0.0)],
)
def test_what_a_stalled_stream_repeats_is_left_out(start, end, value):
    given = stalled(start, end, value)
    checked = without_stalled_wrench(given.recording)
    every, kept = given.recording["wrench"], checked["wrench"]
    assert len(every) - len(kept) == round((end - start) * len(every))
    (message,) = checked.warnings[len(given.recording.warnings) :]
    assert (message.code, message.severity) == ("wrench-stalled", "warning")
    found, clean = identify(given.recording), identify(correct(0).recording)
    low, high = clean.interval("mass")
    assert low < found.mass < high
    assert found.verdict.level == "usable with care"
    lost = [span for span in found.ingested.left_out if span.cause == "no-wrench"]
    first, last = (every.time[round(x * len(every)) - 1] for x in (start or 1e-3, end))
    assert min(span.start for span in lost) == pytest.approx(first, abs=0.05)
    assert max(span.end for span in lost) == pytest.approx(last, abs=0.05)


def test_a_short_stall_is_noted_only():
    given = stalled(0.5, 0.5 + 0.8 * MANY_LEFT_OUT)
    checked = without_stalled_wrench(given.recording)
    assert [note.code for note in checked.notes][-1:] == ["wrench-stalled"]
    assert checked.warnings == given.recording.warnings


def test_the_repeats_of_a_slow_stream_are_no_stall():
    recording = correct(0).recording
    wrench = recording["wrench"]
    held = wrench.values[np.arange(len(wrench)) // 20 * 20]
    slow = replace(
        recording, streams={**recording.streams, "wrench": Stream(wrench.time, held)}
    )
    assert without_stalled_wrench(slow) is slow


@pytest.mark.parametrize("step", [0.05, 0.5])
@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_a_body_at_rest_is_no_stall_where_rounding_hides_the_noise(step, noise):
    """Stop and go: a wrench that is rounded to more than its noise rests with the
    body."""
    time = np.arange(0.0, 10.0, 0.01)
    going = np.interp(time % 2.0, (0.0, 1.0, 2.0), (0.0, 1.0, 1.0)) + time // 2.0
    angle = 2.0 * np.pi * going / 5.0
    axes = np.arange(1.0, 7.0)
    wrench = 9.0 * np.sin(axes * angle[:, None] / 3.0)
    wrench += step * noise * np.random.default_rng(0).normal(size=wrench.shape)
    rounded = step * np.round(wrench / step)
    repeats = (rounded[1:] == rounded[:-1]).all(axis=1)
    assert any(repeats[k : k + 40].all() for k in range(len(repeats) - 40))
    recording = correct(0).recording
    streams = {**recording.streams, "wrench": Stream(time, rounded)}
    resting = replace(recording, streams=streams)
    assert without_stalled_wrench(resting) is resting


def test_a_correct_recording_stays_as_it_is():
    recording = correct(0).recording
    assert without_stalled_wrench(recording) is recording


@pytest.mark.parametrize("channels", [slice(0, 6), slice(3, 6), slice(2, 4)])
def test_a_number_that_stands_for_nothing_is_left_out(channels):
    """The answer is that of a recording that does not have those samples."""
    given = correct(0)
    every = given.recording["wrench"]
    blank = np.random.default_rng(0).uniform(size=len(every)) < 0.07

    def written(_, wrench):
        wrench[blank, channels] = -9999.0
        wrench[blank, 3] *= -1.0  # of a column map that negates it
        return wrench

    found = identify(given.wrench(written).recording)
    streams = {**given.recording.streams, "wrench": every[~blank]}
    assert found.mass == identify(replace(given.recording, streams=streams)).mass
    assert found.verdict.level == "good"
    assert "wrench-blank" in [note.code for note in found.ingested.notes]

"""`hefting.live`: estimates from a recording, a log or a source, one after the other."""

from collections import Counter

import numpy as np
import pandas as pd
import pytest
from benchmarks.online_streams import parts, swapped

import hefting
from hefting.logs import write_log
from hefting.online.samples import EndOfSource, SourceLostError


@pytest.fixture(scope="module")
def recording():
    return swapped(6, change=False, duration=4.0).recording


class Scripted:
    """Gives parts of a recording, and is lost once in between."""

    name = "scripted"
    chosen = ()

    def __init__(self, recording):
        self.skipped = Counter({"unreadable": 3})
        self._parts = list(parts(recording, 0.1))
        self._lost = False

    def open(self):
        """Nothing."""

    def close(self):
        """Nothing."""

    def read(self, timeout):
        if len(self._parts) == 20 and not self._lost:
            self._lost = True
            raise SourceLostError("the cable was pulled")
        if not self._parts:
            raise EndOfSource("that was all")
        return self._parts.pop(0)


def vector(estimate):
    return estimate.parameters.vector


def test_a_recording_as_fast_as_it_goes_ends_with_what_identify_finds(recording):
    said = list(hefting.live(recording, speed=np.inf))
    whole = hefting.identify(recording)
    np.testing.assert_allclose(
        vector(said[-1].estimate), vector(whole.estimate), rtol=1e-9
    )
    times = [each.time for each in said]
    assert times == sorted(times)
    assert 35 <= len(said) <= 45  # ten a second


def test_the_path_of_a_log_is_played(recording, tmp_path):
    path = tmp_path / "log.csv"
    write_log(recording, path)
    *_, last = hefting.live(path, speed=np.inf)
    assert last.estimate.mass == pytest.approx(hefting.identify(path).mass, rel=1e-9)


def test_a_data_frame_is_played(recording, tmp_path):
    write_log(recording, tmp_path / "log.csv")
    frame = pd.read_csv(tmp_path / "log.csv")
    *_, last = hefting.live(frame, speed=np.inf)
    assert last.estimate.mass == pytest.approx(hefting.identify(frame).mass, rel=1e-9)


def test_a_source_that_is_lost_goes_on_and_nothing_is_harmed(recording):
    tapped = Counter()

    def tap(samples):
        tapped[samples.stream] += len(samples.time)

    said = list(hefting.live(Scripted(recording), tap=tap))
    codes = hefting.core.messages.codes(said[-1].messages)
    assert {"source-lost", "source-back"} <= codes
    whole = hefting.identify(recording)
    np.testing.assert_allclose(
        vector(said[-1].estimate), vector(whole.estimate), rtol=1e-9
    )
    assert said[-1].counts["skipped"]["unreadable"] == 3
    assert tapped == {name: len(s) for name, s in recording.streams.items()}


def test_what_is_no_source_is_refused():
    with pytest.raises(
        hefting.InputError, match="int is not a recording; give the path"
    ):
        next(hefting.live(3))
    with pytest.raises(hefting.InputError, match="gopher"):
        next(hefting.live("gopher://robot"))

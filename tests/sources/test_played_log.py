"""A log that is played gives its samples, all of them, when their time has come."""

import time

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.recording import Recording, Stream
from hefting.online.samples import EndOfSource
from hefting.sources import Request
from hefting.sources.played_log import PlayedLog

RNG = np.random.default_rng(2)
RECORDING = Recording(
    {
        "wrench": Stream(100.0 + np.arange(500) / 500, RNG.normal(size=(500, 6))),
        "orientation": Stream(
            100.003 + np.arange(100) / 100, np.tile([0.0, 0.0, 0.0, 1.0], (100, 1))
        ),
    }
)


def played(source) -> dict[str, np.ndarray]:
    """All samples, by stream; each must be later than those before."""
    found: dict[str, list] = {}
    source.open()
    while True:
        try:
            some = source.read(0.01)
        except EndOfSource:
            break
        for samples in some:
            rows = np.column_stack([samples.time, samples.values])
            found.setdefault(samples.stream, []).append(rows)
    return {name: np.concatenate(parts) for name, parts in found.items()}


@pytest.mark.parametrize("speed", [np.inf, 20.0, 4.0])
def test_everything_is_played(speed):
    begin = time.monotonic()
    found = played(PlayedLog("log", Request(speed=speed), RECORDING))
    # never faster than asked
    assert time.monotonic() - begin >= RECORDING.duration / speed - 0.02
    for name, stream in RECORDING.streams.items():
        assert np.array_equal(found[name][:, 0], stream.time)
        assert np.array_equal(found[name][:, 1:], stream.values)


@pytest.mark.parametrize(
    ("speed", "how"),
    [(1.0, ""), (4.0, " at 4 times its speed"), (np.inf, " without pauses")],
)
def test_it_is_said_how_fast(speed, how):
    source = PlayedLog("log", Request(speed=speed), RECORDING)
    source.open()
    assert str(source.chosen[0]) == f"log is played{how}"


def test_streams_keep_together():
    """However fast: no stream is ahead of another by more than a step."""
    source = PlayedLog("log", Request(speed=np.inf), RECORDING)
    source.open()
    latest = dict.fromkeys(RECORDING.streams, 100.0)
    while max(latest.values()) < 100.9:
        for samples in source.read(0.01):
            latest[samples.stream] = samples.time[-1]
        assert np.ptp(list(latest.values())) <= 0.021


@pytest.mark.parametrize("speed", [0.0, -1.0, np.nan])
def test_speeds_that_cannot_be_are_refused(speed):
    with pytest.raises(InputError, match="give a speed above 0"):
        PlayedLog("log", Request(speed=speed), RECORDING)


def test_static_poses_are_refused():
    static = Recording(dict(RECORDING.slice(duration=0.1).streams), static=True)
    with pytest.raises(InputError, match="static poses have no times"):
        PlayedLog("log", Request(), static).open()


def test_a_log_that_is_not_there_is_told(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        PlayedLog(str(tmp_path / "no.csv"), Request()).open()

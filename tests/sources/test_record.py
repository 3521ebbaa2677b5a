"""What is recorded is read back as it came, also where the file was cut off."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.logs import read_log
from hefting.online.samples import Samples
from hefting.sources.record import Recorder

pytest.importorskip("foxglove", reason="a record needs foxglove-sdk")
pytest.importorskip("rosbags", reason="a record needs rosbags")
RNG = np.random.default_rng(7)
N = 400


def stream(rate: float, width: int, begin: float) -> tuple[np.ndarray, np.ndarray]:
    return begin + np.arange(N) / rate, RNG.normal(size=(N, width))


def streams(begin: float) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    time, position = stream(100, 3, begin)
    orientation = Rotation.random(N, rng=RNG).as_quat()
    return {
        "wrench": stream(500, 6, begin + 0.1),
        "position": (time, position),
        "orientation": (time, orientation),
        "joint_positions": stream(250, 7, begin),
        "gyroscope": stream(200, 3, begin),
    }


def in_order(given: dict) -> list[Samples]:
    """Samples one by one as they would come; pose halves after each other."""
    order = sorted(
        (time[k], i, name, k)
        for i, (name, (time, _)) in enumerate(given.items())
        for k in range(len(time))
    )
    return [
        Samples(name, given[name][0][k : k + 1], given[name][1][k : k + 1])
        for _, _, name, k in order
    ]


def agrees(path, given, names=None) -> bool:
    recording = read_log(path)
    assert set(recording.streams) == set(names or given)
    start = min(given[name][0][0] for name in recording.streams)
    for name, found in recording.streams.items():
        time, values = given[name]
        # a nanosecond, to which stamps are rounded; beside it what a float of the
        # size of the stamps can tell
        assert np.abs(found.time - (time - start)).max() <= 1.1e-9 + np.spacing(start)
        # quaternions are normalised when they are read
        assert np.abs(found.values - values).max() <= 1e-15
    return True


@pytest.mark.parametrize("begin", [0.0, 0.5, 12.0, 1_795_397_966.123])
def test_the_record_holds_what_came(begin, tmp_path):
    given = streams(begin)
    recorder = Recorder(tmp_path / "log.mcap")
    for samples in in_order(given):
        recorder.add(samples)
    recorder.close()
    recorder.close()
    assert recorder.paths == [tmp_path / "log.mcap"]
    assert not +recorder.left_out
    assert agrees(recorder.paths[0], given)


def test_orientations_alone_are_recorded(tmp_path):
    given = {k: v for k, v in streams(3.0).items() if k in ("wrench", "orientation")}
    recorder = Recorder(tmp_path / "log.mcap")
    for samples in in_order(given):
        recorder.add(samples)
    recorder.close()
    assert agrees(recorder.paths[0], given)


def test_positions_that_no_message_holds_are_counted(tmp_path):
    """Positions at other times than orientations."""
    given = streams(3.0)
    given["position"] = (given["position"][0] + 0.003, given["position"][1])
    recorder = Recorder(tmp_path / "log.mcap")
    for samples in in_order(given):
        recorder.add(samples)
    recorder.close()
    assert +recorder.left_out == {"position": N}
    assert agrees(recorder.paths[0], given, set(given) - {"position"})


@pytest.mark.parametrize("seconds", [0.2, 1.5, 4.0])
def test_nothing_is_lost_of_batches_of_any_length(seconds, tmp_path):
    """As of a pipe that is read fast: all positions of a batch, then all
    orientations."""
    given = streams(3.0)
    recorder = Recorder(tmp_path / "log.mcap")
    for begin in np.arange(3.0, 8.0, seconds):
        for name, (time, values) in given.items():
            part = (time >= begin) & (time < begin + seconds)
            if part.any():
                recorder.add(Samples(name, time[part], values[part]))
    recorder.close()
    assert not +recorder.left_out
    assert agrees(recorder.paths[0], given)


@pytest.mark.parametrize("late", ["position", "orientation"])
def test_halves_of_poses_may_come_in_different_batches(late, tmp_path):
    given = streams(3.0)
    recorder = Recorder(tmp_path / "log.mcap")
    due = [
        (time[k] + 0.5 * (name == late), name, slice(k, k + 30))
        for name, (time, _) in given.items()
        for k in range(0, N, 30)
    ]
    for _, name, part in sorted(due, key=lambda each: each[0]):
        recorder.add(Samples(name, *(values[part] for values in given[name])))
    recorder.close()
    assert not +recorder.left_out
    assert agrees(recorder.paths[0], given)


@pytest.mark.parametrize("begin", [0, N // 2])
def test_halves_without_another_are_counted_and_the_record_is_read(begin, tmp_path):
    """Readers take poses from one topic: the one that the file began with."""
    given = streams(3.0)
    there = np.arange(N) % 10 > 0
    there[:begin] = False
    time, values = given["position"]
    given["position"] = time[there], values[there]
    recorder = Recorder(tmp_path / "log.mcap")
    for samples in in_order(given):
        recorder.add(samples)
    recorder.close()
    if begin:
        assert +recorder.left_out == {"position": there.sum()}
        assert agrees(recorder.paths[0], given, set(given) - {"position"})
    else:
        assert +recorder.left_out == {"orientation": (~there).sum()}
        time, values = given["orientation"]
        given["orientation"] = time[there], values[there]
        assert agrees(recorder.paths[0], given)


def test_a_clock_that_is_set_back_begins_a_new_file(tmp_path):
    first, second = streams(5000.0), streams(1400.0)
    recorder = Recorder(tmp_path / "log.mcap")
    for samples in [*in_order(first), *in_order(second)]:
        recorder.add(samples)
    recorder.close()
    assert [path.name for path in recorder.paths] == ["log.mcap", "log-2.mcap"]
    assert agrees(recorder.paths[0], first)
    assert agrees(recorder.paths[1], second)


CUT = """
import os, signal, sys
import numpy as np
from hefting.online.samples import Samples
from hefting.sources.record import Recorder

recorder = Recorder(sys.argv[1])
time = np.arange(3000) / 500
for k, t in enumerate(time):
    recorder.add(Samples("wrench", time[k : k + 1], np.full((1, 6), k)))
    for name, values in (("position", (k, 0, 0)), ("orientation", (0, 0, 0, 1))):
        recorder.add(Samples(name, time[k : k + 1], np.array([values], float)))
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_a_record_that_was_cut_off_is_read_as_far_as_it_goes(tmp_path):
    path = tmp_path / "log.mcap"
    ended = subprocess.run([sys.executable, "-c", CUT, path], check=False)
    assert ended.returncode == -signal.SIGKILL
    recording = read_log(path)
    count = len(recording["wrench"])
    # 6 s: without a block of 0.1 s, and 8 kB that the writer holds, some 50 messages
    assert 3000 - 50 - 50 <= count < 3000
    assert np.array_equal(recording["wrench"].values[:, 0], np.arange(count))
    assert "bag-truncated" in [message.code for message in recording.warnings]


def test_files_that_cannot_be_written_are_refused(tmp_path):
    for name in ("log.csv", "no/folder/log.mcap"):
        with pytest.raises(InputError, match=name.partition("/")[0]):
            Recorder(tmp_path / name)
    (tmp_path / "folder.mcap").mkdir()
    with pytest.raises(InputError, match="no regular file"):
        Recorder(tmp_path / "folder.mcap")


@pytest.mark.skipif(os.name != "posix", reason="locks of POSIX")
def test_a_file_that_another_run_records_to_is_left_alone(tmp_path):
    given = streams(1.0)
    first = Recorder(tmp_path / "log.mcap")
    for samples in in_order(given)[:-1]:
        first.add(samples)
    with pytest.raises(InputError, match="written by another run"):
        Recorder(tmp_path / "log.mcap")
    first.add(in_order(given)[-1])
    first.close()
    assert agrees(tmp_path / "log.mcap", given)
    Recorder(tmp_path / "log.mcap").close()  # free again


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_disk_is_told(tmp_path, monkeypatch):
    from hefting.sources import record

    monkeypatch.setattr(record, "check_replaceable", lambda path: None)
    monkeypatch.setattr(record, "lock", lambda handle: True)  # several tests have it
    (tmp_path / "log.mcap").symlink_to("/dev/full")
    recorder = Recorder(tmp_path / "log.mcap")
    with pytest.raises(InputError, match="No space left"):  # as soon as it is
        list(map(recorder.add, in_order(streams(1.0))))
    with pytest.raises(InputError, match="No space left"):
        recorder.close()

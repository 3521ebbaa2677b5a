"""Recordings and estimates that lack something, files that cannot be written, and the
command."""

import os
import sys
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest

from commands import refused
from foxglove_files import held, numbers, read
from hefting.core.errors import InputError, MissingDependencyError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message
from hefting.core.recording import Recording, Stream
from hefting.dashboards import foxglove, replay_of, write_dashboard
from hefting.logs import read_log, write_log
from hefting.shapes import Shape

pytest.importorskip("foxglove")
pytest.importorskip("rosbags")


@pytest.fixture(scope="module")
def hammered():
    """The log of a hammer, and what was found from it."""
    log, estimate, _ = held()
    return log, estimate


def test_what_is_open_is_not_drawn_and_errors_are_errors(hammered, tmp_path):
    """The COM along one axis, and a message that makes the answer wrong."""
    log, estimate = hammered
    intervals = {k: np.array(v) for k, v in estimate.intervals.items()}
    intervals["center_of_mass"][:, 2] = -np.inf, np.inf
    intervals["inertia_at_com"][0], intervals["inertia_at_com"][1] = -np.inf, np.inf
    wrong = Message("no-object", "nothing is held: see `tool`", "error", "tool")
    doubtful = Estimate(
        method="LMI",
        parameters=estimate.parameters,
        samples=3,
        intervals=intervals,
        warnings=(wrong,),
    )
    box = Shape.from_box(-0.1, 0.1, -0.2, 0.2, 0.0, 0.1)
    replay = replay_of(log, doubtful, box)
    write_dashboard(replay, tmp_path / "a.mcap", lambda text: text.replace("`", "*"))
    found = read(tmp_path / "a.mcap")
    assert not {"/object/com", "/object/inertia"} & set(found.names)
    ((_, shape),) = found.topics["/object/shape"]
    (cube,) = shape.entities[0].cubes
    np.testing.assert_allclose(numbers(cube.size), (0.2, 0.4, 0.1), rtol=1e-12)
    np.testing.assert_allclose(numbers(cube.pose.position), (0, 0, 0.05), atol=1e-15)
    said = [m for _, m in found.topics["/log"]]
    assert said[0].level == 4  # foxglove.Log: ERROR
    (own,) = [m for m in said if m.name == "no-object"]
    assert (own.level, own.message) == (4, "nothing is held: see *tool*")


def test_points_of_a_cloud(hammered, tmp_path):
    log, estimate = hammered
    points = np.random.default_rng(2).uniform(-0.1, 0.1, (50, 3))
    replay = replay_of(log, estimate, Shape(points))
    write_dashboard(replay, tmp_path / "a.mcap")
    ((_, cloud),) = read(tmp_path / "a.mcap").topics["/object/points"]
    sent = np.frombuffer(cloud.data, "<f4").reshape(-1, cloud.point_stride // 4)
    np.testing.assert_array_equal(sent, points.astype("<f4"))


def test_orientation_alone_and_streams_without_a_message(hammered, tmp_path):
    log, estimate = hammered
    streams = dict(log.streams)
    time = streams.pop("position").time
    streams["linear_accelerometer"] = Stream(time, np.zeros((len(time), 3)))
    log = Recording(streams)
    replay = replay_of(log, estimate)
    lost = write_dashboard(replay, tmp_path / "a.mcap")
    assert lost == ("linear_accelerometer",)
    again = read_log(tmp_path / "a.mcap")
    np.testing.assert_array_equal(
        again["orientation"].values, log["orientation"].values
    )


def test_a_motion_without_a_wrench_has_what_is_predicted(hammered, tmp_path):
    log, estimate = hammered
    plan = Recording({n: s for n, s in log.streams.items() if n != "wrench"})
    write_dashboard(replay_of(plan, estimate), tmp_path / "a.mcap")
    names = read(tmp_path / "a.mcap").names
    assert "/predicted/force" in names
    assert not {"/wrench", "/measured/force", "/residual/force"} & set(names)


def test_whole_or_not_at_all(hammered, tmp_path, monkeypatch, capfd):
    """A disk that fills leaves what was there, and one line."""
    path = tmp_path / "a.mcap"
    path.write_bytes(b"old")

    class Full(foxglove.McapOutput):
        def __init__(self, stream):
            super().__init__(stream)
            self._stream = self

        def write(self, data):
            if self.error is None:
                self.error = OSError(28, "No space left on device")
            return len(data)

        def seek(self, offset, whence=0):
            return 0

    monkeypatch.setattr(foxglove, "McapOutput", Full)
    with pytest.raises(InputError, match="cannot be written") as caught:
        write_dashboard(replay_of(*hammered), path)
    assert "\n" not in str(caught.value)
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.mcap"]
    assert capfd.readouterr().err == ""


def test_errors_of_the_file_are_kept_and_not_repeated():
    class Stream:
        writes = 0

        def write(self, data):
            self.writes += 1
            raise OSError(28, "No space left on device")

    stream = Stream()
    output = foxglove.McapOutput(stream)
    assert [output.write(b"abc"), output.write(b"ab")] == [3, 2]
    assert stream.writes == 1
    assert output.error.errno == 28


def test_without_the_library_one_line_says_what_to_install(
    hammered, tmp_path, monkeypatch
):
    replay = replay_of(*hammered)
    for module in ("foxglove", "rosbags"):
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, module, None)
            with pytest.raises(MissingDependencyError, match=r"hefting\[live\]"):
                write_dashboard(replay, tmp_path / "a.mcap")
    assert not list(tmp_path.iterdir())


def test_static_poses_are_refused(hammered):
    log, estimate = hammered
    few = {
        name: Stream(np.arange(5.0), log[name].values[:5])
        for name in ("orientation", "wrench")
    }
    with pytest.raises(InputError, match="static poses have no times"):
        replay_of(Recording(few, static=True), estimate)


def test_gravity_is_that_of_the_estimate(hammered):
    """And any nonsense in an estimate's file is passed over."""
    gravity = np.array((0.5, 0.0, -9.7))
    log, estimate = hammered
    for said, used in (
        (gravity.tolist(), gravity),
        ("down", (0.0, 0.0, -9.80665)),
        ([0.0, 0.0, 0.0], (0.0, 0.0, -9.80665)),
        ({"x": 1}, (0.0, 0.0, -9.80665)),
    ):
        provenance = {**estimate.provenance, "gravity": said}
        changed = replace(estimate, provenance=provenance)
        found = replay_of(log, changed).prediction.gravity
        np.testing.assert_array_equal(found, used)


def test_the_command(hammered, run, tmp_path):
    log, estimate = hammered
    write_log(log, tmp_path / "log.csv")
    estimate.save(tmp_path / "hammer.json")
    box = "box:-0.05,0.05,-0.1,0.3,0,0.15"
    words = ["convert", tmp_path / "log.csv", tmp_path / "out.mcap"]
    status, out, err = run(
        *words, "--with", tmp_path / "hammer.json", "--shape", box, "--start", "1"
    )
    assert (status, err) == (0, "")
    assert f"verdict of {tmp_path / 'hammer.json'}: good" in out
    assert out.splitlines()[-1] == f"wrote {tmp_path / 'out.mcap'}"
    found = read(tmp_path / "out.mcap")
    assert found.topics["/object/shape"]
    assert len(found.topics["/tf"]) == len(log.slice(1.0)["orientation"])
    assert refused(run(*words, "--shape", box), "--shape: is for --with")
    assert refused(run(*words, "--hull"), "--hull: is for --with")
    wrong = Message("no-object", "nothing is held", "error")
    replace(estimate, warnings=(wrong,)).save(tmp_path / "wrong.json")
    status, out, _ = run(*words, "--with", tmp_path / "wrong.json")
    assert status == 3
    assert "do not use" in out
    assert refused(
        run(*words[:2], tmp_path / "out.csv", "--with", tmp_path / "hammer.json"),
        "'.csv' cannot hold an estimate",
        "use .mcap",
    )
    assert refused(
        run(*words[:2], tmp_path / "log.mcap", "--with", tmp_path / "log.csv"),
        "is not JSON",
    )
    assert refused(run("convert", "-", "a.mcap", "--with", "-"), "--with -")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_disk_that_shows_where_the_file_is_searched(hammered, monkeypatch):
    """Going to a place writes what waits, so that the library for the file saw the error,
    in a traceback."""

    @contextmanager
    def full(_):
        with open("/dev/full", "w+b") as stream:
            yield stream

    monkeypatch.setattr(foxglove, "replacing", full)
    with pytest.raises(OSError, match="No space left"):
        write_dashboard(replay_of(*hammered), "a.mcap")

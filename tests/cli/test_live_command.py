"""hefting live: played logs, pipes and sockets give the answer of hefting identify; what
cannot be used is refused in one line."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from commands import refused
from hefting.cli.report.live import fitting, line_of
from hefting.core.errors import InputError
from hefting.core.measurements import Noise
from hefting.core.recording import Recording
from hefting.identification import identify
from hefting.logs import write_log
from hefting.online import LiveEstimate, identifier
from hefting.online.process import Inline
from hefting.simulation import UR5, hammer, simulate, sinusoids
from hefting.sources import live as pumps

SECONDS = 4.0
POSE = np.array([[1.0, 0, 0, 0], [0, 0, 1, -0.08], [0, -1, 0, 0.06], [0, 0, 0, 1]])
KEYS = (
    "mass",
    "center_of_mass",
    "inertia_at_com",
    "intervals",
    "verdict",
    "covariance",
)
pytestmark = pytest.mark.usefixtures("same_commands")

LIVE = [sys.executable, "-m", "hefting", "live"]


@pytest.fixture(scope="module")
def recording() -> Recording:
    motion = UR5.motion(sinusoids(SECONDS, 100.0, 1.5))
    noise = {"noise": Noise(0.1, 0.005), "pose_noise": (1e-4, 3.5e-4), "seed": 3}
    return simulate(motion, hammer().parameters.moved(POSE), **noise)


@pytest.fixture(scope="module")
def log(recording, tmp_path_factory):
    path = tmp_path_factory.mktemp("live") / "log.csv"
    write_log(recording, path)
    return path


class Here(Inline):
    """In place of a process."""

    def close(self):
        """Nothing is to be ended."""


@pytest.fixture
def _here(monkeypatch):
    """What comes is understood in this process: another begins with half a second of
    imports."""
    monkeypatch.setattr(identifier, "Remote", Here)


def lines_of(recording: Recording) -> list[tuple[float, bytes]]:
    """The recording as lines of JSON, each with when it is due [s]."""
    entries: dict[float, dict] = {}
    for name, stream in recording.streams.items():
        for t, row in zip(stream.time.tolist(), stream.values.tolist(), strict=True):
            entries.setdefault(t, {"time": t})[name] = row
    return [
        (t - recording.start, json.dumps(entry).encode() + b"\n")
        for t, entry in sorted(entries.items())
    ]


def send(lines, write, speed: float) -> None:
    """Write lines when they are due."""
    begin = time.monotonic()
    for due, line in lines:
        time.sleep(max(begin + due / speed - time.monotonic(), 0.0))
        write(line)


def identified(run, log) -> dict:
    return json.loads(run("identify", log, "--json")[1])


def same(found: dict, expected: dict, tolerance=0.0) -> bool:
    """Whether two answers agree, numbers up to a tolerance that is relative."""
    for key in KEYS[:3]:
        scale = np.abs(np.array(expected[key])).max()
        assert np.allclose(found[key], expected[key], rtol=0, atol=tolerance * scale), (
            key
        )
    return True


@pytest.mark.usefixtures("_here")
def test_a_played_log_gives_the_answer_of_identify(run, log):
    status, out, err = run("live", log, "--speed", "8", "--json")
    assert status == 0, err
    *before, last = map(json.loads, out.splitlines())
    assert same(last, identified(run, log))
    assert last["state"] == "identified"
    assert last["counts"]["dropped"] == 0
    times = [entry["time"] for entry in before]
    assert times
    assert times == sorted(times)


def test_people_see_lines_and_then_the_answer(run, log):
    status, out, err = run("live", log, "--speed", "4")
    answer = run("identify", log)[1]
    assert status == 0
    assert out.endswith(answer)
    shown = out.removesuffix(answer).splitlines()
    assert shown
    assert all(" s: " in line and " samples" in line for line in shown)
    assert not any(" mm " in line and "is played" in line for line in shown)
    assert "is played at 4 times its speed" in err


def test_lines_count_samples_as_the_answer_does(recording):
    """Not those of all streams, unless there is no answer yet."""
    came = sum(map(len, recording.streams.values()))
    source = SimpleNamespace(skipped=Counter())
    pump = SimpleNamespace(counts={"samples": came}, source=source)
    estimate = identify(recording).estimate
    waiting = LiveEstimate(1.0, "waiting")
    found = replace(waiting, state="identified", estimate=estimate)
    assert line_of(waiting, pump, str).endswith(f"| {came} samples of all streams")
    assert line_of(found, pump, str).endswith(f"| {estimate.samples} samples")
    assert estimate.samples < came


PARTS = [
    *("5.6 s: identified", "usable with care"),
    *("0.671 ± 0.003 kg", "COM 1, 17, 84 ± 1 mm", "560 samples"),
]


@pytest.mark.parametrize(
    ("columns", "verdict", "shown"),
    [
        (96, PARTS[1], " | ".join(PARTS)),
        (80, PARTS[1], " | ".join(PARTS[:4])),
        (60, PARTS[1], " | ".join((PARTS[0], *PARTS[2:4]))),
        (40, PARTS[1], " | ".join((PARTS[0], PARTS[2]))),
        (20, PARTS[1], PARTS[0]),
        (15, PARTS[1], "5.6 s: iden ..."),
        (60, "do not use", " | ".join((PARTS[0], "do not use", PARTS[2]))),
    ],
)
def test_a_narrow_terminal_shows_whole_numbers(columns, verdict, shown):
    parts = [PARTS[0], verdict, *PARTS[2:]]
    assert fitting(parts, "", columns) == shown
    if columns < 96:
        assert (
            fitting(parts, "a message of some 40 letters, that is cut", columns)
            == shown
        )
    else:
        told = "a message of some 40 letters, that is cut"
        cut = fitting(parts, told, 120)
        assert cut.startswith(f"{shown} | a message of")
        assert cut.endswith(" ...")
        assert len(cut) == 120


@pytest.mark.usefixtures("_here")
def test_a_mistake_is_named_while_it_runs(run, recording, tmp_path):
    """Quaternions w, x, y, z: the numbers stand beside `do not use`."""
    turned = recording["orientation"]
    mistaken = replace(turned, values=turned.values[:, [3, 0, 1, 2]])
    streams = {**recording.streams, "orientation": mistaken}
    write_log(Recording(streams, source="live"), path := tmp_path / "log.csv")
    for speed in (2, 0.5, 0.1):  # so that a slow machine answers before the end, too
        _, out, err = run("live", path, "--speed", speed)
        if " | do not use | " in out:
            break
    assert " | do not use | " in out
    assert err.count("do not use: ") == 1


@pytest.mark.usefixtures("_here")
def test_the_record_gives_the_final_answer(run, log, tmp_path):
    pytest.importorskip("foxglove", reason="a record needs foxglove-sdk")
    path = tmp_path / "log.mcap"
    status, out, err = run("live", log, "--speed", "8", "--record", path, "--json")
    assert (status, f"wrote {path}" in err) == (0, True)
    last = json.loads(out.splitlines()[-1])
    # the bound; they are the same file's answer
    assert same(last, identified(run, path), 1e-9)


@pytest.mark.usefixtures("_here")
@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_record_that_cannot_be_written_leaves_the_answer(
    run, log, tmp_path, monkeypatch
):
    record = pytest.importorskip("hefting.sources.record")
    pytest.importorskip("foxglove", reason="a record needs foxglove-sdk")
    monkeypatch.setattr(record, "check_replaceable", lambda path: None)
    monkeypatch.setattr(record, "lock", lambda handle: True)  # several tests have it
    monkeypatch.setattr("hefting.cli.live.check_output", lambda *paths: None)
    (path := tmp_path / "log.mcap").symlink_to("/dev/full")
    found = tmp_path / "found.json"
    status, out, err = run(
        *("live", log, "--speed", "8", "--record", path, "--output", found, "--json")
    )
    assert status == 2
    assert err.count("recording stopped") == 1
    assert "No space left" in err
    assert same(json.loads(out.splitlines()[-1]), identified(run, log))
    assert json.loads(found.read_text())["mass"] > 0.0


@pytest.mark.usefixtures("_here")
@pytest.mark.parametrize("form", [(), ("--json",)])
def test_an_output_that_cannot_be_written_leaves_the_answer(
    run, log, monkeypatch, form
):
    """As the stream cannot be repeated."""

    def full(*_):
        raise InputError("cannot be written (No space left on device)", "a.json")

    monkeypatch.setattr("hefting.cli.live.write", full)
    status, out, err = run("live", log, "--speed", "100", "--output", "a.json", *form)
    assert (status, "No space left" in err) == (2, True)
    last = out.splitlines()[-1]
    assert json.loads(last)["mass"] > 0.0 if form else "verdict: good" in out


@pytest.mark.usefixtures("_here")
def test_an_output_that_is_left_out_is_in_the_exit_status(run, log, monkeypatch):
    """As of `hefting identify`: of an open inertia, say, no URDF is written."""
    monkeypatch.setattr("hefting.cli.live.wanted", lambda *_: [])
    words = ("live", log, "--speed", "100", "--output", "a.urdf")
    assert run(*words)[0] == 2


def test_a_pipe_is_read_to_its_end(recording, log, run):
    live = subprocess.Popen(
        [*LIVE, "-", "--json"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert live.stdin is not None
    lines = lines_of(recording)
    middle = len(lines) // 2
    lines.insert(middle, (lines[middle][0], b"nonsense\n"))
    send(lines, live.stdin.write, 8.0)
    out, _ = live.communicate(timeout=60)
    last = json.loads(out.splitlines()[-1])
    assert live.returncode == 0
    # CSV and JSON both write numbers so that they are read back to the last bit
    assert same(last, identified(run, log), 1e-9)
    samples = sum(map(len, recording.streams.values()))
    assert last["counts"]["samples"] == samples
    assert last["counts"]["skipped"] == {"not a JSON object": 1}


@pytest.mark.parametrize(
    ("given", "status", "said"),
    [
        (b"", 3, "no answer: no sample came in"),
        (b"nonsense\n" * 3, 2, "3 skipped (not a JSON object)"),
        (b'{"wrench": [0, 0, 1, 0, 0, 0]}\n', 2, "1 skipped (no time in seconds)"),
        (
            b'{"time": 0, "wrench": [0, 0, 1, 0, 0, 0]}\nnonsense\n',
            3,
            "1 skipped (not a JSON object)",
        ),
    ],
)
def test_a_pipe_without_an_answer_says_why(run, monkeypatch, given, status, said):
    read, write = os.pipe()
    os.write(write, given)
    os.close(write)
    with os.fdopen(read) as pipe:
        monkeypatch.setattr("sys.stdin", pipe)
        result = run("live", "-")
    assert result[0] == status
    assert said in result[2].splitlines()[-1]


@pytest.mark.skipif(os.name == "nt", reason="sends a signal of POSIX")
@pytest.mark.parametrize("stop", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_ctrl_c_ends_it_with_the_final_answer(recording, log, run, stop):
    """Typed when there is an answer from all samples; `timeout` asks by the second, a
    terminal that is closed by the third."""
    samples = sum(map(len, recording.streams.values()))
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        live = subprocess.Popen(
            [*LIVE, f"tcp://127.0.0.1:{port}", "--json"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert live.stdout is not None
        guard = threading.Timer(60.0, live.kill)
        guard.start()
        connection, _ = server.accept()
        with connection:
            send(lines_of(recording), connection.sendall, 8.0)
            entry = {}
            while "mass" not in entry or entry["counts"]["samples"] < samples:
                entry = json.loads(live.stdout.readline())
            live.send_signal(getattr(signal, stop))
            out, err = live.communicate(timeout=60)
        guard.cancel()
    assert live.returncode == 0, err
    assert "Traceback" not in err
    last = json.loads(out.splitlines()[-1])
    assert last["verdict"] == "good"
    assert last["counts"]["samples"] == samples
    # the keys that identify prints, and those of a stream, in each line with an answer
    expected = set(identified(run, log)) | {"state", "sufficient", "time"}
    assert expected <= set(entry)
    assert expected <= set(last)


@pytest.mark.usefixtures("_here")
def test_what_a_robot_takes_is_printed_at_the_end(run, log):
    status, out, _ = run(
        "live", log, "--speed", "8", "--export-to", "ur", "--mass", "0.67kg±5g"
    )
    assert status == 0
    assert "set_target_payload(" in out.splitlines()[-1] or "set_target_payload(" in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("http://robot",), "is no source"),
        (("tcp://127.0.0.1:1",), "cannot be reached"),
        (("rtde://127.0.0.1:1",), "cannot be reached"),
        (("dds://300",), "0 to 232"),
        (("none.csv",), "does not exist"),
        (("-", "--rate", "0"), "rate"),
        (("-", "--until", "mass=1kg"), "--until"),
        (("-", "--output", "mug.docx"), "not an output format"),
        (("-", "--record", "log.csv"), "log.mcap"),
        (("-", "--export-to", "urr"), "--export-to"),
        (("-", "--urdf", "robot.urdf"), "--sensor-frame"),
        (("-", "--map", "map.toml"), "is for logs"),
        (("-", "--speed", "10"), "is for logs"),
        (("-", "--export-to", "ur", "--sensor-pose-in-flange", "0,x"), "seven numbers"),
        (("-", "--sensor-pose-in-flange", "0,0,0.1"), "give --output"),
        (("-", "--sensor-turned", "45"), "'45' is no turn"),
        (("-", "--sensor-turned", "z:4", "--sensor-pose-in-log", "p"), "give one of"),
        (("-", "--speed", "inf"), "--speed"),
        (("-", "--bias", "tare:0,2"), "'tare:0,2' is for recordings"),
    ],
)
def test_what_cannot_be_used_is_refused(run, words, said):
    assert refused(run("live", *words), said)


def test_silence_is_an_error(run, monkeypatch):
    """After 5 s; here sooner, as the test would wait as long."""
    monkeypatch.setattr(pumps, "Pump", partial(pumps.Pump, patience=0.2))
    with socket.create_server(("127.0.0.1", 0)) as server:
        accepted = []
        port = server.getsockname()[1]
        thread = threading.Thread(target=lambda: accepted.append(server.accept()))
        thread.start()
        result = run("live", f"tcp://127.0.0.1:{port}")
        thread.join()
        accepted[0][0].close()
    said = result[2].splitlines()[-1]
    assert result[0] == 2
    assert "nothing arrives for 0.2 s" in said


@pytest.mark.parametrize(
    ("name", "module"),
    [("ws://127.0.0.1:1", "websockets.sync.client"), ("dds://0", "cyclonedds.builtin")],
)
def test_a_missing_extra_is_told(run, name, module, monkeypatch):
    monkeypatch.setitem(sys.modules, module, None)
    assert refused(run("live", name), "pip install 'hefting[live]'")

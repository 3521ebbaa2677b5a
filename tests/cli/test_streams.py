"""What reaches a command from outside: standard input, pipes, Ctrl-C; and how it reports
its progress."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from threading import Thread

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import feather
from scipy.io import savemat

from commands import refused
from hefting.cli.progress import STAGES, Display
from hefting.core.progress import each, listening, report
from hefting.identification import identify
from hefting.logs import read_log, write_log
from hefting.simulation import UR5, hammer, simulate, sinusoids

posix = pytest.mark.skipif(os.name != "posix", reason="needs pipes and signals")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A log in several formats, and an estimate."""
    folder = tmp_path_factory.mktemp("streams")
    log = simulate(UR5.motion(sinusoids(4.0, 50.0, 1.0)), hammer().parameters)
    for name in ("log.csv", "log.parquet", "log.mcap"):
        write_log(log, folder / name)
    identify(folder / "log.csv").estimate.save(folder / "e.json")
    return folder


def hefting(*words, **settings):
    """A command in a process of its own."""
    command = [sys.executable, "-m", "hefting", *map(str, words)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **settings
    )


@pytest.fixture
def fed(run, monkeypatch):
    """Run a command in this process with bytes in the pipe that is its standard input:
    status, output, errors."""

    def fed(data: bytes, *words) -> tuple[int, str, str]:
        read, write = os.pipe()

        def send():
            with suppress(BrokenPipeError), open(write, "wb") as end:
                end.write(data)

        thread = Thread(target=send)
        thread.start()
        with open(read, "rb") as end:
            monkeypatch.setattr(sys, "stdin", end)
            result = run(*words)
        thread.join()
        return result

    return fed


def test_json_lines_matlab_and_arrow_are_known_by_their_first_bytes(
    folder, fed, tmp_path
):
    recording = read_log(folder / "log.csv")
    held = {name: stream.values for name, stream in recording.streams.items()}
    held |= {"time": recording["wrench"].time}
    savemat(tmp_path / "log.mat", held)
    lines = (
        {k: v[j].tolist() for k, v in held.items()} for j in range(len(held["time"]))
    )
    (tmp_path / "log.jsonl").write_text("\n".join(map(json.dumps, lines)))
    columns = {k: v.tolist() for k, v in held.items()}
    feather.write_feather(pa.table(columns), str(tmp_path / "log.feather"))
    for name in ("log.mat", "log.jsonl", "log.feather"):
        status, out, _ = fed((tmp_path / name).read_bytes(), "inspect", "-", "--json")
        assert status == 0
        assert json.loads(out)["duration"] == recording.duration


@pytest.mark.parametrize("name", ["log.csv", "log.parquet", "log.mcap"])
def test_a_log_from_standard_input_is_the_same(folder, fed, name):
    status, out, err = fed((folder / name).read_bytes(), "identify", "-", "--json")
    assert (status, err) == (0, "")
    direct = identify(folder / name).estimate
    # the same bytes: nothing may differ
    assert json.loads(out)["vector"] == direct.parameters.vector.tolist()
    assert "hefting-" not in out  # no word of where it was kept


def test_an_estimate_from_standard_input(folder, fed):
    data = (folder / "e.json").read_bytes()
    assert fed(data, "export", "-", "--to", "urdf")[0] == 0
    told = fed(data, "predict", "-", folder / "log.csv", "--json")
    assert told[0] == 0
    same = fed(data, "compare", "-", folder / "e.json", "--json")
    assert (same[0], json.loads(same[1])["agree"]) == (0, True)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", ("standard input: is empty",)),
        (b"a,b\n1,2\n", ("standard input: there is no wrench",)),
        (b"PAR1 and no more", ("standard input",)),
        (b"\x1f\x8b\x08 a", ("standard input: is packed with gzip",)),
    ],
)
def test_what_standard_input_cannot_be(fed, data, words):
    result = fed(data, "inspect", "-")
    assert refused(result, *words)
    assert "/" not in result[2].split(";")[0]


@posix
@pytest.mark.parametrize(
    "words",
    [
        ("identify", "{}.csv"),
        ("identify", "{}.mcap"),
        ("identify", "log.csv", "--map", "{}.toml"),
        ("identify", "log.csv", "--shape", "{}.stl"),
        ("identify", "log.csv", "--truth", "{}.json"),
        ("identify", "log.csv", "--tool", "{}.json"),
        ("identify", "log.csv", "--bias", "{}.json"),
        ("identify", "log.csv", "--urdf", "{}.urdf", "--sensor-frame", "a"),
        ("identify", "log.csv", "--output", "{}.json"),
        ("export", "{}.json", "--to", "urdf"),
        ("export", "e.json", "--to", "urdf", "--into", "{}.urdf", "--link", "a"),
        ("export", "e.json", "--to", "urdf", "--output", "{}.urdf"),
        ("predict", "{}.json", "log.csv"),
        ("map", "{}.csv"),
        ("simulate", "{}.csv"),
    ],
)
def test_nothing_waits_for_a_pipe(run, folder, tmp_path, monkeypatch, words):
    """Were it opened, this test would never end."""
    monkeypatch.chdir(folder)
    named = next(word for word in words if "{}" in word)
    pipe = tmp_path / named.format("pipe")
    os.mkfifo(pipe)
    result = run(*(pipe if word is named else word for word in words))
    assert refused(result, pipe.name)


@posix
def test_an_interrupt_ends_with_130(folder):
    """While it waits for standard input, so that there is something to interrupt."""
    process = hefting("inspect", "-", stdin=subprocess.PIPE)
    time.sleep(0.1)
    deadline = time.monotonic() + 30.0
    while process.poll() is None and time.monotonic() < deadline:
        if b"cli" in _modules_of(process.pid):
            process.send_signal(signal.SIGINT)
            break
        time.sleep(0.05)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert err == b"hefting: stopped\n"


def _modules_of(pid: int) -> bytes:
    """``b"cli"`` once the process waits: it sleeps in a read of a pipe."""
    try:
        with open(f"/proc/{pid}/wchan", "rb") as state:
            return b"cli" if b"pipe" in state.read() else b""
    except OSError:
        pytest.skip("the system does not tell what a process waits for")


def test_reports_reach_the_listener_alone():
    heard = []
    report("unheard", 0.5)
    with listening(lambda stage, share: heard.append((stage, share))):
        assert list(each("stage", [7, 8])) == [7, 8]
    report("unheard", 1.0)
    assert heard == [("stage", 0.0), ("stage", 0.5)]


def test_an_identification_reports_its_stages_in_order(folder):
    heard = []
    with listening(lambda stage, _: heard.append(stage)):
        identify(folder / "log.csv")
    stages = list(dict.fromkeys(heard))
    assert [stage for stage in STAGES if stage in stages] == stages
    assert {"reading the log", "identifying"} <= set(stages)


def test_the_share_never_goes_back():
    display = Display("begin", {"a": 1.0, "b": 3.0})
    shares = []
    for stage, share in (("a", 0.5), ("b", None), ("b", 0.5), ("a", 0.1), ("c", None)):
        display(stage, share)
        shares.append(display.share)
    display.close()
    np.testing.assert_allclose(shares, [0.125, 0.25, 0.625, 0.625, 0.625])

"""hefting view: a process that listens on this machine alone until Ctrl-C, and a player
in a file."""

import os
import re
import signal
import socket
import subprocess
import sys
import urllib.request

import pytest

from hefting.logs import write_log
from viewing import held, recorded, write_arm

pytest.importorskip("viser")
PATIENCE = 60.0
"""[s] for a process to begin or to end on a machine with much to do."""
BOX = "box:-0.05,0.05,-0.1,0.3,0,0.15"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("view")
    write_log(recorded(), folder / "log.csv")
    held().mesh().export(folder / "hammer.stl")
    write_arm(folder)
    return folder


def interruptible():
    """What a shell does for a command in the foreground: Ctrl-C reaches it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def listening_at(pid):
    """Addresses and ports at which a process listens, by what Linux says."""
    inodes = set()
    for name in os.listdir(f"/proc/{pid}/fd"):
        try:
            target = os.readlink(f"/proc/{pid}/fd/{name}")
        except OSError:
            continue
        inodes |= set(re.findall(r"socket:\[(\d+)\]", target))
    found = []
    for table in ("tcp", "tcp6"):
        with open(f"/proc/{pid}/net/{table}") as lines:
            for line in list(lines)[1:]:
                fields = line.split()
                if fields[3] == "0A" and fields[9] in inodes:  # LISTEN
                    found.append(fields[1])
    return found


def test_it_listens_here_alone_until_ctrl_c(folder):
    process = subprocess.Popen(
        [sys.executable, "-m", "hefting", "view", "log.csv", "--no-browser"],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=interruptible,
    )
    try:
        line = process.stdout.readline()
        port = int(re.fullmatch(r"viewer at http://127\.0\.0\.1:(\d+) .*\n", line)[1])
        if os.path.isdir("/proc"):
            assert listening_at(process.pid) == [f"0100007F:{port:04X}"]
        page = urllib.request.urlopen(f"http://127.0.0.1:{port}", timeout=PATIENCE)
        assert b"<html" in page.read()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 130
    assert err == "hefting: stopped\n"
    assert out == ""
    with socket.create_server(("127.0.0.1", port)):  # the port is free again
        pass


def test_the_player_of_an_arm_is_one_file(folder, run, monkeypatch):
    monkeypatch.chdir(folder)
    status, out, err = run(
        *("view", "log.csv", "--urdf", "ur5.urdf", "--sensor-frame", "tool0"),
        *(
            "--shape",
            "hammer.stl",
            "--object-pose",
            "0,-0.08,0.06,-0.7071068,0,0,0.7071068",
        ),
        *("--method", "PMD", "--c1", "5", "--save", "player.html"),
    )
    assert (status, out, err) == (0, "wrote player.html\n", "")
    page = (folder / "player.html").read_text()
    assert "PMD, all of 4.99 s, 500 samples" in page
    assert "verdict: good" in page
    assert not re.search(r"(src|href)=[\"']?https?:", page)


def test_an_estimate_is_shown_as_it_is(folder, run, monkeypatch):
    monkeypatch.chdir(folder)
    assert run("identify", "log.csv", "--method", "OLS", "--output", "o.json")[0] == 0
    status, out, _ = run("view", "log.csv", "--estimate", "o.json", "--save", "o.html")
    assert (status, out) == (0, "wrote o.html\n")
    assert "OLS, all of" in (folder / "o.html").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("none.csv",), "hefting: none.csv: does not exist\n"),
        (("log.csv", "--save", "player.pdf"), "a player is a .html file"),
        (("log.csv", "--save", "log.csv"), "a player is a .html file"),
        (("log.csv", "--save", "nowhere/p.html"), "the folder does not exist"),
        (("log.csv", "--save", "p.html", "--port", "8080"), "a player has no server"),
        (
            ("log.csv", "--save", "p.html", "--host", "0.0.0.0"),
            "a player has no server",
        ),
        (("log.csv", "--method", "PMD"), "PMD needs a shape"),
        (("log.csv", "--method", "bayse"), "unknown method 'bayse'"),
        (("log.csv", "--port", "70000"), "--port: 70000 is no port"),
        (("log.csv", "--host", "192.0.2.1"), "cannot listen at 192.0.2.1"),
        (("log.csv", "--urdf", "ur5.urdf"), "which link holds the sensor?"),
        (("log.csv", "--truth", "log.csv"), "log.csv: is not JSON"),
        (("log.csv", "--shape", BOX, "--unit", "ft"), "unit"),
    ],
)
def test_what_cannot_be_shown_is_one_line(folder, run, monkeypatch, words, message):
    monkeypatch.chdir(folder)
    status, out, err = run("view", *words)
    assert status == 2
    assert out == ""
    assert message in err
    assert len(err.splitlines()) == 1

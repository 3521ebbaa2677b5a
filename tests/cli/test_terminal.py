"""The README's commands in a real terminal of 80 columns, as kept in
``transcripts/terminal.txt``; after a change, ``python tests/terminal.py`` writes it anew,
to be looked at."""

import json
import re
import shlex
import sys

import pytest

if sys.platform == "win32":
    pytest.skip("there are no such terminals", allow_module_level=True)

from hefting.cli.progress import STAGES
from terminal import (
    COLUMNS,
    ROWS,
    TRANSCRIPT,
    readme_commands,
    run,
    text_of,
    transcript,
)
from transcripts import masked

SHAPE = (
    "--shape demo/hammer.stl --unit mm "
    "--object-pose 0,-0.08,0.06,-0.7071068,0,0,0.7071068"
)
TEXT_OF_A_FILE = ("export",)
"""Commands whose output is the text of a file, as wide as it is."""
LONGER = ("methods",)
"""Commands that list something, longer than a screen."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("terminal")


@pytest.fixture(scope="module")
def sessions(folder):
    """Each of the README's commands and what it wrote."""
    return transcript(folder)


@pytest.fixture(scope="module")
def made(folder, sessions):
    """The folder where the demo has been made."""
    assert (folder / "demo" / "log.csv").exists()
    return folder


def test_the_screens_are_those_that_are_kept(sessions):
    now, kept = text_of(sessions), TRANSCRIPT.read_text()
    assert masked(now) == masked(kept), now


def test_they_are_the_readmes_commands():
    first = [shlex.split(command)[0] for command in readme_commands()]
    assert {"inspect", "show", "identify", "export", "check", "predict"} <= set(first)


def test_nothing_is_wider_than_the_screen(sessions):
    """A line of more would be broken by the terminal anywhere."""
    for command, session in sessions.items():
        assert session.status == 0
        if shlex.split(command)[0] not in TEXT_OF_A_FILE:
            wide = [line for line in session.lines if len(line) > COLUMNS]
            assert not wide, command


def test_each_answer_fits_one_screen(sessions):
    for command, session in sessions.items():
        if shlex.split(command)[0] not in LONGER:
            assert len(session.lines) <= ROWS, command


def shares_of(stage, states):
    """Shares [%] of a stage, one after the other."""
    return [
        int(re.findall(r"(\d+)%", state)[0])
        for state in states
        if stage in state and "%" in state
    ]


def test_progress_moves_and_is_gone_at_the_end(made):
    """Stages, a share that grows, the line erased. What is seen of a second's work depends
    on the machine: the line is drawn anew ten times a second."""
    session = run(f"identify demo/log.csv --method all {SHAPE}", made, patience=0.0)
    assert session.status == 0
    states = session.states
    assert all(len(state) <= COLUMNS for state in states)
    assert any("left" in state for state in states)
    shares = {name: shares_of(name, states) for name in STAGES}
    assert len({share for each in shares.values() for share in each}) >= 3, states
    assert all(each == sorted(each) for each in shares.values())
    stages = {name for name in STAGES if any(name in state for state in states)}
    assert len(stages) >= 2, states
    # erased after what was drawn last
    assert "\x1b[2K" in session.err[session.err.rindex("%") :]


@pytest.mark.parametrize(
    ("options", "err_is_terminal"), [("--json", True), ("", False)]
)
def test_it_is_silent_for_machines(made, options, err_is_terminal):
    """With --json in a terminal, and where standard error is a pipe."""
    command = f"identify demo/log.csv {options}"
    session = run(command, made, patience=0.0, err_is_terminal=err_is_terminal)
    assert (session.status, session.err) == (0, "")
    if options:
        assert json.loads(session.out)["verdict"] == "good"


def test_what_takes_less_than_a_second_shows_none(made):
    assert run("check --help", made).err == ""

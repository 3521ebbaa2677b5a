"""Understanding in another process: as in this one; whatever happens to it."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from benchmarks.online_streams import swapped

from hefting.core.errors import HeftingError
from hefting.online.process import Inline, Remote
from hefting.online.understanding import Settings, Task

PATIENCE = 120.0
"""[s] A process begins and understands in a few; machines may be busy."""


def answer_of(remote):
    began = time.monotonic()
    while time.monotonic() - began < PATIENCE:
        found = remote.answer()
        if found is not None or not remote.busy:
            return found
        time.sleep(0.01)
    raise AssertionError("no answer came")


@pytest.fixture
def remote():
    made = Remote(Settings())
    yield made
    made.close()


@pytest.fixture(scope="module")
def task():
    return Task(swapped(1, change=False, duration=4.0).recording)


def test_the_answer_is_that_of_this_process(remote, task):
    here = Inline(Settings())
    here.ask(task)
    remote.ask(task)
    assert remote.busy
    there = answer_of(remote)
    assert not remote.busy
    expected = here.answer().estimate.parameters.vector
    assert np.array_equal(there.estimate.parameters.vector, expected)


def test_a_dead_process_begins_again_with_the_next_task(remote, task):
    remote._process.kill()
    remote._process.wait()
    remote.ask(task)
    assert answer_of(remote).estimate is not None


def test_one_that_dies_meanwhile_is_not_waited_for(remote, task):
    remote.ask(task)
    remote._process.kill()
    assert answer_of(remote) is None
    assert not remote.busy


@pytest.mark.skipif(sys.platform == "win32", reason="sessions are of POSIX")
def test_a_terminals_interrupt_is_not_for_it(remote):
    """Ctrl-C goes to every process of a terminal's session; it would print a
    traceback, and its work be lost."""
    assert os.getsid(remote._process.pid) != os.getsid(0)


def test_what_fails_there_is_raised_here(remote):
    remote.ask("no task")
    with pytest.raises(HeftingError, match="AttributeError"):
        answer_of(remote)


def test_a_script_without_a_guard_is_not_run_again(tmp_path):
    """As `multiprocessing` would: it may drive a robot."""
    script = tmp_path / "script.py"
    script.write_text(
        "import hefting\n"
        "print('moves the robot')\n"
        "with hefting.LiveIdentifier() as live:\n"
        "    live.add('wrench', 0.0, [0.0] * 6)\n"
        "    live.wait(5.0)\n"
    )
    run = [sys.executable, str(script)]
    done = subprocess.run(run, capture_output=True, text=True, check=True)
    assert done.stdout.split("\n") == ["moves the robot", ""]

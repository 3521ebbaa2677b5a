"""Checks: a message is a function and its line in `CHECKS`; library, command and its
output for machines give it."""

import json

import pytest

from hefting.core.messages import Message, warning
from hefting.identification import checks, identify
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, random_smooth, simulate


def toy(checked):
    """A check that warns of everything."""
    mass = checked.estimate.parameters.mass
    return [warning("toy-heavy", f"{mass:.3g} kg is much: check `gravity`", "gravity")]


@pytest.fixture
def log(tmp_path):
    motion = UR5.motion(random_smooth(3.0, 100.0, 1.0, 1))
    write_log(simulate(motion, hammer().parameters, exact=True), tmp_path / "log.csv")
    return tmp_path / "log.csv"


def test_a_new_message_is_given_everywhere(monkeypatch, run, log):
    monkeypatch.setattr(checks, "CHECKS", [*checks.CHECKS, toy])
    last = identify(log).estimate.warnings[-1]
    assert isinstance(last, Message)
    assert (last.code, last.severity, last.argument) == (
        "toy-heavy",
        "warning",
        "gravity",
    )
    assert "check `gravity`" in last
    _, shown, _ = run("identify", log)
    assert "check --gravity" in " ".join(shown.split())
    _, printed, _ = run("identify", log, "--json")
    codes = {message["code"] for message in json.loads(printed)["messages"]}
    assert "toy-heavy" in codes


def test_without_it_nobody_knows_it(log):
    codes = {
        getattr(message, "code", "") for message in identify(log).estimate.warnings
    }
    assert "toy-heavy" not in codes

"""How the command starts, and how it says what the library says."""

import argparse
import json
import os
import subprocess
import sys
from importlib import import_module

import pytest

from commands import refused
from hefting.cli import COMMANDS, OPTIONS, build_parser, render
from hefting.core.measurements import NOISE_LEVELS
from hefting.logs import write_log
from hefting.simulation import UR5, hammer, random_smooth, simulate


def options_of(command: str) -> set[str]:
    parser = build_parser([command])
    (commands,) = (
        action
        for action in parser._actions
        if action.dest == "==SUPPRESS==" or action.choices
    )
    return {
        option
        for action in commands.choices[command]._actions
        for option in action.option_strings
    }


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_each_command_is_in_its_file_too(name):
    first = (import_module(f"hefting.cli.{name}").__doc__ or "").split("\n\n")[0]
    assert " ".join(first.split()) == f"hefting {name}: {COMMANDS[name]}"


def test_help_names_all_commands_and_one_has_its_options(run):
    status, out, err = run("--help")
    assert (status, err) == (0, "")
    words = " ".join(out.split())
    for name, text in COMMANDS.items():
        assert f"{name} {text}" in words
    assert "--pose-std" in run("identify", "--help")[1]
    assert "--pose-std" not in run("export", "--help")[1]


def test_bad_usage(run):
    assert refused(
        run("identfy", "log.csv"), "identfy", "identify", "see hefting --help"
    )
    assert refused(run(), "COMMAND")
    assert refused(run("--log", "a.csv"), "see hefting --help")
    assert refused(run("identify"), "LOG", "see hefting identify --help")


def test_only_the_chosen_command_is_imported():
    code = (
        "import sys; sys.argv = ['hefting', 'export', '--help']\n"
        "try:\n    from hefting.cli import main; main()\nexcept SystemExit:\n    pass\n"
        "print('modules:', *(m for m in sys.modules if m.startswith('hefting.cli.')))"
    )
    out = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout
    assert set(out.splitlines()[-1].split()[1:]) == {
        "hefting.cli.export",
        "hefting.cli.options",
        "hefting.cli.parser",
        "hefting.cli.standard_input",
    }


def test_an_identification_imports_only_what_it_uses(tmp_path):
    """`numpy.ma` takes as long to import as a fifth of the package."""
    motion = UR5.motion(random_smooth(2.0, 100.0, 1.0, seed=5))
    noise = NOISE_LEVELS["moderate"]
    log = tmp_path / "log.csv"
    write_log(simulate(motion, hammer().parameters, noise=noise, seed=6), log)
    code = (
        f"import sys; sys.argv = ['hefting', 'identify', {str(log)!r}]\n"
        "try:\n    from hefting.cli import main; main()\nexcept SystemExit:\n    pass\n"
        "print('modules:', *sys.modules)"
    )
    out = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    ).stdout
    imported = set(out.splitlines()[-1].split()[1:])
    assert "hefting.identification.identify" in imported
    unused = ("export", "logs.memory_table", "motion.kalman", "online", "plots")
    unused = {"numpy.ma", *(f"hefting.{name}" for name in unused)}
    assert not unused & imported


def threads(given: dict[str, str], before: str = "") -> str:
    """What the environment says to linear algebra that the command loads."""
    code = (
        f"import os, sys; sys.argv = ['hefting', 'methods']\n{before}\n"
        "import hefting.cli; hefting.cli.main()\n"
        "assert 'numpy' in sys.modules\n"
        "print(os.environ.get('OPENBLAS_NUM_THREADS'))"
    )
    environment = {k: v for k, v in os.environ.items() if "_NUM_THREADS" not in k}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=environment | given,
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout.splitlines()[-1]


def test_linear_algebra_has_one_thread():
    assert threads({}) == "1"


def test_threads_are_left_to_whoever_chose_them():
    assert threads({"OMP_NUM_THREADS": "2"}) == "None"
    assert threads({}, before="import numpy") == "None"


def test_help_is_printed_where_the_encoding_has_no_plus_minus():
    done = subprocess.run(
        [sys.executable, "-m", "hefting", "identify", "--help"],
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"1g" in done.stdout


@pytest.mark.parametrize(
    ("text", "rendered"),
    [
        ("check `gravity`", "check --gravity"),
        ("give `unit`='mm'", "give --unit mm"),
        ("(`column_map`=FILE)", "(--map FILE)"),
        (
            "check the shape's `pose`; or `start`, `duration`.",
            "check the shape's --object-pose; or --start, --duration.",
        ),
        ("`start`=2.5.", "--start 2.5."),
        (
            "(`sensor_pose_in_flange`=x,y,z,qx,qy,qz,qw)",
            "(--sensor-pose-in-flange x,y,z,qx,qy,qz,qw)",
        ),
        (
            "`wrench`='on-object' or `wrench`='on-sensor'",
            "--wrench on-object or --wrench on-sensor",
        ),
        ("column `qx` by `from_hull`", "column `qx` by `from_hull`"),
        ("nothing to say", "nothing to say"),
        ("an odd ` stays, `unit", "an odd ` stays, `unit"),
    ],
)
def test_arguments_become_options(text, rendered):
    assert render(text) == rendered
    assert json.loads(render(json.dumps({"a": [text, 1.5]}))) == {"a": [rendered, 1.5]}


def test_the_options_exist():
    known = set().union(*map(options_of, ("identify", "export", "plan", "batch")))
    assert set(OPTIONS.values()) <= known


def test_nothing_printed_names_an_argument(run, tmp_path):
    (tmp_path / "log.csv").write_text("time,qx,qy,qz,qw\n0,0,0,0,1\n")
    assert refused(run("identify", tmp_path / "log.csv"), "column map (--map FILE;")
    assert refused(
        run("convert", tmp_path / "log.csv", tmp_path / "a.csv", "--imu-topic", "/i"),
        "--imu-topic is for bags",
    )


@pytest.mark.parametrize("name", COMMANDS)
def test_help_can_be_formatted_when_an_argument_is_added(name, monkeypatch):
    """As argparse does from Python 3.14 on: it refuses what it cannot format."""
    added = argparse._ActionsContainer.add_argument

    def and_formatted(self, *words, **settings):
        action = added(self, *words, **settings)
        if action.help and hasattr(self, "_get_formatter"):
            self._get_formatter()._expand_help(action)
        return action

    monkeypatch.setattr(argparse._ActionsContainer, "add_argument", and_formatted)
    build_parser([name])

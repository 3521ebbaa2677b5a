"""Completion in shells, and help on what was mistyped."""

import subprocess
from shutil import which

import pytest

from hefting.cli import COMMANDS, build_whole_parser, commands_of
from hefting.cli.parser import did_you_mean


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_and_option_is_in_the_script(run, shell):
    status, out, err = run("completion", shell)
    assert (status, err) == (0, "")
    for name, parser in commands_of(build_whole_parser()).items():
        assert name in out
        for action in parser._actions:
            for option in action.option_strings:
                assert option.lstrip("-") in out


@pytest.mark.skipif(which("bash") is None, reason="there is no bash")
def test_bash_completes(run, tmp_path):
    (tmp_path / "script").write_text(run("completion", "bash")[1])
    typed = (
        'source "$0"; COMP_WORDS=(hefting identify --object-); COMP_CWORD=2;'
        '_shtab_hefting 2>/dev/null; echo "${COMPREPLY[@]}"'
    )
    command = ["bash", "-c", typed, str(tmp_path / "script")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == "--object-pose\n"


def test_what_was_meant():
    assert did_you_mean("identfy", COMMANDS) == " (did you mean identify?)"
    assert did_you_mean("--Object_Pose", ["--object-pose"]).endswith("-pose?)")
    assert did_you_mean("--zzz", ["--shape"]) == ""


def test_all_unknown_options_in_one_message(run):
    status, _, err = run("inspect", "log.csv", "--grvity", "x", "--jsn")
    assert status == 2
    for word in ("--grvity", "--gravity", "--jsn", "--json", "hefting inspect --help"):
        assert word in err


def test_a_value_that_begins_with_a_dash_is_no_option(run):
    pose = "--box", "1,1,1", "--object-pose", "-1,0,0,0,0,0,1"
    assert "none.csv" in run("identify", "none.csv", *pose)[2]

"""What people type and see, at 80 columns, as kept in ``transcripts/``; after a change,
``python tests/transcripts.py`` writes them anew, to be looked at."""

import os
import re
import shlex
from importlib import import_module
from shutil import copytree

import pytest

from hefting.cli import COMMANDS, build_parser
from transcripts import FOLDER, GROUPS, commands, masked, transcript_of, write_files

pytestmark = pytest.mark.usefixtures("same_commands")

JARGON = re.compile(
    r"dynamism|\bt = |riemann|misfit|certificate|by itself|\bknots?\b|%%|condition number"
    r"|autocorrel|covariance|posterior",
    re.IGNORECASE,
)
"""Words that stand under ``--verbose`` and in the documentation alone."""
TERMS = ("hefting methods", "hefting reproduce --list")
"""Commands that tell of methods and experiments in the field's terms."""
FOR_FILES = (["export"], ["map"])
"""Commands whose output is the text of a file, as wide as it is."""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The files that the commands read."""
    folder = tmp_path_factory.mktemp("files")
    write_files(folder)
    return folder


@pytest.fixture(scope="module", params=GROUPS)
def pair(request, files, tmp_path_factory):
    """The transcript as kept and as it is, command by command."""
    folder = tmp_path_factory.mktemp("transcripts") / "own"
    copytree(files, folder, copy_function=os.link)  # pipes are not read
    kept = (FOLDER / f"{request.param}.txt").read_text()
    return parts(kept), parts(transcript_of(request.param, folder))


def parts(text: str) -> dict[str, str]:
    """What was printed by command."""
    pieces = re.split(r"^\$ (.*)\n", text, flags=re.MULTILINE)[1:]
    return dict(zip(pieces[::2], pieces[1::2], strict=True))


def test_there_are_a_hundred():
    assert sum(len(commands(group)) for group in GROUPS) >= 100


def test_each_command_prints_what_is_kept(pair):
    kept, now = pair
    assert list(kept) == list(now)
    differ = [name for name in kept if masked(kept[name]) != masked(now[name])]
    assert not differ, "\n".join(now[name] for name in differ[:3])


def test_no_line_is_wider_than_the_screen_and_none_is_a_traceback(pair):
    for name, text in pair[1].items():
        assert "Traceback" not in text, name
        if "--help" in name or name.split()[1:2] not in FOR_FILES:
            wide = [line for line in text.splitlines() if len(line.strip("! ")) > 80]
            assert not wide, name


def test_plain_words_on_the_first_screen(pair):
    for name, text in pair[1].items():
        if "--verbose" not in name and name not in TERMS:
            assert not JARGON.search(text), f"{name}: {JARGON.search(text)}"


@pytest.mark.parametrize("name", COMMANDS)
def test_examples_in_the_help_can_be_typed(name):
    """Each example is a command that its own parser takes."""
    examples = import_module(f"hefting.cli.{name}").EXAMPLES
    assert any(f"hefting {name}" in example for example in examples)
    for example in examples:
        for typed in example.split("|"):
            words = shlex.split(typed.split(">")[0].replace('eval "$(', "").strip('")'))
            if words[0] == "hefting":
                arguments = build_parser(words[1:]).parse_args(words[1:])
                assert arguments.run
        assert len(example) <= 78

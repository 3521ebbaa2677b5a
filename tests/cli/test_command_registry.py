"""A command is one file and one line: what is said of the commands elsewhere agrees
with that list."""

from pathlib import Path

import pytest

from hefting.cli import COMMANDS
from hefting.cli.options import GRAVITY
from hefting.core.spatial import STANDARD_GRAVITY
from registries import PACKAGE, Copy

ROOT = Path(__file__).parents[2]
NOT_COMMANDS = {
    "__init__",
    "ending",
    "live_record",
    "options",
    "torques",
    "outputs",
    "pages",
    "parser",
    "progress",
    "shapes",
    "simulate_torques",
    "simulated_files",
    "standard_input",
}

TOY = '''"""hefting toy: say so."""

import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting toy``."""
    parser.add_argument("word")


def run(arguments: argparse.Namespace) -> None:
    """Print the word."""
    print(arguments.word)
'''


def test_each_file_is_listed():
    assert (
        set(COMMANDS)
        == {path.stem for path in (PACKAGE / "cli").glob("*.py")} - NOT_COMMANDS
    )


@pytest.mark.parametrize("name", COMMANDS)
def test_the_readme_tells_of_every_command(name):
    assert f"hefting {name}" in (ROOT / "README.md").read_text()


def test_what_contributors_are_told_is_so():
    told = " ".join((ROOT / "CONTRIBUTING.md").read_text().split())
    for file, name in {
        "export/__init__.py": "FILES",
        "plots/__init__.py": "FIGURES",
        "reproduction/__init__.py": "FILES",
        "cli/__init__.py": "COMMANDS",
    }.items():
        assert f"in `{Path(file).parent}/`" in told
        assert f"`{name}`" in told
        assert f"\n{name}" in (PACKAGE / file).read_text()


def test_a_new_command(tmp_path):
    copy = Copy(tmp_path)
    copy.add("cli/toy.py", TOY)
    copy.add_line("cli/__init__.py", "COMMANDS = {", '    "toy": "say so.",')
    said, listed = copy.hefting_each(("toy", "hello"), ("--help",))
    assert said == "hello\n"
    assert "toy say so." in " ".join(listed.split())


def test_gravity_on_the_command_line_is_the_librarys():
    assert tuple(map(float, GRAVITY.split(","))) == STANDARD_GRAVITY

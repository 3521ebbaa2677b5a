"""The README's commands and code run as written, one after the other, in a folder where
the demo has been made."""

import re
import shlex
import sys
from pathlib import Path

import pytest

from demo_files import write_demo
from hasty_pictures import draw_hastily
from hefting.cli import main
from hefting.estimators import describe_methods
from hefting.logs import formats
from jobs_here import understand_here

pytestmark = pytest.mark.usefixtures("same_commands")

README = Path(__file__).parents[2] / "README.md"


def blocks(language):
    """Contents of the README's fenced blocks in a language."""
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(), flags=re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder as `make demo` leaves it, without the pictures."""
    folder = tmp_path_factory.mktemp("readme")
    write_demo(folder / "demo")
    return folder


def test_commands(folder, monkeypatch, capsys):
    draw_hastily(monkeypatch)
    monkeypatch.chdir(folder)
    commands = [
        line
        for block in blocks("sh")
        for line in block.splitlines()
        if line.startswith("hefting")
    ]
    assert len(commands) >= 4
    for command in commands:
        monkeypatch.setattr(sys, "argv", shlex.split(command))
        main()
        out, err = capsys.readouterr()
        assert out
        assert err == "", command
    assert "<inertial>" in (folder / "hammer.urdf").read_text()


def test_python(folder, monkeypatch, capsys):
    understand_here(monkeypatch)
    monkeypatch.chdir(folder)
    code = "\n".join(blocks("python"))
    assert "hefting.identify" in code
    names: dict = {}
    exec(compile(code, str(README), "exec"), names)
    # the whole demo's answer, and one that was sure enough before its end, to 1 %: the
    # same object
    whole, live = names["found"], names["estimate"]
    assert live.sufficient
    assert live.samples < 1000
    assert abs(live.mass - whole.mass) < 0.01 * whole.mass
    assert "<robot" in capsys.readouterr().out


def test_the_table_of_methods_is_as_they_say():
    """One row a method, in their order; what each needs, and whether its body can
    always exist."""
    rows = [
        [cell.strip() for cell in row]
        for row in re.findall(
            r"^\| \*\*(.*)\|(.*)\|(.*)\|(.*)\|$", README.read_text(), re.M
        )
    ]
    found = {row[0].split("**")[0]: (row[2], row[3] == "always") for row in rows}
    described = describe_methods()
    expected = {
        name: (re.sub(r"^an? ", "", of["needs"]), of["consistent"])
        for name, of in described.items()
    }
    new = [
        f"| **{name}** | {described[name]['summary']} | {expected[name][0]} | |"
        for name in expected
        if name not in found
    ]
    assert list(found.items()) == list(expected.items()), (
        f"make the README's table agree; new rows: {new}"
    )


def test_links_lead_somewhere():
    for target in re.findall(r"\]\(([^)]+)\)", README.read_text()):
        path = target.partition("#")[0]
        assert path.startswith("https://") or (README.parent / path).exists(), target


def test_the_table_of_log_formats_is_the_registry():
    rows = []
    for each in formats():
        read = [f"`{suffix}`" for suffix in each.suffixes] + ["folder"] * bool(
            each.folder
        )
        written = [f"`{suffix}`" if suffix else "folder" for suffix in each.written]
        rows.append(
            f"| {each.description} | {' '.join(read) or 'any table'} | {' '.join((*written, '|'))}"
        )
    assert (
        "\n".join(("| log | read | written |", "|---|---|---|", *rows)) + "\n\n"
        in README.read_text()
    )

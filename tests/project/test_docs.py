"""The docs' maps are read as written, their commands are commands, their links lead
somewhere."""

import re
from pathlib import Path
from shutil import copytree

import pytest

from demo_files import write_demo
from hasty_pictures import draw_hastily
from hefting.cli import build_parser
from hefting.logs.column_map import load_map
from jobs_here import understand_here
from plans import search_briefly

pytestmark = pytest.mark.usefixtures("same_commands")

FOLDER = Path(__file__).parents[2] / "docs"
DOCS = sorted(
    path for part in (".", "howto", "concepts") for path in FOLDER.glob(f"{part}/*.md")
)
OTHERS = {"batch", "extending"}
"""Pages whose blocks need other files: tests of their own run them."""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The files of the demo."""
    folder = tmp_path_factory.mktemp("docs") / "demo"
    write_demo(folder)
    return folder


def blocks(path, language):
    return re.findall(rf"```{language}\n(.*?)```", path.read_text(), flags=re.DOTALL)


@pytest.mark.parametrize("path", DOCS, ids=lambda path: path.stem)
def test_maps_commands_and_links(path, tmp_path):
    for text in blocks(path, "toml") if path.stem not in OTHERS else ():
        (tmp_path / "map.toml").write_text(text)
        load_map(tmp_path / "map.toml")
    for text in blocks(path, "sh") if path.stem != "extending" else ():
        for line in text.splitlines():
            words = line.split()[1:]
            build_parser(words).parse_args(words)
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", path.read_text()):
        drawn = "drawn/" in target  # at build, which test_site.py looks at
        there = target.startswith("https://") or (path.parent / target).exists()
        assert there or drawn, target


@pytest.mark.parametrize("path", DOCS, ids=lambda path: path.stem)
def test_files_of_the_project_that_a_page_names_are_there(path):
    """But of the guide that makes new ones."""
    named = re.findall(
        r"`((?:src|tests|docs|benchmarks)/[\w/.]+\.\w+)", path.read_text()
    )
    missing = [name for name in named if not (FOLDER.parent / name).exists()]
    assert path.stem == "extending" or not missing


def test_there_are_docs():
    assert any(blocks(path, "toml") and blocks(path, "sh") for path in DOCS)


@pytest.mark.parametrize(
    "path",
    [path for path in DOCS if blocks(path, "python") and path.stem not in OTHERS],
    ids=lambda path: path.stem,
)
def test_python_runs_as_written(path, made, tmp_path, monkeypatch, capsys):
    """One block after the other, where the demo has written its files; what the page
    shows as printed is printed."""
    draw_hastily(monkeypatch)
    understand_here(monkeypatch)
    search_briefly(monkeypatch)
    copytree(made, tmp_path / "demo")
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for code in blocks(path, "python"):
        exec(compile(code, path.name, "exec"), names)
    printed = capsys.readouterr().out
    for shown in re.findall(r"```\n\n```\n(.*?)```", path.read_text(), flags=re.DOTALL):
        assert _masked(shown) in _masked(printed)
    if path.stem == "python":
        assert names["found"].sufficient
        assert abs(names["found"].mass / names["compared"].mass - 1.0) < 0.01


def _masked(text: str) -> str:
    """Without numbers, whose last digits depend on the machine."""
    return re.sub(r"-?\d[\d.]*", "#", text)

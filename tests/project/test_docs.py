"""The docs' maps are read as written, their commands are commands, their links lead
somewhere."""

import re
from pathlib import Path

import pytest

from hefting.cli import build_parser
from hefting.logs.column_map import load_map

DOCS = sorted((Path(__file__).parents[2] / "docs").glob("*.md"))


def blocks(path, language):
    return re.findall(rf"```{language}\n(.*?)```", path.read_text(), flags=re.DOTALL)


@pytest.mark.parametrize("path", DOCS, ids=lambda path: path.stem)
def test_maps_commands_and_links(path, tmp_path):
    for text in blocks(path, "toml"):
        (tmp_path / "map.toml").write_text(text)
        load_map(tmp_path / "map.toml")
    for text in blocks(path, "sh"):
        for line in text.splitlines():
            words = line.split()[1:]
            build_parser(words).parse_args(words)
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", path.read_text()):
        assert target.startswith("https://") or (path.parent / target).exists(), target


def test_there_are_docs():
    assert any(blocks(path, "toml") and blocks(path, "sh") for path in DOCS)

"""docs/fails.md: what it says of mistakes that are made for it alone is still said."""

import importlib
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def pictures(monkeypatch, tmp_path):
    """The module that writes the page, into another folder."""
    monkeypatch.syspath_prepend(DOCS)
    module = importlib.import_module("mistake_pictures")
    monkeypatch.setattr(module, "HERE", tmp_path)
    (tmp_path / "mistakes_seen").mkdir()
    return module


@pytest.mark.parametrize("code", ["drift-in-short", "unexplained"])
def test_the_page_says_what_is_said(code, pictures):
    mistakes = {(each.name, each.strength): each for each in pictures.OTHERS}
    cases = [case for part in pictures.CASES.values() for case in part]
    (case,) = (each for each in cases if each.code == code)
    section = pictures.section(case, mistakes[case.made])
    assert _masked(section) in _masked((DOCS / "fails.md").read_text())


def _masked(text: str) -> str:
    """Without numbers, whose last digits depend on the machine."""
    return re.sub(r"-?\d[\d.]*", "#", text)

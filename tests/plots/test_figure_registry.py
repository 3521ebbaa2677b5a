"""A figure is one file and one line: its public name and the list in the docs follow
from them."""

import re
from pathlib import Path

import pytest

pytest.importorskip(
    "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
)

import hefting.plots
from hefting.plots import FIGURES
from registries import PACKAGE, Copy

DOCS = Path(__file__).parents[2] / "docs" / "pictures.md"
NOT_FIGURES = {"__init__", "headline", "style", "views"}

TOY = '''"""Toy: one line."""

from hefting.plots.style import drawing


def plot_toy(values):
    """Values [-] by their number."""
    with drawing(2.0) as figure:
        figure.subplots().plot(values)
    return figure
'''


def test_each_file_is_listed_and_draws_what_it_says():
    assert {file for file, _ in FIGURES.values()} == {
        p.stem for p in (PACKAGE / "plots").glob("*.py")
    } - NOT_FIGURES
    for name in FIGURES:
        draw = getattr(hefting.plots, name)
        assert draw.__name__ == name
        assert draw.__doc__
    assert set(dir(hefting.plots)) >= set(FIGURES)
    with pytest.raises(AttributeError, match="plot_nothing"):
        hefting.plots.plot_nothing  # noqa: B018


def test_the_docs_list_the_figures():
    rows = re.findall(r"^\| `(\w+)` \| (.*) \|$", DOCS.read_text(), flags=re.MULTILINE)
    assert rows == [(name, text) for name, (_, text) in FIGURES.items()]


def test_a_new_figure(tmp_path):
    copy = Copy(tmp_path)
    copy.add("plots/toy.py", TOY)
    copy.add_line(
        "plots/__init__.py", "FIGURES = {", '    "plot_toy": ("toy", "a line"),'
    )
    code = (
        "from hefting.plots import FIGURES, plot_toy, save_figure; "
        "figure = plot_toy([1.0, 3.0]); save_figure(figure, 'toy'); "
        "print(FIGURES['plot_toy'][1], *figure.axes[0].lines[0].get_ydata())"
    )
    assert copy.python("-c", code) == "a line 1.0 3.0\n"
    assert (tmp_path / "toy.png").read_bytes().startswith(b"\x89PNG")
    assert b"<svg" in (tmp_path / "toy.svg").read_bytes()

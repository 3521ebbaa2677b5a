"""The README's moving picture: it is that of docs/animation.py, which still draws it."""

import importlib
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parents[2]
LARGEST = 1_200_000
"""Bytes: a page that shows it opens at once."""


@pytest.fixture
def animation(monkeypatch):
    """The module that draws it."""
    monkeypatch.syspath_prepend(ROOT / "docs")
    return importlib.import_module("animation")


def test_the_readme_shows_it(animation):
    assert f"]({animation.FILE.relative_to(ROOT)})" in (ROOT / "README.md").read_text()
    assert animation.FILE.stat().st_size < LARGEST
    with Image.open(animation.FILE) as picture:
        assert picture.n_frames == animation.FRAMES
        assert picture.info["loop"] == 0


def test_it_can_be_drawn_again(animation, monkeypatch, tmp_path):
    """Arm, hammer and mass of the first and the last picture; the curves need all.
    Between versions of the libraries that draw some edges differ."""
    if not metadata.files("example-robot-data"):
        pytest.skip("example-robot-data is not installed")
    kept = animation.FILE
    monkeypatch.setattr(animation, "FRAMES", 2)
    monkeypatch.setattr(animation, "FILE", tmp_path / "again.gif")
    animation.main()
    with Image.open(animation.FILE) as again, Image.open(kept) as before:
        for one, other in ((0, 0), (1, before.n_frames - 1)):
            off = np.abs(left_of(again, one) - left_of(before, other))
            assert (off > 40).mean() < 0.01


def left_of(picture, k):
    """Brightness of the left part of a picture of several."""
    picture.seek(k)
    bright = np.asarray(picture.convert("L"), dtype=float)
    return bright[:, : int(0.6 * bright.shape[1])]

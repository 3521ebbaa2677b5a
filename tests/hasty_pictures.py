"""Pictures for tests that look at nothing in them but that they are there."""

from importlib.util import find_spec

import pytest


def draw_hastily(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few pixels, and no layout, which takes most of the time: what overlaps in each
    kind of picture is looked at in plots/. Without matplotlib there are none."""
    if find_spec("matplotlib") is None:
        return
    monkeypatch.setattr("hefting.plots.style.DPI", 60)
    monkeypatch.setattr(
        "matplotlib.figure.Figure.draw_without_rendering", lambda figure: None
    )

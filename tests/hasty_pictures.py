"""Pictures for tests that look at nothing in them but that they are there."""

import pytest


def draw_hastily(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few pixels, and no layout, which takes most of the time: what overlaps in each
    kind of picture is looked at in plots/."""
    monkeypatch.setattr("hefting.plots.style.DPI", 60)
    monkeypatch.setattr(
        "matplotlib.figure.Figure.draw_without_rendering", lambda figure: None
    )

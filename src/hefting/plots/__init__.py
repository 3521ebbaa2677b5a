"""Plots: one file a figure, one palette (`hefting.plots.style`). Need matplotlib.

    figure = hefting.plots.plot_wrench(measurements, estimate)
    hefting.plots.save_figure(figure, "wrench")

Each figure takes what it shows, so that they have no common call; `FIGURES` tells of
them.
"""

from importlib import import_module

FIGURES = {
    "plot_wrench": (
        "wrench",
        "the wrench measured, the wrench an estimate explains, and what remains",
    ),
    "plot_object": (
        "body",
        "the object found in three views: masses, centre of mass, inertia ellipsoid",
    ),
    "plot_prediction": (
        "prediction",
        "the wrench predicted along a motion, its 95 % band, and what was measured",
    ),
}
"""Function that draws each figure, a public name of this package: the file it is in,
and what it shows."""

_HOME = {name: file for name, (file, _) in FIGURES.items()} | {
    "picture_of": "style",
    "save_figure": "style",
}

__all__ = ["FIGURES", *_HOME]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'hefting.plots' has no attribute '{name}'")
    return getattr(import_module(f"hefting.plots.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)

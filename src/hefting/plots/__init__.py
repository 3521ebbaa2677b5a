"""Plots: a function a figure, one palette (`hefting.plots.style`). Need matplotlib.

    figure = hefting.plots.plot_wrench(measurements, estimate)
    hefting.plots.save_figure(figure, "wrench")

Figures take different arguments; `FIGURES` describes them.
"""

from importlib import import_module

FIGURES = {
    "plot_wrench": (
        "wrench",
        "the wrench measured, the wrench an estimate explains, and what remains",
    ),
    "plot_object": (
        "body",
        "the object found in three views: COM with its 95 % region, uniform ellipsoid "
        "of equal inertia",
    ),
    "plot_identification": (
        "body",
        "both side by side, as `hefting identify --output x.png` writes them",
    ),
    "plot_shape": (
        "body",
        "a shape as it is posed on the sensor, before anything is identified",
    ),
    "plot_prediction": (
        "prediction",
        "the wrench predicted along a motion, its 95 % band, what was measured, and a "
        "constant between the two",
    ),
    "plot_plan": (
        "plan",
        "a planned motion: joints within their limits, the fastest corner of the "
        "object, and how sure one is expected to become",
    ),
}
"""File and content of each figure, by the function that draws it, a public name of this
package."""

_HOME = {name: file for name, (file, _) in FIGURES.items()} | {
    "picture_of": "style",
    "picture_suffix": "style",
    "save_figure": "style",
}

__all__ = ["FIGURES", *_HOME]  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'hefting.plots' has no attribute '{name}'")
    return getattr(import_module(f"hefting.plots.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)

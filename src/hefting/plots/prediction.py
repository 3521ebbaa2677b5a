"""Picture of a predicted wrench: force and torque with their 95 % bands, and what was
measured. Needs matplotlib."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.spatial import Array, Indices
from hefting.plots.style import (
    COMPONENTS,
    INK,
    MEASURED,
    PARTS,
    chosen,
    figure_of,
    settled,
    style,
)
from hefting.prediction import Prediction
from hefting.prediction.spread import Z95

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHADED = 0.3
"""Opacity of the band."""


def plot_prediction(prediction: Prediction) -> "Figure":
    """Force and torque over time with the band, over what was measured; below each half
    the band's width, which mostly is thinner than a line, or without a band measured
    minus predicted.

    Where the band has no end it is not drawn. Static poses are told by their row, from
    1. Raises `MissingDependencyError` without matplotlib.
    """
    a = prediction.agreement
    deep = prediction.std is not None or a is not None
    heights = (3.0, 1.2, 3.0, 1.2) if deep else (1.0, 1.0)
    with style():
        figure = figure_of(4.6 if deep else 3.2)
        rows = figure.subplots(
            len(heights), 1, sharex=True, gridspec_kw={"height_ratios": heights}
        )
        shown = chosen(len(prediction))
        time = prediction.time[shown] + prediction.static
        for (name, unit, first), whole in zip(
            PARTS, rows[:: 2 if deep else 1], strict=True
        ):
            _whole(whole, prediction, shown, first)
            whole.set_ylabel(f"{name} [{unit}]")
            if a is not None:
                said = f"measured − predicted: rms {a.rms[first // 3]:.2g} {unit}"
                whole.set_title(said, loc="right", pad=2.0, color=INK)
        for (_, unit, first), rest in zip(
            PARTS, rows[1::2] if deep else (), strict=deep
        ):
            if prediction.std is not None:
                _half_width(rest, prediction, shown, first)
                rest.set_ylabel(f"± [{unit}]")
            else:
                _difference(rest, prediction, first)
                rest.set_ylabel(f"[{unit}]")
        _legend(figure, prediction)
        rows[-1].set_xlabel("Pose" if prediction.static else "Time [s]")
        margin = 0.5 if prediction.static or len(time) == 1 else 0.0
        rows[-1].set_xlim(time[0] - margin, time[-1] + margin)
        figure.align_ylabels()
        return settled(figure)


def _whole(axes: "Axes", prediction: Prediction, shown: Indices, first: int) -> None:
    """The predicted force or torque with its band, over what was measured."""
    a = prediction.agreement
    time, wrench = prediction.time[shown] + prediction.static, prediction.wrench[shown]
    band = None if prediction.std is None else Z95 * _finite(prediction.std[shown])
    for i, colour in enumerate(COMPONENTS.values(), first):
        if a is not None:
            seen = chosen(len(a.time))
            line: dict[str, Any] = MEASURED | (
                {"marker": "_", "linestyle": "none"} if prediction.static else {}
            )
            axes.plot(
                a.time[seen] + prediction.static,
                a.wrench[seen, i],
                color=colour,
                **line,
            )
        if band is not None:
            ends = wrench[:, i] - band[:, i], wrench[:, i] + band[:, i]
            if prediction.static:
                axes.vlines(time, *ends, color=colour, alpha=SHADED, linewidth=2.0)
            else:
                axes.fill_between(
                    time, *ends, color=colour, alpha=SHADED, linewidth=0.0
                )
        axes.plot(time, wrench[:, i], color=colour, **_line(prediction, 0.7))


def _half_width(
    axes: "Axes", prediction: Prediction, shown: Indices, first: int
) -> None:
    assert prediction.std is not None
    reach = Z95 * prediction.std[shown, first : first + 3]
    for column, colour in zip(_finite(reach).T, COMPONENTS.values(), strict=True):
        axes.plot(
            prediction.time[shown] + prediction.static,
            column,
            color=colour,
            **_line(prediction, 0.8),
        )
    axes.set_ylim(bottom=0.0)
    part = ", open in part" if np.isinf(reach).any() else ""
    axes.set_title(
        f"half the width of the 95 % band{part}", loc="right", pad=2.0, color=INK
    )


def _difference(axes: "Axes", prediction: Prediction, first: int) -> None:
    a = prediction.agreement
    assert a is not None
    seen = chosen(len(a.time))
    for i, colour in enumerate(COMPONENTS.values(), first):
        axes.plot(
            a.time[seen] + prediction.static,
            a.difference[seen, i],
            color=colour,
            **_line(prediction, 0.4),
        )
    axes.axhline(0.0, color=INK, linewidth=0.4)


def _line(prediction: Prediction, width: float) -> dict[str, Any]:
    """A line, or dots for static poses."""
    return (
        {"marker": ".", "markersize": 3.0, "linestyle": "none"}
        if prediction.static
        else {"linewidth": width}
    )


def _finite(values: Array) -> Array:
    """NaN, which is not drawn, for infinity."""
    return np.where(np.isfinite(values), values, np.nan)


def _legend(figure: "Figure", prediction: Prediction) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Line2D | Patch]
    handles = [
        Line2D([], [], color=colour, linewidth=1.2, label=name)
        for name, colour in COMPONENTS.items()
    ]
    handles.append(Line2D([], [], color=INK, linewidth=0.7, label="predicted"))
    if prediction.std is not None:
        handles.append(Patch(color=INK, alpha=SHADED, linewidth=0.0, label="95 %"))
    if prediction.agreement is not None:
        handles.append(Line2D([], [], color=INK, label="measured", **MEASURED))
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=len(handles),
        handlelength=1.4,
        columnspacing=1.0,
    )

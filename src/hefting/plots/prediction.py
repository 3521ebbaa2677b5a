"""Picture of a predicted wrench: force and torque with their 95 % bands, and the measured
ones. Needs matplotlib."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.messages import codes
from hefting.core.sensor_accuracy import Z95
from hefting.core.spatial import Array, Indices
from hefting.plots.style import (
    COMPONENTS,
    INK,
    MEASURED,
    chosen,
    component_handles,
    draw_components,
    draw_legend,
    headed,
    label_time,
    line_of,
    lines_of,
    write_title,
)
from hefting.prediction import Prediction
from hefting.scene import PARTS, Headline, plus_minus

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

SHADED = 0.3
"""Opacity of the band."""
MOST_COLUMNS = 6
"""Most entries in a line of the legend."""


def plot_prediction(
    prediction: Prediction, say: Callable[[str], str] = str
) -> "Figure":
    """Force and torque over time with the band, and the measured ones. Below them the
    measured minus the predicted one, with its mean dashed, which may be another bias of
    the sensor; and half the width of the band, which is often thinner than a line.

    If most of a difference is constant, the prediction plus that constant is drawn too.
    An infinite band is not drawn. Static poses have their row, from 1, as time. The
    headline is the verdict; `say` turns names of arguments in backquotes into the
    reader's. Raises `MissingDependencyError` without matplotlib.
    """
    part = [_whole]  # functions that draw the rows of the force, and of the torque
    part += [] if prediction.agreement is None else [_difference]
    part += [] if prediction.std is None else [_half_width]
    heights = [HEIGHTS[draw] for draw in part]
    lines = _headline(prediction, say)
    height, usable = 0.75 + 1.8 * sum(heights), prediction.verdict.usable
    with headed(height, lines, usable) as (figure, below):
        rows = below.subplots(
            2 * len(part), 1, sharex=True, gridspec_kw={"height_ratios": 2 * heights}
        )
        shown = chosen(len(prediction))
        time = prediction.time[shown] + prediction.static
        for (name, unit, first), axes in zip(
            PARTS, (rows[: len(part)], rows[len(part) :]), strict=True
        ):
            for draw, row in zip(part, axes, strict=True):
                draw(row, prediction, shown, first, unit)
            axes[0].set_ylabel(f"{name} [{unit}]")
        _legend(below, prediction)
        label_time(rows[-1], time, prediction.static)
        below.align_ylabels()
    return figure


def _headline(prediction: Prediction, say: Callable[[str], str]) -> list[str]:
    verdict = prediction.verdict
    units = [unit for _, unit, _ in PARTS]
    peaks = tuple(
        f"largest {name} {plus_minus(peak.value, peak.reach)} {unit}"
        for (name, peak), unit in zip(prediction.peaks.items(), units, strict=True)
    )
    reason = str(verdict.reasons[0]) if verdict.reasons else ""
    meaning = "" if prediction.std is None else "   (±: 95 %)"
    headline = Headline(f"verdict: {verdict}{meaning}", reason, verdict.usable, peaks)
    return lines_of(headline, say=say)


def _whole(
    axes: "Axes", prediction: Prediction, shown: Indices, first: int, unit: str
) -> None:
    a = prediction.agreement
    time, wrench = prediction.time[shown] + prediction.static, prediction.wrench[shown]
    band = None if prediction.std is None else Z95 * _finite(prediction.std[shown])
    part = slice(first, first + 3)
    for i, colour in enumerate(COMPONENTS.values(), first):
        if a is not None:
            seen = chosen(len(a.time))
            dashes = {"marker": "_", "linestyle": "none"} if prediction.static else {}
            line: dict[str, Any] = MEASURED | dashes
            at = a.time[seen] + prediction.static
            axes.plot(at, a.wrench[seen, i], color=colour, **line)
        if band is not None:
            ends = wrench[:, i] - band[:, i], wrench[:, i] + band[:, i]
            if prediction.static:
                axes.vlines(time, *ends, color=colour, alpha=SHADED, linewidth=2.0)
            else:
                look: dict[str, Any] = {"alpha": SHADED, "linewidth": 0.0}
                axes.fill_between(time, *ends, color=colour, **look)
        axes.plot(time, wrench[:, i], color=colour, **line_of(prediction.static, 0.7))
    if a is not None and _has_constant(prediction):
        shifted = wrench[:, part] + a.difference[:, part].mean(axis=0)
        draw_components(axes, time, shifted, **_dashed(prediction))


def _has_constant(prediction: Prediction) -> bool:
    return "constant-difference" in codes(prediction.warnings)


def _dashed(prediction: Prediction) -> dict[str, Any]:
    return (
        {"marker": "x", "markersize": 2.5, "markeredgewidth": 0.5, "linestyle": "none"}
        if prediction.static
        else {"linewidth": 0.6, "linestyle": (0, (4, 2))}
    )


def _half_width(
    axes: "Axes", prediction: Prediction, shown: Indices, first: int, unit: str
) -> None:
    assert prediction.std is not None
    reach = Z95 * prediction.std[shown, first : first + 3]
    time, static = prediction.time[shown] + prediction.static, prediction.static
    draw_components(axes, time, _finite(reach), **line_of(static, 0.8))
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(f"± [{unit}]")
    part = ", open in part" if np.isinf(reach).any() else ""
    write_title(axes, f"half the width of the 95 % band{part}")


def _difference(
    axes: "Axes", prediction: Prediction, shown: Indices, first: int, unit: str
) -> None:
    a = prediction.agreement
    assert a is not None
    seen, static = chosen(len(a.time)), prediction.static
    three = a.difference[:, first : first + 3]
    draw_components(axes, a.time[seen] + static, three[seen], **line_of(static, 0.4))
    for mean, colour in zip(
        a.difference.mean(axis=0)[first:], COMPONENTS.values(), strict=False
    ):
        axes.axhline(mean, color=colour, linewidth=0.8, linestyle=(0, (4, 2)))
    axes.axhline(0.0, color=INK, linewidth=0.4)
    rms, varying = a.rms[first // 3], a.varying[first // 3]
    write_title(axes, f"residual rms {rms:.2g}, less its mean {varying:.2g} {unit}")
    axes.set_ylabel(f"[{unit}]")


def _finite(values: Array) -> Array:
    """The values with NaN, which is not drawn, in place of infinity."""
    return np.where(np.isfinite(values), values, np.nan)


def _legend(figure: "SubFigure", prediction: Prediction) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = component_handles()
    handles.append(Line2D([], [], color=INK, linewidth=0.7, label="predicted"))
    if prediction.std is not None:
        handles.append(Patch(color=INK, alpha=SHADED, linewidth=0.0, label="95 %"))
    if prediction.agreement is not None:
        handles.append(Line2D([], [], color=INK, label="measured", **MEASURED))
    if prediction.agreement is not None and _has_constant(prediction):
        line = _dashed(prediction)
        handles.append(Line2D([], [], color=INK, label="predicted + mean", **line))
    columns = MOST_COLUMNS if len(handles) <= MOST_COLUMNS else 4
    draw_legend(figure, handles, columns, handlelength=1.4, columnspacing=1.0)


HEIGHTS = {_whole: 1.6, _difference: 0.7, _half_width: 0.6}
"""Relative height of each row, by the function that draws it."""

"""Picture of the measured wrench, the one predicted by an estimate, and the residual.
Needs matplotlib."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.spatial import Array
from hefting.plots.style import (
    COMPONENTS,
    INK,
    MEASURED,
    SHADOW,
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
from hefting.scene import PARTS, gaps_between, headline_of, vector_text, wrench_curves

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

HEIGHT = 4.3
"""Height of the rows and their legend [in]."""
MOST_COLUMNS = 5
"""Most entries in a line of the legend."""


def plot_wrench(
    measurements: Measurements,
    estimate: Estimate,
    say: Callable[[str], str] = str,
    start: float | None = None,
) -> "Figure":
    """Measured wrench, the wrench predicted by the estimate (with its bias), and the
    residual, over time or, for an estimate without a duration, by static pose.

    Wrenches are exerted by the sensor on the object. `say` is as for `plot_object`;
    `start` is the time [s] that counts as zero, by default that of the first measurement.
    Raises `MissingDependencyError` without matplotlib.
    """
    headline = headline_of(estimate)
    lines = lines_of(headline, say=say)
    with headed(HEIGHT, lines, headline.usable) as (figure, below):
        draw_wrench(below, measurements, estimate, start)
    return figure


def _bias_text(estimate: Estimate, part: slice, unit: str) -> str:
    """The part of the estimated bias that is that of forces, or of torques, in words."""
    if estimate.common_bias is None:
        return "with the bias of each recording, one after the other"
    return f"bias found: {vector_text(estimate.common_bias[part])} {unit}"


def draw_wrench(
    figure: "SubFigure",
    measurements: Measurements,
    estimate: Estimate,
    start: float | None,
) -> None:
    """The rows of `plot_wrench` and their legend, on an empty figure."""
    curves = wrench_curves(measurements, estimate, start)
    static, shown = curves.static, chosen(len(measurements))
    gaps = gaps_between(curves.time, shown)  # where lines are interrupted

    def drawn(values: Array) -> Array:
        return np.insert(values[shown], gaps, np.nan, axis=0)

    time, residual = drawn(curves.time), curves.residual
    measured, predicted = drawn(curves.measured), drawn(curves.predicted)
    rows = figure.subplots(
        4, 1, sharex=True, gridspec_kw={"height_ratios": (3, 1.2, 3, 1.2)}
    )
    for (name, unit, part), whole, rest in zip(
        PARTS, rows[::2], rows[1::2], strict=True
    ):
        three = slice(part, part + 3)
        _draw_whole(whole, time, measured[:, three], predicted[:, three], static)
        whole.set_ylabel(f"{name} [{unit}]")
        if estimate.bias is not None:
            write_title(whole, _bias_text(estimate, three, unit))
        draw_components(rest, time, drawn(residual[:, three]), **line_of(static, 0.4))
        rest.axhline(0.0, color=INK, linewidth=0.4)
        rest.set_ylabel(f"[{unit}]")
        rms = curves.rms(part)
        write_title(rest, f"residual (measured − predicted), rms {rms:.2g} {unit}")
        limit = 1.25 * float(np.abs(residual[:, three]).max()) or 1.0
        rest.set_ylim(-limit, limit)
    unused = [] if static else [curves.time[shown[[k - 1, k]]] for k in gaps]
    for axes in rows:
        for start_of_gap, end_of_gap in unused:
            axes.axvspan(start_of_gap, end_of_gap, color=SHADOW, linewidth=0.0)
    _draw_legend(figure, estimate, static, bool(unused))
    label_time(rows[-1], time, static)
    figure.align_ylabels()


def _draw_whole(
    axes: "Axes", time: Array, measured: Array, predicted: Array, static: bool
) -> None:
    for i, colour in enumerate(COMPONENTS.values()):
        axes.plot(time, measured[:, i], color=colour, **_measured(static))
        axes.plot(time, predicted[:, i], color=colour, **line_of(static, 0.7))
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.05 * (high - low))


def _measured(static: bool) -> dict[str, Any]:
    dashes = {"marker": "_", "markersize": 7.0, "linestyle": "none"}
    return MEASURED | (dashes if static else {})


def _draw_legend(
    figure: "SubFigure", estimate: Estimate, static: bool, has_gaps: bool
) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    turned = estimate.provenance.get("wrench") == "on-sensor"
    handles = component_handles()
    measured = "measured, sign turned" if turned else "measured"
    handles.append(Line2D([], [], color=INK, label=measured, **_measured(static)))
    predicted = "predicted" if estimate.bias is None else "predicted + bias"
    handles.append(Line2D([], [], color=INK, label=predicted, **line_of(static, 0.7)))
    if has_gaps:
        label = "left out, or not recorded"
        handles.append(Patch(color=SHADOW, linewidth=0.0, label=label))
    columns = MOST_COLUMNS if len(handles) <= MOST_COLUMNS else 3
    look = {"handlelength": 1.4, "columnspacing": 0.9, "borderaxespad": 0.2}
    draw_legend(figure, handles, columns, **look)

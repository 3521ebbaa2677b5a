"""Picture of the wrench an estimate explains: measured, predicted, and what remains.
Needs matplotlib."""

from typing import TYPE_CHECKING

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.regressor import predict_wrench
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_wrench(measurements: Measurements, estimate: Estimate) -> "Figure":
    """Measured wrench, the wrench the estimate predicts (with its bias), and what
    remains, over time.

    Raises `MissingDependencyError` without matplotlib.
    """
    predicted = predict_wrench(measurements, estimate.parameters.vector)
    if estimate.bias is not None:
        predicted = predicted + estimate.bias
    residual = measurements.wrench - predicted
    shown = chosen(len(measurements))
    time = measurements.time[shown] - measurements.time[0]
    with style():
        figure = figure_of(4.3)
        rows = figure.subplots(
            4, 1, sharex=True, gridspec_kw={"height_ratios": (3, 1.2, 3, 1.2)}
        )
        for (name, unit, part), whole, rest in zip(
            PARTS, rows[::2], rows[1::2], strict=True
        ):
            for i, (component, colour) in enumerate(COMPONENTS.items()):
                column = part + i
                whole.plot(
                    time, measurements.wrench[shown, column], color=colour, **MEASURED
                )
                whole.plot(
                    time,
                    predicted[shown, column],
                    color=colour,
                    linewidth=0.7,
                    label=component,
                )
                rest.plot(time, residual[shown, column], color=colour, linewidth=0.4)
            whole.set_ylabel(f"{name} [{unit}]")
            rest.set_ylabel(f"[{unit}]")
            rest.axhline(0.0, color=INK, linewidth=0.4)
            rms = float(np.sqrt(np.mean(residual[:, part : part + 3] ** 2)))
            rest.set_title(
                f"residual (measured − predicted), rms {rms:.2g} {unit}",
                loc="right",
                pad=2.0,
                color=INK,
            )
            limit = 1.25 * float(np.abs(residual[:, part : part + 3]).max()) or 1.0
            rest.set_ylim(-limit, limit)
            _pad(whole, top=0.05)
        _wrench_legend(rows[0])
        rows[-1].set_xlabel("Time [s]")
        rows[-1].set_xlim(time[0], time[-1] if len(time) > 1 else time[0] + 1.0)
        figure.align_ylabels()
        return settled(figure)


def _wrench_legend(axes: "Axes") -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=colour, linewidth=1.2, label=name)
        for name, colour in COMPONENTS.items()
    ]
    handles.append(Line2D([], [], color=INK, label="measured", **MEASURED))
    handles.append(Line2D([], [], color=INK, linewidth=0.7, label="predicted"))
    axes.legend(
        handles=handles,
        ncols=5,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        handlelength=1.4,
        columnspacing=1.0,
        borderaxespad=0.2,
    )


def _pad(axes: "Axes", top: float) -> None:
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + top * (high - low))

"""Recording: how the sensor's bias drifts, how dynamic the motion is, and what each
measurement weighs."""

from collections.abc import Iterable

import numpy as np

from hefting.core.regressor import dynamism
from hefting.core.sensor_accuracy import Z95
from hefting.core.spatial import Array
from hefting.estimators import Estimator
from hefting.ingest.ingested import Ingested
from hefting.page.figure import AXES, Figure, Trace, band, curve, line, rows
from hefting.page.frame import Section
from hefting.page.html import element, join
from hefting.page.wrench import TIME, parts_of
from hefting.scene import thinned
from hefting.scene.wrench import PARTS


def recording(found: Ingested, estimator: Estimator | None) -> Section | None:
    """Drift, dynamism and weights over time; None for static poses."""
    if found.static:
        return None
    lines, figures = [], [_motion(found, estimator)]
    drifting = [
        part for part in found.recordings if part.conditioned.bias.kind != "constant"
    ]
    if drifting:
        figures.insert(0, _drift(found))
        lines.append(
            "The sensor's bias drifts, as recorded; what it changes by was removed. "
            "Bands are 95 %."
        )
    else:
        lines.append("The sensor's bias counts as constant: no drift was found.")
    lines.append(
        "Dynamism is |a|² + |α|² + (2|ω|)²: where it is near zero the wrench shows mass "
        "and centre of mass alone. A measurement's weight is that of its squared "
        "residuals, one on average."
    )
    if _shares(found, estimator) is not None:
        lines.append("The method uses the full model by a share that follows dynamism.")
    content = join(element("p", text, class_="note") for text in lines)
    title = "Drift, dynamism and weights"
    return Section("recording", title, content, tuple(figures))


def _drift(found: Ingested) -> Figure:
    """Bias of force and torque, as recorded."""
    titles = [f"Bias, {name.lower()} [{unit}]" for name, unit, _ in PARTS]
    layout, traces = rows(titles, [1.0, 1.0], TIME), list(_drift_lines(found))
    return Figure("drift", traces, layout, 420, "The sensor's bias over time")


def _drift_lines(found: Ingested) -> Iterable[Trace]:
    for k, (part, shift) in enumerate(parts_of(found)):
        drift, z = part.conditioned.bias, part.measurements
        ends = np.array([z.time[0], z.time[-1]]) + part.conditioned.offset
        inner = drift.knots[(drift.knots > ends[0]) & (drift.knots < ends[1])]
        time = np.concatenate((ends[:1], inner, ends[1:]))
        values, std = drift(time), _interpolated(time, drift.knots, drift.std)
        shown = time - part.log_start + shift
        for i in range(6):
            axis, row = AXES[i % 3], "y" if i < 3 else "y2"
            low, high = values[:, i] - Z95 * std[:, i], values[:, i] + Z95 * std[:, i]
            named = i < 3 and k == 0
            place = {"yaxis": row, "legendgroup": axis}
            yield band(shown, low, high, f"@{axis}-pale") | place
            drawn = line(shown, values[:, i], f"bias {axis}", f"@{axis}")
            yield drawn | place | {"showlegend": named}


def _interpolated(time: Array, knots: Array, values: Array) -> Array:
    """(K, 6) linear between knots."""
    with np.errstate(invalid="ignore"):  # infinite deviations give no band
        return np.column_stack([np.interp(time, knots, column) for column in values.T])


def _motion(found: Ingested, estimator: Estimator | None) -> Figure:
    """Dynamism, and the weights."""
    z, shares = found.measurements, _shares(found, estimator)
    time = z.time - found.log_start
    titles = ["Dynamism", "Weight"] if z.weights is not None else ["Dynamism"]
    titles += [] if shares is None else ["Share of the full model"]
    layout = rows(titles, [1.0] * len(titles), TIME)
    layout["showlegend"] = False
    drawn = [dynamism(z)] + ([] if z.weights is None else [z.weights])
    drawn += [] if shares is None else [shares]
    traces = []
    for i, (name, values) in enumerate(zip(titles, drawn, strict=True), 1):
        shown = thinned(values)
        row = f"y{i}" if i > 1 else "y"
        traces.append(curve(time, values, shown, name.lower(), "@x", yaxis=row))
        layout[f"yaxis{i if i > 1 else ''}"]["rangemode"] = "tozero"
    return Figure("motion", traces, layout, 170 * len(titles) + 60, ", ".join(titles))


def _shares(found: Ingested, estimator: Estimator | None) -> Array | None:
    """(K,) share of the full model; None for a method that always uses the same."""
    if estimator is None:
        return None
    weight = estimator.weight(found.measurements)
    return weight if isinstance(weight, np.ndarray) and weight.ndim else None

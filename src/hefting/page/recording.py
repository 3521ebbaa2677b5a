"""Recording: the wrench, spans left out, drift, dynamism and weights over time."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.regressor import dynamism
from hefting.core.sensor_accuracy import Z95
from hefting.core.spatial import Array, interpolated
from hefting.estimators import Estimator
from hefting.ingest.ingested import Ingested
from hefting.ingest.left_out import CAUSES, Span
from hefting.page.figure import AXES, Figure, Trace, band, curve, line, rows
from hefting.page.html import Section, element, items, join, note
from hefting.scene import PARTS, WrenchCurves, thinned, wrench_curves

MOST_SPANS = 150
"""Most spans of one cause that are drawn; if there are more, near ones are joined."""
TIME, POSE = "Time since the start of the log [s]", "Pose"
TIMES = "Time, one recording after the other [s]"


def wrench(estimate: Estimate, found: Ingested) -> Section:
    """Force and torque of an estimate's recording."""
    curves = wrench_curves(found.measurements, estimate, found.log_start)
    spans = spans_of(found)
    title = x_title(found)
    figures = tuple(_figure(curves, spans, title, *part) for part in PARTS)
    says = (
        "What the sensor exerts on the object, in sensor axes: measured (pale) and as "
        "the estimate predicts it, with the bias found; below, what remains."
    )
    drawn = _count_text(found, curves)
    lines = [
        f"{CAUSES[cause][:1].upper()}{CAUSES[cause][1:]}: {text}"
        for cause, text in summary(spans).items()
    ]
    left = "Left out:" if lines else "Nothing was left out."
    drawn = note(drawn) if drawn else ""
    content = join(note(says), drawn, element("p", left), items(lines))
    return Section("wrench", "Wrench: measured, predicted, left out", content, figures)


def x_title(found: Ingested) -> str:
    """Title of the x axis of samples."""
    if found.static:
        return POSE
    return TIMES if len(found.recordings) > 1 else TIME


def spans_of(found: Ingested) -> tuple[Span, ...]:
    """Spans left out, on the time axis of the figures, where several recordings follow
    one another."""
    return tuple(
        Span(s.cause, s.start + shift, s.end + shift, s.samples)
        for part, shift in parts_of(found)
        for s in part.left_out
    )


def parts_of(found: Ingested) -> Iterable[tuple[Ingested, float]]:
    """Each recording, with the shift [s] from times since the start of its log to the
    time axis of the figures, where recordings follow one another."""
    row, axis_start = 0, found.log_start
    for part in found.recordings:
        first = float(part.measurements.time[0]) - part.log_start
        yield part, float(found.measurements.time[row]) - axis_start - first
        row += len(part.measurements)


def summary(spans: Sequence[Span]) -> dict[str, str]:
    """Samples, duration and number of the spans left out, by cause, in words."""
    texts = {}
    for cause in CAUSES:
        own = [span for span in spans if span.cause == cause]
        if own:
            samples = sum(span.samples for span in own)
            lasts = sum(span.end - span.start for span in own)
            count = f"{samples} samples, " if samples else ""
            places = f"{len(own)} place{'s' if len(own) > 1 else ''}"
            texts[cause] = f"{count}{lasts:.3g} s in {places}"
    return texts


def _count_text(found: Ingested, curves: WrenchCurves) -> str:
    """Note if the points of the curves are averages or a selection of the samples."""
    samples, drawn = round(float(found.counts.sum())), len(curves.time)
    parts = []
    if samples > drawn:
        parts.append(f"{drawn:,} averages of {samples:,} samples")
    if len(thinned(curves.measured[:, :3])) < drawn:
        parts.append(
            "long curves are thinned for drawing to their lowest and highest points"
        )
    return f"Drawn: {'; '.join(parts)}." if parts else ""


def _figure(
    curves: WrenchCurves,
    spans: Sequence[Span],
    title: str,
    name: str,
    unit: str,
    first: int,
) -> Figure:
    layout = rows([f"{name} [{unit}]", f"Residual [{unit}]"], [3.0, 1.5], title)
    layout["shapes"] = [] if curves.static else list(marks(spans))
    traces: list[Trace] = []
    for kind in ("measured", "predicted", "residual"):
        values = getattr(curves, kind)[:, first : first + 3]
        row = "y2" if kind == "residual" else "y"
        traces += component_lines(curves.time, values, kind, row, dots=curves.static)
    about = f"{name} measured and predicted over time, and the residual"
    return Figure(f"wrench-{name.lower()}", traces, layout, 520, about)


def component_lines(
    time: Array, values: Array, kind: str, row: str, *, dots: bool
) -> Iterable[Trace]:
    """Curves of the three components; those of kind ``"measured"`` are wide and pale."""
    shown = thinned(values)
    for axis, column in zip(AXES, values.T, strict=True):
        pale = kind == "measured"
        colour = f"@{axis}-pale" if pale else f"@{axis}"
        more: dict[str, Any] = {"yaxis": row, "legendgroup": axis}
        if pale and not dots:
            more["line"] = {"color": colour, "width": 5}
        if pale and dots:
            more["marker"] = {"color": colour, "size": 13, "symbol": "square"}
        if kind == "residual":
            more["showlegend"] = False
        name = f"{kind} {axis}"
        yield curve(time, column, shown, name, colour, dots=dots, **more)


def marks(spans: Sequence[Span]) -> Iterable[dict[str, Any]]:
    """Spans left out as areas of the height of a figure, with one entry of the legend for
    each cause."""
    for cause in CAUSES:
        own = _fewer([span for span in spans if span.cause == cause])
        for i, span in enumerate(own):
            yield {
                "type": "rect",
                "xref": "x",
                "yref": "paper",
                "x0": round(span.start, 6),
                "x1": round(span.end, 6),
                "y0": 0,
                "y1": 1,
                "fillcolor": f"@{cause}",
                "line": {"color": f"@{cause}", "width": 1},
                "layer": "below",
                "name": CAUSES[cause].partition(":")[0],
                "legendgroup": cause,
                "showlegend": i == 0,
            }


def _fewer(spans: list[Span]) -> list[Span]:
    """At most `MOST_SPANS` spans: those with the shortest gaps are joined."""
    spans = sorted(spans, key=lambda span: span.start)
    if len(spans) <= MOST_SPANS:
        return spans
    gaps = np.array([b.start - a.end for a, b in pairwise(spans)])
    cuts = np.sort(np.argsort(gaps, kind="stable")[-(MOST_SPANS - 1) :])
    begins, ends = [0, *(cuts + 1)], [*cuts, len(spans) - 1]
    joined = []
    for b, e in zip(begins, ends, strict=True):
        group = spans[b : e + 1]
        end, samples = max(s.end for s in group), sum(s.samples for s in group)
        joined.append(Span(group[0].cause, group[0].start, end, samples))
    return joined


def recording(found: Ingested, estimator: Estimator) -> Section | None:
    """Drift, dynamism and weights over time; None for static poses."""
    if found.static:
        return None
    share = estimator.weight(found.measurements)  # of the full model
    share = share if isinstance(share, np.ndarray) and share.ndim else None
    figures = [_motion(found, share)]
    lines = ["The sensor's bias counts as constant: no drift was found."]
    if any(part.conditioned.bias.kind != "constant" for part in found.recordings):
        figures.insert(0, _drift(found))
        lines[0] = (
            "The sensor's bias drifts, as recorded; what it changes by was removed. Bands are 95 %."
        )
    lines.append(
        "Dynamism is |a|² + |α|² + (2|ω|)²: where it is near zero the wrench shows mass "
        "and centre of mass alone. A measurement's weight is that of its squared "
        "residuals, one on average."
    )
    if share is not None:
        lines.append("The method uses the full model by a share that follows dynamism.")
    content = join(*map(note, lines))
    title = "Drift, dynamism and weights"
    return Section("recording", title, content, tuple(figures))


def _drift(found: Ingested) -> Figure:
    titles = [f"Bias, {name.lower()} [{unit}]" for name, unit, _ in PARTS]
    layout, traces = rows(titles, [1.0, 1.0], x_title(found)), list(_drift_lines(found))
    return Figure("drift", traces, layout, 420, "The sensor's bias over time")


def _drift_lines(found: Ingested) -> Iterable[Trace]:
    for k, (part, shift) in enumerate(parts_of(found)):
        drift, z = part.conditioned.bias, part.measurements
        ends = np.array([z.time[0], z.time[-1]]) + part.conditioned.offset
        inner = drift.knots[(drift.knots > ends[0]) & (drift.knots < ends[1])]
        time = np.concatenate((ends[:1], inner, ends[1:]))
        values = drift(time)
        with np.errstate(invalid="ignore"):  # no band for infinite deviations
            reach = Z95 * interpolated(time, drift.knots, drift.std)
        shown = time - part.log_start + shift
        for i in range(6):
            axis, row = AXES[i % 3], "y" if i < 3 else "y2"
            low, high = values[:, i] - reach[:, i], values[:, i] + reach[:, i]
            place = {"yaxis": row, "legendgroup": axis}
            yield band(shown, low, high, f"@{axis}-pale") | place
            drawn = line(shown, values[:, i], f"bias {axis}", f"@{axis}")
            yield drawn | place | {"showlegend": i < 3 and k == 0}


def _motion(found: Ingested, share: Array | None) -> Figure:
    """Dynamism, weights if the measurements have them, and the share (K,) of the full
    model if the method has one."""
    z = found.measurements
    drawn = {"Dynamism": dynamism(z), "Weight": z.weights}
    drawn["Share of the full model"] = share
    drawn = {title: values for title, values in drawn.items() if values is not None}
    layout = rows(list(drawn), [1.0] * len(drawn), x_title(found))
    layout["showlegend"] = False
    time, traces = z.time - found.log_start, []
    for i, (title, values) in enumerate(drawn.items(), 1):
        row, shown = f"y{i}" if i > 1 else "y", thinned(values)
        traces.append(curve(time, values, shown, title.lower(), "@x", yaxis=row))
        layout[f"yaxis{row[1:]}"]["rangemode"] = "tozero"
    return Figure("motion", traces, layout, 170 * len(drawn) + 60, ", ".join(drawn))

"""Wrench: measured and predicted over time, what remains, and what was left out."""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.ingest.ingested import Ingested
from hefting.ingest.left_out import CAUSES, Span
from hefting.page.figure import AXES, Figure, Trace, curve, rows
from hefting.page.frame import Section
from hefting.page.html import element, items, join
from hefting.scene import WrenchCurves, thinned, wrench_curves
from hefting.scene.wrench import PARTS

MOST_SPANS = 150
"""Spans of one cause that are drawn: those nearest to each other become one."""
TIME, POSE = "Time since the start of the log [s]", "Pose"


def wrench(estimate: Estimate, found: Ingested) -> Section:
    """Force and torque of an estimate's recording."""
    curves = wrench_curves(found.measurements, estimate, found.log_start)
    spans = spans_of(found)
    figures = tuple(_figure(curves, spans, *part) for part in PARTS)
    shown = [
        "What the sensor exerts on the object, in sensor axes: measured (pale) and as "
        "the estimate predicts it, with the bias found; below, what remains.",
        _count_text(found, curves),
    ]
    lines = [f"{_words(cause)}: {text}" for cause, text in summary(spans).items()]
    left = "Left out:" if lines else "Nothing was left out."
    content = join(
        (
            *(element("p", text, class_="note") for text in shown if text),
            element("p", left),
            items(lines),
        )
    )
    return Section("wrench", "Wrench: measured, predicted, left out", content, figures)


def spans_of(found: Ingested) -> tuple[Span, ...]:
    """What was left out, on the time axis of the figures: of several recordings one
    after the other, as their measurements are."""
    return tuple(
        Span(s.cause, s.start + shift, s.end + shift, s.samples)
        for part, shift in parts_of(found)
        for s in part.left_out
    )


def parts_of(found: Ingested) -> Iterable[tuple[Ingested, float]]:
    """Each recording, and by how much [s] its times since the start of its log are
    later on the time axis of the figures."""
    row, axis_start = 0, found.log_start
    for part in found.recordings:
        first = float(part.measurements.time[0]) - part.log_start
        yield part, float(found.measurements.time[row]) - axis_start - first
        row += len(part.measurements)


def summary(spans: Sequence[Span]) -> dict[str, str]:
    """How much was left out for each cause, in words."""
    found = {}
    for cause in CAUSES:
        own = [span for span in spans if span.cause == cause]
        if own:
            samples = sum(span.samples for span in own)
            lasts = sum(span.end - span.start for span in own)
            count = f"{samples} samples, " if samples else ""
            places = f"{len(own)} place{'s' if len(own) > 1 else ''}"
            found[cause] = f"{count}{lasts:.3g} s in {places}"
    return found


def _words(cause: str) -> str:
    return CAUSES[cause][:1].upper() + CAUSES[cause][1:]


def _count_text(found: Ingested, curves: WrenchCurves) -> str:
    """What a point of the curves stands for, where it is no sample of the log."""
    samples, drawn = round(float(found.counts.sum())), len(curves.time)
    said = []
    if samples > drawn:
        said.append(f"{drawn:,} averages of {samples:,} samples")
    if len(thinned(curves.measured[:, :3])) < drawn:
        said.append(
            "long curves are thinned for drawing to their lowest and highest points"
        )
    return f"Drawn: {'; '.join(said)}." if said else ""


def _figure(
    curves: WrenchCurves, spans: Sequence[Span], name: str, unit: str, first: int
) -> Figure:
    """One part of the wrench: the whole, and what remains of it."""
    three = slice(first, first + 3)
    measured, predicted = curves.measured[:, three], curves.predicted[:, three]
    layout = rows(
        [f"{name} [{unit}]", f"Residual [{unit}]"],
        [3.0, 1.5],
        POSE if curves.static else TIME,
    )
    layout["shapes"] = [] if curves.static else list(marks(spans))
    traces: list[Trace] = []
    for kind, values, row in (
        ("measured", measured, "y"),
        ("predicted", predicted, "y"),
        ("residual", measured - predicted, "y2"),
    ):
        traces += component_lines(curves.time, values, kind, row, dots=curves.static)
    about = f"{name} measured and predicted over time, and the residual"
    return Figure(f"wrench-{name.lower()}", traces, layout, 520, about)


def component_lines(
    time: Array, values: Array, kind: str, row: str, *, dots: bool = False
) -> Iterable[Trace]:
    """The three components of a quantity; measured ones wide and pale."""
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
    """What was left out as areas over the height of a figure, in its legend once for
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
    """At most `MOST_SPANS`: those with the least time between them are joined."""
    spans = sorted(spans, key=lambda span: span.start)
    if len(spans) <= MOST_SPANS:
        return spans
    gaps = np.array([b.start - a.end for a, b in pairwise(spans)])
    cuts = np.sort(np.argsort(gaps, kind="stable")[-(MOST_SPANS - 1) :])
    begins, ends = [0, *(cuts + 1)], [*cuts, len(spans) - 1]
    return [
        Span(
            spans[b].cause,
            spans[b].start,
            max(s.end for s in spans[b : e + 1]),
            sum(s.samples for s in spans[b : e + 1]),
        )
        for b, e in zip(begins, ends, strict=True)
    ]

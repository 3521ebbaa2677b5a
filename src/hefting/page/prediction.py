"""Prediction: the wrench along a motion with its band, over what was measured."""

from collections.abc import Iterable

from hefting.page.answer import Say, verdict_box
from hefting.page.figure import AXES, Figure, Trace, band, curve, rows
from hefting.page.html import Section, items, join, note, table
from hefting.page.recording import POSE, component_lines
from hefting.prediction import Peak, Prediction
from hefting.scene import plus_minus, thinned
from hefting.scene.curves import PARTS

UNITS = {"f": "N", "t": "N m"}


def predicted(found: Prediction, say: Say) -> Iterable[Section]:
    """The verdict with peaks, and the wrench over time."""
    when = "pose" if found.static else "at [s]"
    top = [
        (f"largest {name}", _number(peak), UNITS[name[0]], _when(peak, found.static))
        for name, peak in found.peaks.items()
    ]
    ends = [
        (f"{side} {name}", _number(peak), UNITS[name[0]], _when(peak, found.static))
        for name, pair in found.extremes.items()
        for side, peak in zip(("lowest", "highest"), pair, strict=True)
    ]
    meaning = "The sensor exerts it on the object, in sensor axes about its origin."
    if found.std is not None:
        meaning += " ± is half the 95 % band of the object's own wrench."
    content = join(
        verdict_box(found.verdict, found.warnings, say),
        table(("", "value", "unit", when), [*top, *ends]),
        note(meaning),
    )
    yield Section("answer", "Answer", content)
    figures = tuple(_figure(found, *part) for part in PARTS)
    notes = [say(str(line)) for line in (*found.notes, *_agreement(found))]
    yield Section("wrench", "Wrench along the motion", items(notes), figures)


def _number(peak: Peak) -> str:
    return plus_minus(peak.value, peak.reach)


def _when(peak: Peak, static: bool) -> str:
    return f"{peak.time + 1:.0f}" if static else f"{peak.time:.3f}"


def _agreement(found: Prediction) -> Iterable[str]:
    a = found.agreement
    if a is None:
        return
    yield (
        f"Measured less predicted: {a.rms[0]:.3g} N, {a.rms[1]:.3g} N m root mean "
        f"square; without its mean, which may be another bias, {a.varying[0]:.3g} N, "
        f"{a.varying[1]:.3g} N m."
    )
    yield from a.notes


def _figure(found: Prediction, name: str, unit: str, first: int) -> Figure:
    """One part of the wrench, and the difference where there is one."""
    three, a, dots = slice(first, first + 3), found.agreement, found.static
    titles, heights = [f"{name} [{unit}]"], [3.0]
    if a is not None:
        titles, heights = [*titles, f"Difference [{unit}]"], [3.0, 1.5]
    layout = rows(titles, heights, POSE if dots else "Time [s]")
    traces: list[Trace] = []
    if a is not None:
        time = a.time + dots
        measured, rest = a.wrench[:, three], a.difference[:, three]
        traces += component_lines(time, measured, "measured", "y", dots=dots)
        traces += component_lines(time, rest, "residual", "y2", dots=dots)
    traces += _with_band(found, three, dots)
    return Figure(
        f"prediction-{name.lower()}",
        traces,
        layout,
        520 if a is not None else 380,
        f"{name} along the motion, with its 95 % band",
    )


def _with_band(found: Prediction, three: slice, dots: bool) -> Iterable[Trace]:
    """The three components, and the band of each."""
    values = found.wrench[:, three]
    shown, time = thinned(values), found.time + dots
    for k, axis in enumerate(AXES):
        if found.low is not None and found.high is not None:
            low, high = found.low[shown, three][:, k], found.high[shown, three][:, k]
            colour = f"@{axis}-pale"
            yield band(time[shown], low, high, colour, legendgroup=axis)
        yield curve(
            time,
            values[:, k],
            shown,
            f"predicted {axis}",
            f"@{axis}",
            dots=dots,
            legendgroup=axis,
        )

"""Origin: the estimate after each part of the recording, the contributions of shape and
motion, and the assumptions."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hefting.core.errors import HeftingError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array
from hefting.core.summary import sign_told
from hefting.estimators import OLS, Estimator, settings_text
from hefting.identification.checks import with_diagnostics
from hefting.identification.convergence import Convergence, convergence
from hefting.identification.estimator import estimator_for
from hefting.identification.run import run
from hefting.ingest.ingested import Ingested
from hefting.page.answer import (
    GROUPS,
    NAMES,
    SCALE,
    Group,
    Say,
    ends_of,
    ends_of_intervals,
    ten,
)
from hefting.page.figure import AXES, Figure, Trace, band, line, rows
from hefting.page.html import (
    Markup,
    Row,
    Section,
    bars,
    element,
    items,
    join,
    note,
    terms,
)
from hefting.page.recording import x_title
from hefting.scene import vector_text

WARMING_UP = 0.25
"""Share of the instants, from the first on, that the scale may leave out, as intervals
are often far wider there."""
ACTS = {
    "on-object": "the log holds what the sensor exerts on the object (on-object)",
    "on-sensor": "the log holds what the object exerts on the sensor (on-sensor)",
}


def converged(
    estimate: Estimate,
    found: Ingested,
    estimator: Estimator,
    truth: InertialParameters | None,
) -> Section:
    """The method's estimates from the samples up to each of several instants."""
    over, open_ = convergence(estimator, found, estimate), estimate.undetermined.ten
    over = replace(over, values=np.where(open_, np.nan, over.values))
    time = (
        over.rows.astype(float)
        if found.static
        else found.measurements.time[over.rows - 1] - found.log_start
    )
    known = None if truth is None else ten(truth)
    figures = tuple(
        _figure(over, time, group, known, x_title(found)) for group in GROUPS
    )
    says = (
        f"{estimate.method} from the samples up to each of {len(time)} instants, with "
        "its 95 % intervals. Clock, drift and what was left out are those found from "
        "the whole recording. Wide intervals at the beginning may exceed the scale."
    )
    says += " What is open has no line." if open_.any() else ""
    says += "" if truth is None else " Dashed: the truth."
    content = note(says)
    return Section("convergence", "How the answer came about", content, figures)


def _figure(
    over: Convergence, time: Array, group: Group, truth: Array | None, title: str
) -> Figure:
    titles = [f"{NAMES[i]} [{group.unit}]" for i in group.rows]
    layout = rows(titles, [1.0] * len(titles), title)
    layout["showlegend"] = False
    traces: list[Trace] = []
    for k, (i, axis) in enumerate(zip(group.rows, AXES, strict=False), 1):
        row = f"y{k}" if k > 1 else "y"
        layout[f"yaxis{row[1:]}"]["range"] = _range(over, i, truth)
        traces += _lines(over, time, i, axis, row)
        if truth is not None:
            ends, level = (float(time[0]), float(time[-1])), float(truth[i])
            look = {"line": {"color": "@truth", "width": 1.5, "dash": "dash"}}
            name, both = f"true {NAMES[i]}", (level, level)
            traces.append(line(ends, both, name, "@truth", yaxis=row) | look)
    height = 110 + 150 * len(titles)
    about = f"{group.title} over the recording"
    return Figure(f"convergence-{group.rows[0]}", traces, layout, height, about)


def _lines(
    over: Convergence, time: Array, i: int, axis: str, row: str
) -> Iterable[Trace]:
    values = SCALE[i] * over.values[:, i]
    if over.low is not None and over.high is not None:
        low, high = SCALE[i] * over.low[:, i], SCALE[i] * over.high[:, i]
        yield band(time, low, high, f"@{axis}-pale", yaxis=row)
        values = np.where(np.isinf(low) & np.isinf(high), np.nan, values)
    look = {"mode": "lines+markers", "marker": {"color": f"@{axis}", "size": 5}}
    yield line(time, values, NAMES[i], f"@{axis}", yaxis=row) | look


def _range(over: Convergence, i: int, truth: Array | None) -> list[float] | None:
    """Ends of a scale that holds all values and intervals after `WARMING_UP`, with a
    margin; None if none is finite."""
    first = int(WARMING_UP * len(over.rows))
    held = [SCALE[i] * over.values[first:, i]]
    held += [
        SCALE[i] * ends[first:, i] for ends in (over.low, over.high) if ends is not None
    ]
    held += [] if truth is None else [truth[[i]]]
    numbers = np.concatenate(held)
    numbers = numbers[np.isfinite(numbers)]
    if not len(numbers):
        return None
    low, high = float(numbers.min()), float(numbers.max())
    room = 0.06 * (high - low) or max(abs(high), 1e-9)
    return [low - room, high + room]


def prior(
    estimate: Estimate, found: Ingested, estimator: Estimator, shape_known: bool
) -> Section | None:
    """Intervals of the prior, of least squares on the motion, and of the estimate; None
    for a method without a prior."""
    intervals = estimator.prior_intervals(estimate.mass)
    if intervals is None:
        return None
    what = "shape" if shape_known else "reach of the sensor"
    sources: list[tuple[str, Any, Array, Array, bool]]
    sources = [(what, [None] * 10, *ends_of_intervals(intervals), True)]
    if (alone := least_squares(found)) is not None:
        sources.append(("motion", ten(alone[0].parameters), *ends_of(alone[0]), False))
    sources.append(("both", ten(estimate.parameters), *ends_of(estimate), True))
    short = [name.removeprefix("COM ") for name in NAMES]
    groups: list[Markup] = []
    for group in GROUPS[1:]:
        rows = [
            Row(f"{short[i]}: {by}", v[i], low[i], high[i], matters=matters)
            for i in group.rows
            for by, v, low, high, matters in sources
        ]
        shown = element("h3", group.title), bars(rows, group.unit)
        groups.append(element("div", *shown))
    says = (
        f"The {what} alone (for the mass found, which it does not show), least "
        "squares on the motion alone, and the answer from both. A bar that fills its "
        "row is wider than the scale; a hatched one is open."
    )
    known = "what the shape" if shape_known else "what was known before"
    content = join(note(says), element("div", *groups, class_="groups"))
    return Section("prior", f"What the motion shows, and {known}", content)


def least_squares(found: Ingested) -> tuple[Estimate, Estimator] | None:
    """The estimate of least squares, with its diagnostics, and its estimator; None if it
    cannot be made."""
    try:
        estimator = estimator_for(OLS, found, None, {})
        estimate, used = run(estimator, found)
    except HeftingError:
        return None
    return with_diagnostics(estimate, estimator, used, None), estimator


def assumptions(estimate: Estimate, say: Say) -> Section:
    """Assumptions and findings about the recording, and settings of the method."""
    made = estimate.provenance
    settings = settings_text(made)
    with_settings = f", with {settings}" if settings else ""
    pairs = [
        ("Log", made.get("log", "not known")),
        ("Samples", _samples(estimate)),
        ("Sign", _sign(estimate)),
        ("Frame", "all results in the sensor's axes, about its origin"),
        ("Gravity", _gravity(made)),
        ("Bias", _bias(estimate)),
        ("Clock", _clock(made)),
        ("Motion", made.get("motion", "not known")),
        ("Tool", _tool(made)),
        ("Method", f"{estimate.method}{with_settings}"),
    ]
    parts = [terms(pairs)]
    if notes := [say(str(note)) for note in made.get("notes", ())]:
        parts += [element("h3", "Found on the way"), items(notes)]
    return Section("assumptions", "Assumptions", join(*parts))


def _samples(estimate: Estimate) -> str:
    if estimate.duration is None:
        return f"{estimate.samples:,} static poses"
    return f"{estimate.samples:,} over {estimate.duration:.4g} s"


def _sign(estimate: Estimate) -> str:
    wrench = str(estimate.provenance.get("wrench", "not known"))
    how = sign_told(estimate.provenance, estimate.warnings)
    return f"{ACTS.get(wrench, wrench)}, {how}"


def _gravity(made: Mapping[str, Any]) -> str:
    if "gravity" not in made:
        return "not known"
    found = ", direction found" if made.get("gravity_found") else ""
    std = made.get("gravity_std")
    known = f", its size ± {std:.2g} m/s²" if std else ""
    return f"{vector_text(made['gravity'], 4)} m/s² in world axes{found}{known}"


def _bias(estimate: Estimate) -> str:
    made, bias = estimate.provenance, estimate.common_bias
    if estimate.bias is not None and bias is None:
        return "found with the object, one for each recording"
    given, how = made.get("bias_subtracted"), "given, and subtracted"
    if bias is not None:
        given = -bias if made.get("wrench") == "on-sensor" else bias
        how = "found with the object, as recorded"
    if given is not None:
        numbers = np.asarray(given, dtype=float)
        force, torque = vector_text(numbers[:3]), vector_text(numbers[3:])
        return f"{how}: {force} N, {torque} N m"
    searched = made.get("bias_searched")
    return "none beyond three standard deviations" if searched else "none, as given"


def _clock(made: Mapping[str, Any]) -> str:
    offset = made.get("clock_offset")
    if made.get("recordings"):
        return "one for each recording, found"
    if offset is None:
        return "not known"
    if not offset:
        return "wrench and motion share one: no significant offset"
    side = "late" if offset > 0.0 else "early"
    return f"the wrench is {1e3 * abs(offset):.3g} ms {side}, corrected"


def _tool(made: Mapping[str, Any]) -> str:
    tool = made.get("tool")
    if not tool:
        return "none: what is shown is all that the sensor holds"
    return f"{tool[0]:.4g} kg were subtracted: what is shown is the object alone"

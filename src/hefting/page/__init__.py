"""Page: a report as one HTML file that needs no network; drawn by plotly from plain
data.

    html = identification_page(found.estimate, found.ingested, found.estimator)

The files of this package make the sections; `hefting.page.html` assembles the page and
escapes text from files and users.
"""

from collections.abc import Callable, Iterable

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, immutable
from hefting.estimators import Estimator
from hefting.export import REGISTRY, Target, export
from hefting.identification.compare import Comparison
from hefting.ingest.ingested import Ingested
from hefting.inspection import Inspection
from hefting.page.answer import Say, answer, inspected, methods, verdict_box
from hefting.page.figure import AXES, Figure, Trace, band, curve, rows
from hefting.page.html import (
    Markup,
    Section,
    element,
    items,
    join,
    note,
    page_of,
    table,
)
from hefting.page.origin import assumptions, converged, least_squares, prior
from hefting.page.recording import POSE, component_lines, recording, wrench
from hefting.page.solid import solid
from hefting.prediction import Peak, Prediction
from hefting.scene import PARTS, plus_minus, scene_of, thinned
from hefting.shapes import Shape

__all__ = ["Context", "identification_page", "inspection_page", "prediction_page"]

UNITS = {"f": "N", "t": "N m"}


@immutable
class Context:
    """What a page shows in addition to the result."""

    shape: Shape | None = None
    truth: InertialParameters | None = None
    flange: Array | None = None
    """(4, 4) pose of the sensor in the flange's frame [m], for controllers"""
    command: str | None = None
    """Command that made the result, as typed"""
    say: Callable[[str], str] = str
    """Turns names of arguments in backquotes into the reader's"""


def identification_page(
    estimate: Estimate,
    found: Ingested,
    estimator: Estimator,
    context: Context | None = None,
    comparison: Comparison | None = None,
    title: str = "What the sensor holds",
) -> str:
    """A page of an identified object, or of a calibrated tool.

    Parameters
    ----------
    estimate : Estimate
        The answer; of several methods that of the recommended one.
    found : Ingested
        The recording as far as it was used, as in `Identification.ingested`.
    estimator : Estimator
        The estimator that made it.
    context : Context, optional
        Shape, truth and more to show.
    comparison : Comparison, optional
        Comparison of several methods.
    title : str
        Title of the page.

    Returns
    -------
    str
        The complete HTML.

    Raises
    ------
    MissingDependencyError
        Without plotly.

    Examples
    --------
    >>> from hefting.page import identification_page
    >>> found = hefting.identify("demo/log.csv")
    >>> page = identification_page(found.estimate, found.ingested, found.estimator)
    >>> "Centre of mass" in page
    True
    """
    c = context or Context()
    sections = [
        answer(estimate, c.truth, c.say),
        None if comparison is None else methods(comparison, c.truth, c.say),
        *_recording_sections(estimate, found, estimator, c),
        _object_section(estimate, found, c),
        prior(estimate, found, estimator, c.shape is not None),
        assumptions(estimate, c.say),
        command(c.command),
        controllers(estimate, c.flange, c.say),
    ]
    return page_of(title, _source_lines(estimate.provenance.get("log")), sections)


def inspection_page(inspection: Inspection, context: Context | None = None) -> str:
    """A page of an inspected recording: its content, and the estimate of least squares;
    arguments and errors as of `identification_page`."""
    c = context or Context()
    found = inspection.ingested
    sections: list[Section | None] = list(inspected(inspection, c.say))
    alone = None if found is None else least_squares(found)
    if found is not None and alone is not None:
        estimate, estimator = alone
        sections += [
            *_recording_sections(estimate, found, estimator, c),
            _object_section(estimate, found, c),
            assumptions(estimate, c.say),
        ]
    sections.append(command(c.command))
    return page_of("What the log holds", _source_lines(inspection.log), sections)


def prediction_page(
    prediction: Prediction, estimate: Estimate, context: Context | None = None
) -> str:
    """A page of a wrench predicted from an estimate; arguments and errors as of
    `identification_page`."""
    c = context or Context()
    sections = [
        *predicted(prediction, c.say),
        solid(scene_of({"estimate": estimate})),
        command(c.command),
        controllers(estimate, c.flange, c.say),
    ]
    lines = _source_lines(prediction.trajectory)
    return page_of("The wrench along a motion", lines, sections)


def _recording_sections(
    estimate: Estimate, found: Ingested, estimator: Estimator, c: Context
) -> list[Section | None]:
    return [
        wrench(estimate, found),
        recording(found, estimator),
        converged(estimate, found, estimator, c.truth),
    ]


def _object_section(estimate: Estimate, found: Ingested, c: Context) -> Section:
    count = 0 if estimate.point_masses is None else len(estimate.point_masses)
    masses = c.shape is not None and count == c.shape.n
    gravity, known = found.measurements.gravity, {"truth": c.truth}
    return solid(scene_of({"estimate": estimate}, c.shape, known, gravity, masses))


def _source_lines(log: object) -> tuple[str, ...]:
    return (f"From {log}",) if log else ()


def controllers(estimate: Estimate, flange: Array | None, say: Say) -> Section:
    """A select box of controllers, and the text for each."""
    # targets with suffixes are files for simulators, and tables
    shown = [t for t in REGISTRY.values() if t.write is not None and not t.suffixes]
    choices = [element("option", t.description, value=t.name) for t in shown]
    texts = [_target_text(estimate, target, flange, say) for target in shown]
    label = element("label", "Robot: ", element("select", *choices, id="controller"))
    button = element("button", "Copy", data_copy="controller-texts", type="button")
    content = join(
        element("p", label, " ", button), element("div", *texts, id="controller-texts")
    )
    return Section("controllers", "Values for a robot's controller", content)


def _target_text(
    estimate: Estimate, target: Target, flange: Array | None, say: Say
) -> Markup:
    pose = None if target.in_sensor_axes else flange
    try:
        found = export(estimate, target.name, pose, say=say)
    except InputError as error:
        parts = [element("p", say(f"Nothing to paste: {error}."))]
    else:
        notes = items([say(line) for line in found.warnings], class_="note")
        parts = [notes, element("pre", found.text, class_="wrap")]
    return element("div", *parts, data_target=target.name)


def command(words: str | None) -> Section | None:
    """The command with a button that copies it; None without a command."""
    if words is None:
        return None
    button = element("button", "Copy", data_copy="command-text", type="button")
    text: Markup = element("pre", words, class_="wrap", id="command-text")
    return Section("command", "The command", join(text, button))


def predicted(found: Prediction, say: Say) -> Iterable[Section]:
    """Sections of the verdict and the peaks, and of the wrench over time."""
    when = "pose" if found.static else "at [s]"

    def row(which: str, name: str, peak: Peak) -> tuple[str, ...]:
        at = f"{peak.time + 1:.0f}" if found.static else f"{peak.time:.3f}"
        value = plus_minus(peak.value, peak.reach)
        return f"{which} {name}", value, UNITS[name[0]], at

    shown = [row("largest", name, peak) for name, peak in found.peaks.items()]
    for name, (lowest, highest) in found.extremes.items():
        shown += [row("lowest", name, lowest), row("highest", name, highest)]
    meaning = f"By {found.method}; exerted by the sensor, in its axes about its origin."
    if found.std is not None:
        meaning += " ± is half the 95 % band of that wrench itself."
    content = join(
        verdict_box(found.verdict, found.warnings, say),
        table(("", "value", "unit", when), shown),
        note(meaning),
    )
    yield Section("answer", "Answer", content)
    figures = tuple(_figure(found, *part) for part in PARTS)
    notes = [say(str(line)) for line in (*found.notes, *_agreement_lines(found))]
    yield Section("wrench", "Wrench along the motion", items(notes), figures)


def _agreement_lines(found: Prediction) -> Iterable[str]:
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

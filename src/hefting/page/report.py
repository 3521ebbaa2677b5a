"""Report: which sections a page has, in which order."""

from collections.abc import Callable
from dataclasses import dataclass

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array
from hefting.estimators import Estimator
from hefting.identification.compare import Comparison
from hefting.ingest.ingested import Ingested
from hefting.inspection import Inspection
from hefting.page.answer import answer
from hefting.page.assumptions import assumptions
from hefting.page.controllers import command, controllers
from hefting.page.convergence import converged
from hefting.page.frame import Heading, Section, page_of
from hefting.page.inspection import inspected
from hefting.page.least_squares import least_squares
from hefting.page.methods import methods
from hefting.page.prediction import predicted
from hefting.page.prior import prior
from hefting.page.recording import recording
from hefting.page.solid import solid
from hefting.page.wrench import wrench
from hefting.prediction import Prediction
from hefting.scene import scene_of
from hefting.shapes import Shape


@dataclass(frozen=True, eq=False)
class Context:
    """What a page shows besides the result."""

    shape: Shape | None = None
    truth: InertialParameters | None = None
    flange: Array | None = None
    """(4, 4) pose of the sensor in the flange's frame [m], for controllers"""
    command: str | None = None
    """That made the result, as one would type it"""
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
        The answer; of several methods the one recommended.
    found : Ingested
        The recording as far as it was used, as in `Identification.ingested`.
    estimator : Estimator
        That made the estimate.
    context : Context, optional
        Shape, truth and what else is shown.
    comparison : Comparison, optional
        Of several methods.
    title : str
        Of the page.

    Returns
    -------
    str
        HTML that needs nothing else.

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
    c = Context() if context is None else context
    sections = [
        answer(estimate, c.truth, c.say),
        None if comparison is None else methods(comparison, c.truth, c.say),
        *_of_recording(estimate, found, estimator, c),
        _object(estimate, found, c),
        prior(estimate, found, estimator, c.shape is not None),
        assumptions(estimate, c.say),
        command(c.command),
        controllers(estimate, c.flange, c.say),
    ]
    return page_of(_heading(title, estimate.provenance.get("log", "")), _kept(sections))


def inspection_page(inspection: Inspection, context: Context | None = None) -> str:
    """A page of a recording that was inspected: what it holds, and what least squares
    finds from it; arguments and errors as of `identification_page`."""
    c = Context() if context is None else context
    found = inspection.ingested
    sections: list[Section | None] = list(inspected(inspection, c.say))
    alone = None if found is None else least_squares(found)
    if found is not None and alone is not None:
        estimate, estimator = alone
        sections += [
            *_of_recording(estimate, found, estimator, c),
            _object(estimate, found, c),
            assumptions(estimate, c.say),
        ]
    sections.append(command(c.command))
    return page_of(_heading("What the log holds", inspection.log), _kept(sections))


def prediction_page(
    prediction: Prediction, estimate: Estimate, context: Context | None = None
) -> str:
    """A page of a predicted wrench, by the estimate it follows from; arguments and
    errors as of `identification_page`."""
    c = Context() if context is None else context
    sections = [
        *predicted(prediction, c.say),
        solid(scene_of({"estimate": estimate})),
        command(c.command),
        controllers(estimate, c.flange, c.say),
    ]
    heading = _heading("The wrench along a motion", prediction.trajectory)
    return page_of(heading, _kept(sections))


def _of_recording(
    estimate: Estimate, found: Ingested, estimator: Estimator, c: Context
) -> list[Section | None]:
    """Wrench, drift and weights, and how the answer came about."""
    return [
        wrench(estimate, found),
        recording(found, estimator),
        converged(estimate, found, estimator, c.truth),
    ]


def _object(estimate: Estimate, found: Ingested, c: Context) -> Section:
    """The object in three dimensions."""
    known = {} if c.truth is None else {"truth": c.truth}
    count = 0 if estimate.point_masses is None else len(estimate.point_masses)
    masses = c.shape is not None and count == c.shape.n
    gravity = found.measurements.gravity
    scene = scene_of({"estimate": estimate}, c.shape, known, gravity, masses=masses)
    return solid(scene)


def _heading(title: str, log: object) -> Heading:
    """Title, and the log, if it is known."""
    return Heading(title, (f"From {log}",) if log else ())


def _kept(sections: list[Section | None]) -> list[Section]:
    return [section for section in sections if section is not None]

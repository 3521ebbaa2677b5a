"""Prior: what the shape told, what the motion, and what both together."""

from hefting.core.estimate import Estimate
from hefting.estimators import Estimator
from hefting.ingest.ingested import Ingested
from hefting.page.bars import Row, bars
from hefting.page.frame import Section
from hefting.page.html import Markup, element, join
from hefting.page.least_squares import least_squares
from hefting.page.quantities import (
    GROUPS,
    NAMES,
    ends_of,
    ends_of_intervals,
    ten,
)


def prior(
    estimate: Estimate, found: Ingested, estimator: Estimator, shape_known: bool
) -> Section | None:
    """Intervals before the motion, by the motion alone, and by both; None for a method
    without a prior."""
    intervals = estimator.prior_intervals(estimate.mass)
    if intervals is None:
        return None
    before, after = ends_of_intervals(intervals), ends_of(estimate)
    by_motion = least_squares(found)
    alone = None if by_motion is None else by_motion[0]
    what = "shape" if shape_known else "reach of the sensor"
    groups: list[Markup] = []
    for group in GROUPS[1:]:
        rows = [
            row
            for i in group.rows
            for row in _rows(i, what, before, alone, estimate, after)
        ]
        groups.append(
            element("div", element("h3", group.title), bars(rows, group.unit))
        )
    says = (
        f"The {what} alone (for the mass found, of which it tells nothing), least "
        "squares on the motion alone, and the answer from both. A bar that fills its "
        "row is wider than the scale; a hatched one is open."
    )
    content = join(
        (
            element("p", says, class_="note"),
            element("div", *groups, class_="groups"),
        )
    )
    title = "What the motion told, and what the shape"
    if not shape_known:
        title = "What the motion told, and what was known before"
    return Section("prior", title, content)


def _rows(i: int, what: str, before, alone: Estimate | None, estimate: Estimate, after):
    """Three bars of one quantity."""
    name = NAMES[i].removeprefix("COM ")
    yield Row(f"{name}: {what}", None, before[0][i], before[1][i])
    if alone is not None:
        low, high = ends_of(alone)
        value = float(ten(alone.parameters)[i])
        yield Row(f"{name}: motion", value, low[i], high[i], matters=False)
    value = float(ten(estimate.parameters)[i])
    yield Row(f"{name}: both", value, after[0][i], after[1][i])

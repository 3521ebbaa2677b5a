"""Answer: the verdict on an estimate or a log with advice, and numbers with their
intervals, by one method or several."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import Verdict
from hefting.core.sensor_accuracy import Z95
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array
from hefting.identification.compare import Comparison
from hefting.identification.convergence import ten_ends, ten_of
from hefting.inspection import Inspection
from hefting.page.html import (
    Markup,
    Row,
    Section,
    bars,
    element,
    items,
    join,
    note,
    table,
    terms,
)
from hefting.scene.surface import reach

WORDS = {
    "good": ("good", "Good", "Use it: no check found a reason against it."),
    "usable with care": (
        "care",
        "Usable with care",
        "Use it if the doubts below do not matter; else remove their causes and record again.",
    ),
    "do not use": (
        "bad",
        "Do not use",
        "A reason below makes it wrong: correct that, and record or identify again.",
    ),
}
"""Style, title and advice of each verdict."""
MEANING = "Each bar is a 95 % interval, the line across it the value; ± reaches to its farther end. In sensor axes."
Say = Callable[[str], str]
NAMES = (
    "mass",
    *(f"COM {axis}" for axis in "xyz"),
    *(f"J{name}" for name in ("xx", "xy", "xz", "yy", "yz", "zz")),
)
"""Names of the ten numbers; J is about the COM."""
SCALE = np.array((1.0, *[1e3] * 3, *[1e3] * 6))
"""(10,) factors from SI units to those shown."""


def answer(estimate: Estimate, truth: InertialParameters | None, say: Say) -> Section:
    """The verdict of an estimate, and its numbers with the truth; `say` turns names of
    arguments in backquotes into the reader's."""
    marks = " The triangle is the truth." if truth is not None else ""
    content = join(
        verdict_box(estimate.verdict, estimate.warnings, say),
        *_number_bars(estimate, truth),
        note(MEANING + marks),
    )
    return Section("answer", "Answer", content)


def verdict_box(verdict: Verdict, warnings: Iterable[str], say: Say) -> Markup:
    """The verdict in plain words, its reasons, and the other warnings."""
    style, words, advice = WORDS[verdict.level]
    parts: list[Markup] = [
        element("strong", f"{words}."),
        element("p", advice),
        items(say(reason) for reason in verdict.reasons),
    ]
    if others := verdict.others(warnings):
        parts += [element("p", "Also:"), items(say(line) for line in others)]
    return element("div", *parts, class_=f"verdict {style}")


def _number_bars(
    estimate: Estimate, truth: InertialParameters | None
) -> Iterable[Markup]:
    values, (low, high) = ten(estimate.parameters), ends_of(estimate)
    known = [None] * 10 if truth is None else ten(truth)
    for group in GROUPS:
        rows = [Row(NAMES[i], values[i], low[i], high[i], known[i]) for i in group.rows]
        yield element("h3", group.title)
        yield bars(rows, group.unit, from_zero=True)


class Group(NamedTuple):
    """Some of the ten numbers, of one unit."""

    title: str
    unit: str
    rows: tuple[int, ...]
    """indices"""


GROUPS = (
    Group("Mass", "kg", (0,)),
    Group("Centre of mass, from the sensor's origin", "mm", (1, 2, 3)),
    Group("Moments of inertia about the centre of mass", "g m²", (4, 7, 9)),
    Group("Products of inertia about the centre of mass", "g m²", (5, 6, 8)),
)


def ten(body: InertialParameters) -> Array:
    """(10,) numbers of a body, in the units shown."""
    return SCALE * ten_of(body)


def ends_of(estimate: Estimate) -> tuple[Array, Array]:
    """(10,) lower and upper ends of the 95 % intervals of an estimate, in the units
    shown; infinite where open, NaN if the method has none."""
    if estimate.intervals is not None:
        low, high = ends_of_intervals(estimate.intervals)
    else:
        half, values = _half_widths(estimate), ten(estimate.parameters)
        low, high = values - half, values + half
    open_ = estimate.undetermined.ten
    return np.where(open_, -np.inf, low), np.where(open_, np.inf, high)


def ends_of_intervals(intervals: dict[str, Array]) -> tuple[Array, Array]:
    """As `ends_of`, from `Estimate.intervals`."""
    low, high = ten_ends(intervals)
    return SCALE * low, SCALE * high


def _half_widths(estimate: Estimate) -> Array:
    """(10,) half-widths of the intervals in the units shown, NaN if there are none."""
    parts = [
        reach(estimate, name) for name in ("mass", "center_of_mass", "inertia_at_com")
    ]
    if any(part is None for part in parts):
        return np.full(10, np.nan)
    mass, com, inertia = (np.asarray(part) for part in parts)
    return SCALE * np.concatenate(([mass], com, inertia[TENSOR_ROWS, TENSOR_COLUMNS]))


def methods(
    comparison: Comparison, truth: InertialParameters | None, say: Say
) -> Section:
    """A table of all methods, and the intervals of each quantity by all of them."""
    best = comparison.recommended
    shown, skipped = comparison.shown, comparison.skipped
    known = [None] * 10 if truth is None else ten(truth)
    found = {name: (ten(e.parameters), *ends_of(e)) for name, e in shown.items()}
    groups = [
        _method_bars(found, best, i, group.unit, known[i])
        for group in GROUPS[:3]
        for i in group.rows
    ]
    content = join(
        element("p", f"Recommended: {best}, as {say(comparison.reason)}."),
        _method_table(shown, best),
        element("div", *groups, class_="groups"),
        items(f"{name} was left out: {say(why)}" for name, why in skipped.items()),
    )
    return Section("methods", "Methods side by side", content)


def _method_table(shown: dict[str, Estimate], best: str) -> Markup:
    rows = []
    for name, estimate in shown.items():
        residual = ["", ""]
        if estimate.residual is not None:
            residual = [f"{value:.2g}" for value in estimate.residual]
        marked = f"{name} ◀" if name == best else name
        can_be = "yes" if estimate.physically_consistent else "no"
        rows.append((marked, estimate.verdict, *residual, can_be))
    head = ("method", "verdict", "residual [N]", "residual [N m]", "a body can be so")
    return table(head, rows)


def _method_bars(
    found: dict, best: str, i: int, unit: str, truth: float | None
) -> Markup:
    """Quantity `i` by all methods; the scale fits the interval of the recommended one and
    those whose value is near to its."""
    own, low, high = (each[i] for each in found[best])
    reach = 3.0 * max(high - low, 0.05 * abs(own))
    rows = []
    for name, (v, low, high) in found.items():
        matters = name == best or abs(v[i] - own) <= reach
        rows.append(Row(name, v[i], low[i], high[i], truth, matters))
    return element("div", element("h3", NAMES[i]), bars(rows, unit))


def inspected(found: Inspection, say: Say) -> Iterable[Section]:
    """The verdict with advice, and the streams of the log."""
    parts = [verdict_box(found.verdict, found.warnings, say)]
    if found.advice:
        lines = [say(line) for line in found.advice]
        parts += [element("h3", "What to do next"), items(lines)]
    parts.append(terms(_facts(found)))
    yield Section("answer", "Answer", join(*parts))
    yield _streams(found)


def _facts(found: Inspection) -> Iterable[tuple[str, str]]:
    facts = found.facts
    if facts is None:
        return
    if facts.mass is not None and facts.mass_std is not None:
        yield (
            "Mass",
            f"{facts.mass:.4g} ± {Z95 * facts.mass_std:.2g} kg (least squares; ± by noise alone)",
        )
    if found.sign is not None:
        sure = "certain" if found.sign.certain else "not certain"
        yield "Sign", f"{found.sign.name}, {sure}"
    moved = found.movement
    if moved is not None:
        yield (
            "Turned",
            f"gravity turned by up to {np.degrees(moved.turn):.0f}° in sensor axes",
        )
        yield "Fastest", f"{moved.angular_speed[1]:.3g} rad/s"
    if found.undetermined:
        yield "Open", f"the motion leaves {', '.join(found.undetermined)} open"
    elif found.identifiability is not None:
        yield "Open", "nothing: the motion determines all ten parameters"


def _streams(found: Inspection) -> Section:
    rows = []
    for name, facts in found.streams.items():
        gaps = (
            f"{facts.gaps}, longest {facts.longest_gap:.3g} s" if facts.gaps else "none"
        )
        rate = f"{facts.rate:.4g}" if facts.rate else "–"
        cells = [] if found.static else [rate, gaps]
        rows.append((name.replace("_", " "), f"{facts.samples:,}", *cells))
    head = ["stream", "samples"] + ([] if found.static else ["rate [Hz]", "gaps"])
    return Section("streams", "What the log holds", table(head, rows))

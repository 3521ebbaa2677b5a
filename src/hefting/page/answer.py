"""Answer: whether to trust an estimate, what to do, and its numbers with their
intervals."""

from collections.abc import Callable, Iterable, Sequence

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.verdict import Verdict
from hefting.page.bars import Row, bars
from hefting.page.frame import Section
from hefting.page.html import Markup, element, items, join
from hefting.page.quantities import GROUPS, NAMES, ends_of, ten

WORDS = {
    "good": ("good", "Good", "Use it: nothing that was looked at speaks against it."),
    "usable with care": (
        "care",
        "Usable with care",
        "Use it where the doubts below do not matter, or see to them and record again.",
    ),
    "do not use": (
        "bad",
        "Do not use",
        "Something below makes it wrong: see to that and record or identify again.",
    ),
}
"""Style of each verdict, its words, and what to do."""
MEANING = (
    "Each bar is a 95 % interval, the dark line in it the value; ± is half its width, "
    "the larger side. In sensor axes."
)
Say = Callable[[str], str]


def answer(
    estimate: Estimate,
    truth: InertialParameters | None,
    say: Say,
    verdict: Verdict | None = None,
    warnings: Sequence[str] | None = None,
) -> Section:
    """The verdict, and the numbers.

    Parameters
    ----------
    estimate : Estimate
        What is shown.
    truth : InertialParameters, optional
        Marked beside it.
    say : callable
        Turns names of arguments in backquotes into the reader's.
    verdict, warnings : optional
        In place of the estimate's own.
    """
    verdict = estimate.verdict if verdict is None else verdict
    told = estimate.warnings if warnings is None else warnings
    marks = " The triangle is the truth." if truth is not None else ""
    content = join(
        (
            verdict_box(verdict, told, say),
            *number_bars(estimate, truth),
            element("p", MEANING + marks, class_="note"),
        )
    )
    return Section("answer", "Answer", content)


def verdict_box(verdict: Verdict, warnings: Iterable[str], say: Say) -> Markup:
    """The verdict in plain words, its reasons, and what else there is to know."""
    style, words, advice = WORDS[verdict.level]
    others = [line for line in warnings if line not in verdict.reasons]
    parts: list[Markup] = [
        element("strong", f"{words}."),
        element("p", advice),
        items(say(reason) for reason in verdict.reasons),
    ]
    if others:
        parts += [element("p", "Also:"), items(say(line) for line in others)]
    return element("div", *parts, class_=f"verdict {style}")


def number_bars(
    estimate: Estimate, truth: InertialParameters | None
) -> Iterable[Markup]:
    """The ten numbers of an estimate, a group of bars for each unit."""
    values, (low, high) = ten(estimate.parameters), ends_of(estimate)
    known = None if truth is None else ten(truth)
    for group in GROUPS:
        rows = [
            Row(
                NAMES[i],
                float(values[i]),
                float(low[i]),
                float(high[i]),
                None if known is None else float(known[i]),
            )
            for i in group.rows
        ]
        yield element("h3", group.title)
        yield bars(rows, group.unit, from_zero=True)

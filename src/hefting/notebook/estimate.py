"""An estimate in a notebook: verdict, numbers, warnings, picture."""

from typing import Any

from hefting.core.estimate import Estimate
from hefting.identification.answer import Answer
from hefting.notebook.html import beside, block, list_html, table_html, verdict_html
from hefting.notebook.numbers import HEAD, rows_of
from hefting.notebook.picture import picture_html
from hefting.scene import scene_of

MOST_WARNINGS = 12
"""Warnings that are shown."""
ALT = "COM with its 95 % region and ellipsoid of equal inertia, in three views"


def answer_html(answer: Answer) -> str:
    """What holds an estimate, as a block."""
    return block(card(answer.estimate, type(answer).__name__))


def estimate_html(estimate: Estimate) -> str:
    """An estimate as a block."""
    return block(card(estimate, "Estimate"))


def card(estimate: Estimate, title: str) -> str:
    """Verdict, numbers and warnings beside a picture."""
    extent = "" if estimate.duration is None else f", {estimate.duration:.4g} s"
    source = _source(estimate.provenance.get("log"))
    after = f"{title} by {estimate.method}: {estimate.samples} samples{extent}{source}"
    numbers = table_html(HEAD, [row.cells for row in rows_of(estimate)])
    picture = picture_html(scene_of({"estimate": estimate}), ALT)
    return (
        verdict_html(estimate.verdict, after)
        + warnings_html(estimate)
        + beside(numbers, picture)
    )


def warnings_html(estimate: Estimate) -> str:
    """Warnings that are no reason of the verdict."""
    reasons = estimate.verdict.reasons
    more = [f"warning: {text}" for text in estimate.warnings if text not in reasons]
    if len(more) > MOST_WARNINGS:
        left = len(more) - MOST_WARNINGS
        more[MOST_WARNINGS:] = [f"and {left} more in .warnings"]
    return list_html(more)


def _source(log: Any) -> str:
    """Where it came from, of an estimate that tells it."""
    return f" of {log}" if isinstance(log, str) and log else ""

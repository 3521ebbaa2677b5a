"""Notebook: what estimates, comparisons and shapes show of themselves in Jupyter.

    html_of(hefting.identify("demo/log.csv"))

Each kind of value is a function of `KINDS`. What is shown is one block without scripts;
all its styles are its own, and all text from outside is escaped.
"""

from collections.abc import Callable
from typing import Any

from hefting.core.estimate import Estimate
from hefting.identification import Comparison
from hefting.identification.agreement import Agreement
from hefting.identification.identify import Answer
from hefting.notebook.comparison import agreement_html, comparison_html
from hefting.notebook.estimate import answer_html, estimate_html
from hefting.notebook.shape import shape_html
from hefting.shapes import Shape

KINDS: dict[type, Callable[[Any], str]] = {
    Comparison: comparison_html,
    Answer: answer_html,
    Estimate: estimate_html,
    Agreement: agreement_html,
    Shape: shape_html,
}
"""What makes the HTML of each kind of value; the first that fits is taken."""


def html_of(value: object) -> str | None:
    """A value as HTML for a notebook; None for a kind that has none."""
    for kind, make in KINDS.items():
        if isinstance(value, kind):
            return make(value)
    return None

"""Whether several estimates agree, in a notebook."""

import numpy as np

from hefting.core.spatial import Array
from hefting.identification.agreement import QUANTITIES, Agreement
from hefting.notebook.html import block, paragraph, table_html
from hefting.scene import plus_minus


def agreement_html(agreement: Agreement) -> str:
    """In words, then each quantity of each estimate."""
    head = ("quantity", *agreement.values, "standard deviations apart")
    apart = np.max(list(agreement.apart.values()), axis=0)
    rows = []
    for i, (name, unit) in enumerate(QUANTITIES):
        scale, unit = (1e3, "mm") if unit == "m" else (1.0, unit)
        cells = [
            _number(scale * values[i], scale * agreement.intervals[of][:, i])
            for of, values in agreement.values.items()
        ]
        rows.append((f"{name} [{unit}]", *cells, f"{apart[i]:.1f}"))
    return block(paragraph(_verdict(agreement)), table_html(head, rows))


def _verdict(agreement: Agreement) -> str:
    if not agreement.tested:
        return "nothing to compare by: no two estimates determine the same quantity"
    worst = agreement.largest
    words = "agree" if agreement.agree else "contradict one another"
    return (
        f"the estimates {words}: {worst.first} and {worst.second} differ most, in "
        f"{worst.name}, by {worst.deviations:.1f} standard deviations (limit "
        f"{agreement.limit:.1f})"
    )


def _number(value: float, ends: Array) -> str:
    """A value with half the width of its interval."""
    half = float(np.max(np.abs(ends - value)))
    if half > 0.0 and half < 1e-4:  # moments of a small object, in full
        return f"{value:.3g} ± {half:.1g}".replace("-", "−")
    return plus_minus(value, half)

"""Several estimates in a notebook: of several methods on one recording, or of the same
object."""

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.identification import Comparison
from hefting.identification.agreement import QUANTITIES, Agreement
from hefting.notebook.estimate import card, rows_of
from hefting.notebook.html import block, list_html, paragraph, table_html
from hefting.scene import plus_minus


def comparison_html(comparison: Comparison) -> str:
    """The recommended estimate, then what each method found."""
    names = list(comparison.results)
    first = next(iter(comparison.results.values()))
    units = [f"{row.name} [{row.unit}]" for row in rows_of(first, products=False)]
    head = ("method", "verdict", *units, "residual [N]", "[N m]", "time [ms]")
    rows = [
        _row(name, estimate, comparison.seconds.get(name))
        for name, estimate in comparison.results.items()
    ]
    skipped = [f"not used: {why}" for why in comparison.skipped.values()]
    return block(
        card(comparison.estimate, "Comparison"),
        paragraph(f"recommended: {comparison.recommended}, as {comparison.reason}"),
        table_html(head, rows, bold=names.index(comparison.recommended)),
        list_html(skipped),
    )


def _row(name: str, estimate: Estimate, seconds: float | None) -> list[str]:
    numbers = [row.value for row in rows_of(estimate, products=False)]
    residual = ["", ""]
    if estimate.residual is not None:
        residual = [f"{value:.3g}" for value in estimate.residual]
    took = "" if seconds is None else f"{1e3 * seconds:.3g}"
    return [name, str(estimate.verdict), *numbers, *residual, took]


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

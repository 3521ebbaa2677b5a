"""Several methods on one recording, in a notebook."""

from hefting.core.estimate import Estimate
from hefting.identification import Comparison
from hefting.notebook.estimate import card
from hefting.notebook.html import block, list_html, paragraph, table_html
from hefting.notebook.numbers import rows_of


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

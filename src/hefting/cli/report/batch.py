"""The result of a batch, as readable lines."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hefting.cli.report.estimate import Line

if TYPE_CHECKING:
    from hefting.batches.batch import Batch
    from hefting.batches.summary import Reason, Summary

MOST_REASONS = 8
"""Largest number of printed reasons; the page has all."""
MOST_OUTLIERS = 5


def batch_report(
    found: "Batch", render: Callable[[str], str], page: str | None
) -> Iterable[Line]:
    """Counts, failures and doubts, recordings worth a look, and the table's path."""
    from hefting.batches.batch import headline
    from hefting.batches.recordings import LEFT_OUT_TEXTS

    summary = found.summary
    yield Line(headline(found), "bold")
    for level, count in summary.verdicts.items():
        if count:
            yield Line(f"  {count:>7,}  {level}", whole=True)
    if summary.failed:
        yield Line(f"  {summary.failed:>7,}  failed", "yellow", whole=True)
    yield from _failures("failed", summary.reasons, render)
    yield from _failures("left out of objects", summary.left_out, render)
    yield from _doubts(summary)
    yield from _outliers(summary, render, page)
    yield Line("")
    yield from _sizes(summary)
    yield Line(_times(summary))
    if found.unused:
        columns = ", ".join(found.unused)
        yield Line(f"columns of the manifest that are no options: {columns}")
    if found.texts:
        yield Line(LEFT_OUT_TEXTS.format(found.texts), "yellow")
    yield Line(f"wrote {found.folder}")
    if page is not None:
        yield Line(f"wrote {page}")


def _failures(
    title: str, reasons: "Sequence[Reason]", render: Callable[[str], str]
) -> Iterable[Line]:
    if reasons:
        yield Line("")
        yield Line(f"{title}:", "yellow")
    for reason in reasons[:MOST_REASONS]:
        example = Path(reason.examples[0]).name
        more = f", as {example}" if reason.count > 1 else f": {example}"
        yield Line(
            f"  {reason.count:>5,}  {render(reason.text)} ({reason.error}{more})"
        )
    left = len(reasons) - MOST_REASONS
    if left > 0:
        yield Line(f"         and {left} other reasons; the table has all")


def _doubts(summary: "Summary") -> Iterable[Line]:
    if summary.doubts:
        texts = [f"{code} {count:,}" for code, count in summary.doubts.items()]
        yield Line("")
        yield Line(f"in doubt by: {', '.join(texts)}", "yellow")


def _outliers(
    summary: "Summary", render: Callable[[str], str], page: str | None
) -> Iterable[Line]:
    if summary.outliers:
        yield Line("")
        yield Line("worth a look:")
    for outlier in summary.outliers[:MOST_OUTLIERS]:
        yield Line(f"  {outlier.name}: {render(outlier.why)}")
    left = len(summary.outliers) - MOST_OUTLIERS
    if left > 0:
        yield Line(f"  and {left} more; {page or '--report'} shows them")


def _times(summary: "Summary") -> str:
    total = sum(summary.seconds.values())
    shares = [
        f"{stage} {100.0 * spent / total:.0f} %"
        for stage, spent in summary.seconds.items()
        if total > 0.0
    ]
    return f"time: {', '.join(shares)}" if shares else "no time was spent"


def _sizes(summary: "Summary") -> Iterable[Line]:
    """The median residual, if any."""
    known = summary.residuals[np.isfinite(summary.residuals).all(axis=1)]
    if len(known):
        force, torque = np.median(known, axis=0)
        yield Line(f"median residual: {force:.2g} N, {torque:.2g} N m")

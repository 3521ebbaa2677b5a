"""Batch: results of many recordings, those worth a look, links and commands."""

import json
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from hefting.batches.batch import Batch, duration, headline
from hefting.batches.summary import Outlier, Reason, Summary
from hefting.core.errors import file_word
from hefting.page import Context, command
from hefting.page.answer import WORDS, Say
from hefting.page.figure import histogram
from hefting.page.html import (
    Count,
    Markup,
    Section,
    counts,
    element,
    join,
    note,
    page_of,
    table,
    wrapped,
)

MOST_REASONS = 100
"""Most reasons that the page shows; the table has all."""
LONGEST = 500
"""Most characters of a text that are shown."""
MOST_RECORDINGS = 20
"""Most recordings that a command names."""


def batch_page(found: Batch, context: Context | None = None) -> str:
    """A page of a batch: verdicts, residuals and masses, reasons of failures, and the
    recordings worth a look, each with a link and the command that shows it.

    The HTML is complete, and its size is bounded for any number of rows. Raises
    `InputError` if the table cannot be read, `MissingDependencyError` without plotly.
    """
    c = context or Context()
    summary = found.summary
    sections = (
        _verdicts(summary),
        _outliers(found, c.say),
        _failures("failures", "Why they failed", summary.reasons, c.say),
        _left_out(summary, c.say),
        _doubts(summary, c.say),
        _sizes(summary),
        _times(summary),
        command(c.command),
    )
    lines = (headline(found), f"Table: {found.folder}")
    title = "No recordings"
    if summary.total:
        title = f"{summary.total - summary.failed:,} of {summary.total:,} identified"
    return page_of(title, lines, sections)


def _verdicts(summary: Summary) -> Section:
    total = max(summary.total, 1)

    def row(name: str, count: int, colour: str) -> Count:
        return Count(name, count, f"{count:,} ({100.0 * count / total:.3g} %)", colour)

    rows = [
        row(WORDS[level][1], count, WORDS[level][0])
        for level, count in summary.verdicts.items()
    ]
    rows.append(row("Failed", summary.failed, "muted"))
    return Section("verdicts", "Verdicts", counts(rows))


def _outliers(found: Batch, say: Say) -> Section | None:
    outliers = found.summary.outliers
    if not outliers:
        return None
    names = {outlier.name for outlier in outliers}
    table_rows = found.rows(names, "recordings", "options")
    rows = []
    for number, outlier in enumerate(outliers):
        row = table_rows.get(outlier.name)
        words = None if row is None else look_at(row)
        rows.append(_outlier_cells(outlier, f"look-{number}", words, say))
    return Section("outliers", "Worth a look", table(("recording", "why"), rows))


def _outlier_cells(
    outlier: Outlier, name: str, words: str | None, say: Say
) -> tuple[Markup, Markup]:
    parts = [_cut(say(outlier.why))]
    if words is not None:
        parts += [
            element("pre", words, class_="wrap", id=name),
            element("button", "Copy", data_copy=name, type="button"),
        ]
    return link(outlier.name, outlier.recording), join(*parts)


def _failures(
    name: str, title: str, reasons: Sequence[Reason], say: Say
) -> Section | None:
    if not reasons:
        return None
    rows = [
        (f"{r.count:,}", _cut(say(r.text)), r.error, Markup(" ".join(_examples(r))))
        for r in reasons[:MOST_REASONS]
    ]
    content = table(("count", "reason", "class", "as"), rows)
    if left := reasons[MOST_REASONS:]:
        count = sum(reason.count for reason in left)
        text = f"{count:,} more for {len(left):,} other reasons: see the table."
        content = join(content, note(text))
    return Section(name, title, content)


def _left_out(summary: Summary, say: Say) -> Section | None:
    section = _failures("left-out", "Left out of objects", summary.left_out, say)
    if section is None:
        return None
    count = sum(reason.count for reason in summary.left_out)
    text = f"{count:,} recordings; what the others say of their objects was used."
    return replace(section, content=join(element("p", text), section.content))


def _examples(reason: Reason) -> Iterable[Markup]:
    for name, path in zip(reason.examples, reason.paths, strict=True):
        yield link(name if path is None else Path(name).name, path)


def _doubts(summary: Summary, say: Say) -> Section | None:
    if not summary.doubts:
        return None
    rows = [
        (f"{count:,}", code, _cut(say(summary.doubt_texts[code])))
        for code, count in summary.doubts.items()
    ]
    says = "A row may have several; the text is that of one of the rows."
    shown = table(("rows", "code", "as"), rows)
    content = join(shown, note(says))
    return Section("doubts", "What puts rows in doubt", content)


def _sizes(summary: Summary) -> Section | None:
    force, torque = summary.residuals.T
    drawn = (
        histogram("force", "Force residual", "N", force),
        histogram("torque", "Torque residual", "N m", torque),
        histogram("mass", "Mass", "kg", summary.masses),
    )
    figures = tuple(figure for figure in drawn if figure is not None)
    if not figures:
        return None
    lines = [note(f"{f.about}.") for f in figures]
    missing = int(np.sum(~np.isfinite(force)))
    if missing:
        text = f"{missing:,} rows have no residual."
        lines.append(note(text))
    return Section("sizes", "Residuals and masses", join(*lines), figures)


def _times(summary: Summary) -> Section:
    total = sum(summary.seconds.values()) or 1.0
    rows = [
        Count(
            stage, spent, f"{duration(spent)} ({100.0 * spent / total:.0f} %)", "shape"
        )
        for stage, spent in summary.seconds.items()
    ]
    says = "Time in the workers, of all rows that are in the table."
    content = join(counts(rows), note(says))
    return Section("times", "Time by stage", content)


def _cut(text: str) -> Markup:
    return wrapped(text if len(text) <= LONGEST else f"{text[: LONGEST - 2]} …")


def link(name: str, recording: str | None) -> Markup:
    """A name with a link to the recording; without one if there is no file."""
    try:
        target = None if recording is None else Path(recording).absolute().as_uri()
    except ValueError:
        target = None
    if target is None:
        return wrapped(name)
    return element("a", name, href=target, class_="text")


def look_at(row: Mapping[str, Any]) -> str | None:
    """The command that repeats the identification of a row (`recording`, `name`,
    `object`, `recordings` and `options`) and writes a report; None for no recordings, and
    for more than `MOST_RECORDINGS`."""
    alone = row["recording"]
    recordings = [alone] if alone is not None else row["recordings"] or ()
    if not 0 < len(recordings) <= MOST_RECORDINGS:
        return None
    name = row["name"] or (Path(alone).stem if alone is not None else row["object"])
    words = ["hefting", "identify", *map(file_word, recordings)]
    words += _options(json.loads(row["options"] or "{}"))
    stem = re.sub(r"[^\w.-]+", "-", name).strip("-.")[:80] or "report"
    return shlex.join([*words, "--report", f"{stem}.html"])


def _options(options: Mapping[str, Any]) -> Sequence[str]:
    words: list[str] = []
    for name, value in options.items():
        option = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(option)
        elif value is not False:
            words.append(f"{option}={value}")
    return words

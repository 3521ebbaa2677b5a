"""Headline of a batch: how many recordings in what time, in one line."""

from hefting.batches.batch import Batch

LONG = 120.0
"""[s] From here on times are told in minutes."""


def headline(found: Batch) -> str:
    """Recordings, time, rate, and what was there already."""
    progress = found.progress
    new = progress.done - progress.kept
    text = f"{progress.done:,} recordings in {duration(found.seconds)}"
    if new:
        text += f", {new / max(found.seconds, 1e-9):.3g} a second"
    if progress.kept:
        text += f"; {progress.kept:,} of them unchanged"
    if found.summary.total != progress.done:
        text += f"; {found.summary.total:,} rows in all"
    return text


def duration(seconds: float) -> str:
    """A time as people say it."""
    return f"{seconds:.1f} s" if seconds < LONG else f"{seconds / 60.0:.1f} min"

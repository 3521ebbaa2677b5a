"""Batch: identify many recordings, keep one row of each, and say in a line what was
done."""

import time
from collections.abc import Callable, Collection, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.batches.columns import Row
from hefting.batches.content import Kept
from hefting.batches.group import rows_of_objects
from hefting.batches.one import lost, row_of, start_row
from hefting.batches.recordings import Recordings, Sources, recordings_of
from hefting.batches.results import Results, rows_named
from hefting.batches.summary import COLUMNS, Summary, summary_of
from hefting.core.immutable import immutable
from hefting.jobs import Jobs, Lost

if TYPE_CHECKING:
    import pyarrow as pa

LONG = 120.0
"""[s] From here on times are told in minutes."""


@dataclass
class Progress:
    """How far a batch is."""

    total: int
    done: int = 0
    kept: int = 0
    """of these, rows of an earlier run that stay"""
    failed: int = 0
    """of these, new rows with an error"""


@immutable
class Batch:
    """What a batch made."""

    folder: Path
    """Of the table; ``pandas.read_parquet(folder)`` reads it."""
    progress: Progress
    seconds: float
    unused: tuple[str, ...] = field(default=())
    """Columns of the manifest that say nothing that is understood."""
    texts: int = 0
    """Files in folders that end in .txt, .dat or .log and were left out, as others end
    so, too."""

    def table(self, *names: str) -> "pa.Table":
        """The rows as an Arrow table, of the columns named or of all."""
        from pyarrow import parquet

        return parquet.read_table(self.folder, columns=list(names) or None)

    def rows(self, names: Collection[str], *columns: str) -> dict[str, Row]:
        """Some columns of some rows, by what identifies them."""
        wanted = list(dict.fromkeys(("recording", "name", "object", *columns)))
        return {
            name: row
            for table in Results(self.folder).tables(wanted)
            for name, row in rows_named(table, names)
        }

    @cached_property
    def summary(self) -> Summary:
        """What all rows in the folder come to."""
        return summary_of(Results(self.folder).tables(list(COLUMNS)))

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values."""
        return self.summary.to_dict() | {
            "folder": str(self.folder),
            "recordings": self.progress.total,
            "kept": self.progress.kept,
            "elapsed": self.seconds,
            "unused_columns": list(self.unused),
            "texts_left_out": self.texts,
        }


def batch(
    recordings: Sources,
    output: str | Path,
    *,
    jobs: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    group_by: str | None = None,
    progress: Callable[[Progress], None] = lambda progress: None,
    **options: Any,
) -> Batch:
    """Identify the object in each of many recordings, or each object in several.

    Parameters
    ----------
    recordings : path, or list of paths or of dictionaries
        A manifest (CSV, Parquet or TOML; see `hefting.batches.manifest`), a folder, a
        pattern such as ``"day*/*.csv"``, logs, or rows of a manifest.
    output : path
        Folder for the table, of results and nothing else; see
        `hefting.batches.results`. The columns are in `hefting.batches.columns`.
    jobs : int, optional
        Local processes, by default one a core.
    scheduler : str, optional
        Address of a Dask scheduler to use instead (extra ``batch``); its workers find
        the recordings under the same paths.
    resume : bool
        Whether to go on in a folder with results: rows whose recording, options and
        version of this library are the same stay.
    group_by : str, optional
        Column of the manifest that tells the object, or ``"folder"``: the recordings of
        each object are identified together, each with a bias and a clock of its own.
    progress : callable, optional
        Called with a `Progress` after each recording.
    **options
        For all recordings of which the manifest does not say otherwise: options of
        ``hefting identify`` by name, as they are typed.

    Returns
    -------
    Batch

    Raises
    ------
    InputError
        For recordings, options or a folder that cannot be used; not for a recording
        that cannot be identified, whose row says why.
    HeftingError
        Where workers or the scheduler are lost. What was done is in the folder.

    Examples
    --------
    >>> found = hefting.batch("demo/log.csv", "results")
    >>> found.summary.verdicts
    {'good': 1, 'usable with care': 0, 'do not use': 0}
    >>> mass = found.table("recording", "mass")["mass"][0].as_py()
    >>> abs(mass - 0.67) < 0.01
    True
    """
    began = time.monotonic()
    entries = recordings_of(recordings, options, group_by)
    entries.check(with_files=scheduler is None)  # whose workers have the files
    count = Progress(len(entries))
    with (
        Results.opened(Path(output), resume) as results,
        Jobs(jobs, scheduler) as workers,
    ):
        made = (
            rows_of_objects(entries, results.kept, workers)
            if group_by
            else _rows(entries, results.kept, workers)
        )
        for recorded, row in made:
            count.done += recorded
            if row is None:
                count.kept += recorded
            else:
                count.failed += row["error"] is not None
                results.add(row)
            progress(count)
        results.gather(entries.identities())
    unused, seconds = tuple(entries.unused), time.monotonic() - began
    return Batch(Path(output), count, seconds, unused, entries.texts)


def _rows(
    entries: Recordings, kept: Kept, workers: Jobs
) -> Iterator[tuple[int, Row | None]]:
    """One, and the row of each recording; None where that is unchanged."""
    tasks = ((entry, kept.get(entry.identity)) for entry in entries)
    with closing(workers.run(row_of, tasks)) as results:
        for number, row in results:
            if isinstance(row, Lost):
                row = start_row(entries[number]) | lost(row)
            yield 1, row


def headline(found: Batch) -> str:
    """Recordings, time, rate, and what was there already."""
    progress = found.progress
    new = progress.done - progress.kept
    several = "" if progress.done == 1 else "s"
    text = f"{progress.done:,} recording{several} in {duration(found.seconds)}"
    if new:
        text += f", {new / max(found.seconds, 1e-9):.3g} a second"
    if progress.kept:
        text += f"; {progress.kept:,} of them unchanged"
    if found.summary.total != progress.done:
        rows = "row" if found.summary.total == 1 else "rows"
        text += f"; {found.summary.total:,} {rows} in all"
    return text


def duration(seconds: float) -> str:
    """A time as people say it."""
    return f"{seconds:.1f} s" if seconds < LONG else f"{seconds / 60.0:.1f} min"

"""Batch: identify many recordings, keep one row of each, and sum up the run."""

import time
from collections.abc import Callable, Collection, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.batches.columns import Kept, Row
from hefting.batches.group import rows_of_objects
from hefting.batches.one import lost, row_of, start_row
from hefting.batches.recordings import Recordings, Sources, recordings_of
from hefting.batches.results import Results, rows_named
from hefting.batches.summary import COLUMNS, Summary, summary_of
from hefting.core.spatial import immutable
from hefting.jobs import Jobs, Lost

if TYPE_CHECKING:
    import pyarrow as pa

LONG = 120.0
"""[s] Longer times are printed in minutes."""


@dataclass
class Progress:
    """Numbers of recordings of a batch."""

    total: int
    done: int = 0
    kept: int = 0
    """of `done`, those whose row of an earlier run is kept"""
    failed: int = 0
    """number of new rows with an error"""
    anew: int = 0
    """number of new rows in place of others"""


@immutable
class Batch:
    """Result of a batch."""

    folder: Path
    """Folder of the table, which ``pandas.read_parquet(folder)`` reads."""
    progress: Progress
    seconds: float
    unused: tuple[str, ...] = field(default=())
    """Columns of the manifest that are no options."""
    texts: int = 0
    """Number of files in folders that were left out because they end in .txt, .dat or
    .log and need not be logs."""

    def table(self, *names: str) -> "pa.Table":
        """The rows as an Arrow table, of the columns named or of all."""
        from pyarrow import parquet

        return parquet.read_table(self.folder, columns=list(names) or None)

    def rows(self, names: Collection[str], *columns: str) -> dict[str, Row]:
        """Some columns of the rows with these identities, by identity."""
        wanted = list(dict.fromkeys(("recording", "name", "object", *columns)))
        return {
            name: row
            for table in Results(self.folder).tables(wanted)
            for name, row in rows_named(table, names)
        }

    @cached_property
    def summary(self) -> Summary:
        """Summary of all rows in the folder."""
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
        Folder for the table, which holds only results; see
        `hefting.batches.results`. The columns are in `hefting.batches.columns`.
    jobs : int, optional
        Number of local processes, by default one per core.
    scheduler : str, optional
        Address of a Dask scheduler to use instead (extra ``batch``); its workers must
        find the recordings under the same paths.
    resume : bool
        Whether to continue in a folder with results: rows are kept whose recording,
        options and version of this library are unchanged.
    group_by : str, optional
        Column of the manifest that names the object, or ``"folder"``: the recordings of
        each object are identified together, each with its own bias and clock.
    progress : callable, optional
        Called with a `Progress` after each recording.
    **options
        Options of ``hefting identify`` by name, as they are typed, for all recordings
        for which the manifest has none.

    Returns
    -------
    Batch

    Raises
    ------
    InputError
        For recordings, options or a folder that cannot be used; not for a recording
        that cannot be identified: its row holds the error.
    HeftingError
        Where workers or the scheduler are lost. Finished rows are in the folder.

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
    entries.check(with_files=scheduler is None)  # a cluster's workers have the files
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
                name = row["name"] or row["recording"] or row["object"]
                count.anew += results.kept.get(name) is not None
                results.add(row)
            progress(count)
        results.gather(entries.identities())
    unused, seconds = tuple(entries.unused), time.monotonic() - began
    return Batch(Path(output), count, seconds, unused, entries.texts)


def _rows(
    entries: Recordings, kept: Kept, workers: Jobs
) -> Iterator[tuple[int, Row | None]]:
    """For each recording 1 and its row, or None where that is unchanged."""
    tasks = ((entry, kept.get(entry.identity)) for entry in entries)
    with closing(workers.run(row_of, tasks)) as results:
        for number, row in results:
            if isinstance(row, Lost):
                row = start_row(entries[number]) | lost(row)
            yield 1, row


def headline(found: Batch) -> str:
    """A line: number of recordings, time, rate, unchanged rows and rows in all."""
    progress = found.progress
    new = progress.done - progress.kept
    several = "" if progress.done == 1 else "s"
    text = f"{progress.done:,} recording{several} in {duration(found.seconds)}"
    if new:
        text += f", {new / max(found.seconds, 1e-9):.3g} a second"
    if progress.kept:
        text += f"; {progress.kept:,} of them unchanged"
    if progress.anew:
        text += f"; {progress.anew:,} replaced, of other options, files or version"
    if found.summary.total != progress.done:
        rows = "row" if found.summary.total == 1 else "rows"
        text += f"; {found.summary.total:,} {rows} in all"
    return text


def duration(seconds: float) -> str:
    """A time [s] as text in seconds or minutes."""
    return f"{seconds:.1f} s" if seconds < LONG else f"{seconds / 60.0:.1f} min"

"""Reproduction: the paper's experiments on simulated data, with tables and figures
compared with the published ones.

Each experiment is one file; this one runs them and makes the page of their reports. A
result is kept in a file named after its job and the version of this library's source, so
that a stopped run continues, and jobs run again only if the source has changed. Results
depend neither on the process nor on the order.
"""

import hashlib
import html
import json
import platform
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import hefting
from hefting.core.errors import HeftingError, InputError, nearest
from hefting.core.files import write_atomically
from hefting.jobs import Jobs, Lost, check_workers, source_version
from hefting.plots.style import save_figure
from hefting.reproduction.experiment import (
    Experiment,
    Job,
    Report,
    Result,
    Results,
    Table,
    shown,
)

__all__ = ["EXPERIMENTS", "Experiment", "Report", "Table", "reproduce"]

FILES = (
    "objects",
    "gravity",
    "condition",
    "density",
    "c1",
    "noise",
    "observations",
    "stop_and_go",
    "robot",
    "prediction",
)
"""Modules of the experiments, in the order of the page; each defines `EXPERIMENT`."""


EXPERIMENTS: dict[str, Experiment] = {
    each.name: each
    for each in (
        import_module(f"hefting.reproduction.{file}").EXPERIMENT for file in FILES
    )
}
"""All experiments by name, in the order of the page."""


def reproduce(
    names: Sequence[str] = (),
    folder: Path = Path("reproduction"),
    quick: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    show: bool = False,
) -> Path:
    """Run experiments by name, all by default, and write their tables, figures and
    page; returns the page's path.

    Parameters
    ----------
    folder : output folder; results of an earlier run with the same source are used.
    quick : few seeds and short lists.
    workers, scheduler : number of local processes, by default one per core; or the
        address of a Dask scheduler.
    show : whether to show progress on standard error.

    Raises `InputError` for an unknown name, a folder that cannot be written, or a
    scheduler that does not answer.
    """
    for name in names:
        if name not in EXPERIMENTS:
            fix = f"use {', '.join(EXPERIMENTS)}"
            raise InputError(
                f"there is no experiment '{name}'{nearest(name, EXPERIMENTS)}", fix=fix
            )
    experiments = [e for name, e in EXPERIMENTS.items() if not names or name in names]
    start = time.perf_counter()
    with progress_bars(show) as bars:
        results = run_experiments(experiments, folder, quick, workers, scheduler, bars)
        reports = [(each, each.report(results[each.name])) for each in experiments]
    return write_page(reports, folder, time.perf_counter() - start, quick)


Progress = Callable[[str, int, int], None]
"""Function of an experiment's name and the numbers of its finished and of all jobs."""


@contextmanager
def progress_bars(shown: bool) -> Iterator[Progress]:
    """A progress bar for each experiment, if `shown` and standard error is a terminal."""
    from rich import progress
    from rich.console import Console

    with progress.Progress(
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TimeRemainingColumn(),
        console=Console(stderr=True),
        disable=not (shown and sys.stderr.isatty()),
    ) as bars:
        tasks: dict[str, progress.TaskID] = {}

        def update(name: str, done: int, total: int) -> None:
            if name not in tasks:
                tasks[name] = bars.add_task(name, total=total)
            bars.update(tasks[name], completed=done)

        yield update


def run_experiments(
    experiments: Iterable[Experiment],
    folder: Path,
    quick: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress = lambda name, done, total: None,
) -> dict[str, Results]:
    """All results by experiment, each with its job, in the order of the experiment's
    `jobs`.

    Parameters
    ----------
    folder : results are kept below its ``results``, and not computed again.
    workers : number of local processes, by default one per core.
    scheduler : address of a Dask scheduler to use instead (extra ``batch``).

    Raises `InputError` if `folder` cannot be written or the scheduler cannot be reached;
    `HeftingError` if it is lost, if its workers have another source, or, after all other
    jobs, if a job ended its worker; and any error of a job.
    """
    check_workers(workers)  # before anything is written
    make_folder(folder / "results")
    wanted = {experiment.name: experiment.jobs(quick) for experiment in experiments}
    done = {
        name: [_kept(folder, name, job) for job in jobs]
        for name, jobs in wanted.items()
    }
    missing = [
        (name, i)
        for name, results in done.items()
        for i, result in enumerate(results)
        if result is None
    ]
    for name, results in done.items():
        progress(name, sum(r is not None for r in results), len(results))
    tasks = [(name, wanted[name][i]) for name, i in missing]
    lost: list[str] = []
    with Jobs(workers, scheduler) as jobs:
        # a window of one, as jobs are long and of different lengths
        for k, result in jobs.run(do, tasks, window=1):
            name, i = missing[k]
            if isinstance(result, Lost):
                lost.append(f"a job of {name} is lost: {result.reason}")
                continue
            done[name][i] = result
            _keep(folder, name, wanted[name][i], result)
            results = done[name]
            progress(name, sum(r is not None for r in results), len(results))
    if lost:
        raise HeftingError(lost[0])
    return {name: list(zip(wanted[name], done[name], strict=True)) for name in wanted}  # type: ignore[arg-type]


def make_folder(path: Path) -> None:
    """Make a folder and its parents; `InputError` if that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made ({error.strerror})", where=path) from error


def do(task: tuple[str, Job]) -> Result:
    """Result of one job (experiment's name, job), in any process."""
    name, job = task
    # as read from a file
    return json.loads(json.dumps(EXPERIMENTS[name].run(job)))


def _path(folder: Path, name: str, job: Job) -> Path:
    key = hashlib.sha256(
        json.dumps([source_version(), job], sort_keys=True).encode()
    ).hexdigest()[:24]
    return folder / "results" / name / f"{key}.json"


def _keep(folder: Path, name: str, job: Job, result: Result) -> None:
    path = _path(folder, name, job)
    make_folder(path.parent)
    write_atomically(path, json.dumps({"job": job, "result": result}))


def _kept(folder: Path, name: str, job: Job) -> Result | None:
    path = _path(folder, name, job)
    if not path.exists():
        return None
    try:
        return json.loads(path.read_text())["result"]
    except (OSError, ValueError, KeyError, TypeError):
        return None  # damaged: done again


PACKAGES = ("numpy", "scipy", "mujoco", "matplotlib", "distributed")
"""Packages whose versions the page states."""
PIXELS_AN_INCH = 130
LONG = 16
"""Number of rows above which the page collapses a table, except an experiment's first."""

STYLE = """
body { max-width: 66rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; color: #222; }
h2 { margin-top: 3rem; border-top: 1px solid #ccc; padding-top: 1rem; }
.source, .made { color: #555; font-size: 0.9rem; }
table { border-collapse: collapse; font-size: 0.9rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; font-weight: 600; padding: 0.5rem 0; }
th, td { padding: 0.2rem 0.6rem; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
thead th { border-bottom: 2px solid #888; white-space: normal; }
.wide { overflow-x: auto; }
figure { display: inline-block; margin: 1rem 1rem 1rem 0; max-width: 100%; vertical-align: top; }
figure img { max-width: 100%; }
nav li { margin: 0.1rem 0; }
"""


def write_page(
    reports: list[tuple[Experiment, Report]], folder: Path, seconds: float, quick: bool
) -> Path:
    """Write every table (CSV, JSON, Markdown) and figure (SVG, PNG) below `folder`, and
    the page; returns its path."""
    for experiment, report in reports:
        place = folder / experiment.name
        make_folder(place)
        for table in report.tables:
            for suffix, text in (
                (".csv", table.csv()),
                (".json", table.json()),
                (".md", table.markdown()),
            ):
                write_atomically(place / f"{table.name}{suffix}", text)
        for name, figure in report.figures.items():
            save_figure(figure, place / name)
    path = folder / "index.html"
    write_atomically(path, page(reports, seconds, quick))
    return path


def page(reports: list[tuple[Experiment, Report]], seconds: float, quick: bool) -> str:
    """The HTML page, with the pictures of `write_page`."""
    made = ", ".join(f"{name} {number}" for name, number in versions().items())
    kind = "A reduced run: few seeds, short lists. " if quick else ""
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">',
        f"<title>Hefting: the paper's experiments</title><style>{STYLE}</style></head><body>",
        "<h1>The paper's experiments, run again</h1>",
        "<p>Nadeau, Giamou and Kelly, <em>Fast Object Inertial Parameter Identification for Collaborative Robots</em>, "
        "ICRA 2022, on simulated data. Published figures stand beside those of this run.</p>",
        f'<p class="made">{kind}{seconds:.0f} s, without what an earlier run had done; {html.escape(made)}; Python '
        f"{platform.python_version()}; source {source_version()[:12]}. Jobs, seeds and results: folder results.</p>",
        "<nav><ul>",
        *(
            f'<li><a href="#{e.name}">{html.escape(e.title)}</a></li>'
            for e, _ in reports
        ),
        "</ul></nav>",
    ]
    for experiment, report in reports:
        parts += [f'<h2 id="{experiment.name}">{html.escape(experiment.title)}</h2>']
        parts += [
            f'<p class="source">{html.escape(line)}</p>'
            for line in (experiment.source, _jobs(experiment, quick))
        ]
        parts += [f"<p>{html.escape(note)}</p>" for note in report.notes]
        parts += [
            f'<figure><a href="{experiment.name}/{name}.svg"><img src="{experiment.name}/{name}.png" '
            f'width="{PIXELS_AN_INCH * figure.get_figwidth():.0f}" '
            f'alt="{html.escape(experiment.title)}: {html.escape(name)}"></a></figure>'
            for name, figure in report.figures.items()
        ]
        parts += [
            _html_table(experiment, table, table is report.tables[0])
            for table in report.tables
        ]
    return "\n".join([*parts, "</body></html>\n"])


def versions() -> dict[str, str]:
    """Versions of Hefting and of `PACKAGES` that are installed."""
    installed = {"hefting": hefting.__version__}
    for name in PACKAGES:
        try:
            installed[name] = version(name)
        except PackageNotFoundError:
            continue
    return installed


def _jobs(experiment: Experiment, quick: bool) -> str:
    """Number of jobs, and the values of their parameters and seeds, as text."""
    jobs = experiment.jobs(quick)
    values: dict[str, list[str]] = {}
    for job in jobs:
        for name, value in job.items():
            listed = value if isinstance(value, list) else [value]
            values.setdefault(name, []).extend(
                f"{v:g}" if isinstance(v, float) else str(v) for v in listed
            )
    parameters = "; ".join(
        f"{name} {', '.join(dict.fromkeys(each))}" for name, each in values.items()
    )
    return f"{len(jobs)} jobs: {parameters.replace('_', ' ')}"


def _html_table(experiment: Experiment, table: Table, first: bool) -> str:
    head = "".join(f"<th>{html.escape(name)}</th>" for name in table.columns)
    body = "".join(
        f"<tr>{''.join(f'<td>{html.escape(shown(cell))}</td>' for cell in row)}</tr>"
        for row in table.rows
    )
    files = ", ".join(
        f'<a href="{experiment.name}/{table.name}.{suffix}">{suffix.upper()}</a>'
        for suffix in ("csv", "json", "md")
    )
    shown_table = (
        f'<div class="wide"><table><caption>{html.escape(table.title)}</caption><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )
    if len(table.rows) > LONG:
        summary = (
            f"<summary>{html.escape(table.title)}: {len(table.rows)} rows</summary>"
        )
        shown_table = f"<details{' open' * first}>{summary}{shown_table}</details>"
    return f'{shown_table}<p class="source">{files}</p>'

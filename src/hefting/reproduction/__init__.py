"""Reproduction: the paper's experiments on simulated data, with tables and figures
compared with the published ones.

Each experiment is one file; this one runs them and makes the page of their reports. A
result is kept in a file named after its job and the version of this library's source, so
that a stopped run continues, and jobs run again only if the source has changed. Results
depend neither on the process nor on the order.
"""

import hashlib
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
from hefting.page.html import Markup, document, element, escape, join, note, table
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
            path = _path(folder, name, wanted[name][i])
            make_folder(path.parent)
            kept = {"job": wanted[name][i], "result": result}
            write_atomically(path, json.dumps(kept))
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


def _kept(folder: Path, name: str, job: Job) -> Result | None:
    path = _path(folder, name, job)
    if not path.exists():
        return None
    try:
        return json.loads(path.read_text("utf-8"))["result"]
    except (OSError, ValueError, KeyError, TypeError):
        return None  # damaged: done again


PACKAGES = ("numpy", "scipy", "mujoco", "matplotlib", "distributed")
"""Packages whose versions the page states."""
PAPER = (
    "Nadeau, Giamou and Kelly, Fast Object Inertial Parameter Identification for Collaborative Robots, ICRA 2022, on "
    "simulated data. Published figures stand beside those of this run."
)
PIXELS_AN_INCH = 130
LONG = 16
"""Number of rows above which the page collapses a table, except an experiment's first."""


def write_page(
    reports: list[tuple[Experiment, Report]], folder: Path, seconds: float, quick: bool
) -> Path:
    """Write every table (CSV, JSON, Markdown) and figure (SVG, PNG) below `folder`, and
    the page; returns its path."""
    for experiment, report in reports:
        place = folder / experiment.name
        make_folder(place)
        for each in report.tables:
            for suffix, text in (
                (".csv", each.csv()),
                (".json", each.json()),
                (".md", each.markdown()),
            ):
                write_atomically(place / f"{each.name}{suffix}", text)
        for name, figure in report.figures.items():
            save_figure(figure, place / name)
    path = folder / "index.html"
    write_atomically(path, page(reports, seconds, quick))
    return path


def page(reports: list[tuple[Experiment, Report]], seconds: float, quick: bool) -> str:
    """The HTML page, with the pictures of `write_page`."""
    made = ", ".join(f"{name} {number}" for name, number in versions().items())
    kind = "A reduced run: few seeds, short lists. " if quick else ""
    about = (
        f"{kind}{seconds:.0f} s, without what an earlier run had done; {made}; Python {platform.python_version()}; "
        f"source {source_version()[:12]}. Jobs, seeds and results: folder results."
    )
    header = element(
        "header",
        element("h1", "The paper's experiments, run again"),
        element("p", PAPER),
        note(about),
        element("nav", *(element("a", e.title, href=f"#{e.name}") for e, _ in reports)),
    )
    sections = (_section(*each, quick) for each in reports)
    main = element("main", *sections, class_="numbers")
    return document("Hefting: the paper's experiments", join(header, main))


def _section(experiment: Experiment, report: Report, quick: bool) -> Markup:
    name, title = experiment.name, experiment.title
    pictures = [
        element(
            "figure",
            element(
                "a",
                Markup(
                    f'<img src="{name}/{each}.png" alt="{escape(title)}: {escape(each)}" '
                    f'width="{PIXELS_AN_INCH * figure.get_figwidth():.0f}">'
                ),
                href=f"{name}/{each}.svg",
            ),
        )
        for each, figure in report.figures.items()
    ]
    return join(
        element("h2", title, id=name),
        note(experiment.source),
        note(_jobs(experiment, quick)),
        *(element("p", text) for text in report.notes),
        *pictures,
        *(_shown_table(experiment, t, t is report.tables[0]) for t in report.tables),
    )


def _shown_table(experiment: Experiment, data: Table, first: bool) -> Markup:
    """A table with links to its files, folded if it is long and not the `first`."""
    rows = table(data.columns, (list(map(shown, row)) for row in data.rows))
    whole = join(element("h3", data.title), rows)
    if len(data.rows) > LONG:
        summary = element("summary", f"{data.title}: {len(data.rows)} rows")
        opened = {"open": ""} if first else {}
        whole = element("details", summary, rows, **opened)
    links = [
        element("a", suffix.upper(), href=f"{experiment.name}/{data.name}.{suffix}")
        for suffix in ("csv", "json", "md")
    ]
    return join(whole, element("nav", *links))


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

"""What an experiment is: independent jobs, the function that does one, the report made
of all results, and the page of all reports."""

import csv
import html
import io
import json
import platform
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import hefting
from hefting.core.files import write_atomically
from hefting.jobs import source_version
from hefting.plots.style import save_figure
from hefting.reproduction.runner import make_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Job = dict[str, Any]
"""JSON-ready, its seed among them: the result depends on nothing else."""
Result = dict[str, Any]
"""JSON-ready."""
Cell = str | float | int | None
PLAIN = 1e6
"""Numbers below it are shown without an exponent."""


@dataclass(frozen=True)
class Table:
    """Rows under named columns; units are in the names."""

    name: str
    """Of its files."""
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def csv(self) -> str:
        """With one header row."""
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows((self.columns, *self.rows))
        return text.getvalue()

    def json(self) -> str:
        """An object a row."""
        return (
            json.dumps(
                [dict(zip(self.columns, row, strict=True)) for row in self.rows],
                indent=1,
            )
            + "\n"
        )

    def markdown(self) -> str:
        """Numbers with three digits."""
        lines = [
            " | ".join(map(str, self.columns)),
            " | ".join("---" for _ in self.columns),
        ]
        lines += [" | ".join(map(shown, row)) for row in self.rows]
        return "".join(f"| {line} |\n" for line in lines)


def shown(cell: Cell) -> str:
    """Three significant digits, nothing for what is not known."""
    if cell is None:
        return ""
    if not isinstance(cell, float):
        return str(cell)
    text = f"{cell:.3g}"
    return f"{float(text):.0f}" if "e+" in text and abs(cell) < PLAIN else text


@dataclass(frozen=True)
class Report:
    """What an experiment shows."""

    tables: tuple[Table, ...]
    figures: dict[str, "Figure"] = field(default_factory=dict)
    """By the name of its files."""
    notes: tuple[str, ...] = ()
    """Where a figure differs from the published one, and why; one sentence each."""


@dataclass(frozen=True)
class Experiment:
    """One table or figure of the paper."""

    name: str
    """As on the command line."""
    title: str
    source: str
    """Table, figure or section of Nadeau et al. 2022."""
    jobs: Callable[[bool], list[Job]]
    """All jobs, or few of them for a quick run."""
    run: Callable[[Job], Result]
    report: Callable[[list[tuple[Job, Result]]], Report]
    """Of jobs and their results, in the order of `jobs`."""


PACKAGES = ("numpy", "scipy", "mujoco", "matplotlib", "distributed")
PIXELS_AN_INCH = 130
LONG = 16
"""Rows of a table above which the page folds it away, unless it is an experiment's
first."""

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
    """Every table (CSV, JSON, Markdown) and figure (SVG, PNG) below `folder`, and the
    page; returns its path."""
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
    """Its pictures are the files that `write_page` writes."""
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
    """Of what the figures depend on, as far as it is installed."""
    found = {"hefting": hefting.__version__}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _jobs(experiment: Experiment, quick: bool) -> str:
    """How many there are, and the values of their parameters."""
    jobs = experiment.jobs(quick)
    found: dict[str, list[str]] = {}
    for job in jobs:
        for name, value in job.items():
            listed = value if isinstance(value, list) else [value]
            found.setdefault(name, []).extend(
                f"{v:g}" if isinstance(v, float) else str(v) for v in listed
            )
    parameters = "; ".join(
        f"{name} {', '.join(dict.fromkeys(values))}" for name, values in found.items()
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

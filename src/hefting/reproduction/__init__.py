"""Reproduction: the paper's experiments on simulated data, with tables and figures
beside the published ones."""

import time
from collections.abc import Sequence
from pathlib import Path

from hefting.core.errors import InputError, nearest
from hefting.reproduction.experiment import Experiment, Report, Table
from hefting.reproduction.runner import EXPERIMENTS, Bars, run_experiments, write_page

__all__ = ["EXPERIMENTS", "Experiment", "Report", "Table", "reproduce"]


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
    folder : where everything goes; what an earlier run with the same source left there
        is used again.
    quick : few seeds and short lists.
    workers, scheduler : local processes, one a core by default; or the address of a
        Dask scheduler.
    show : a progress bar on standard error.

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
    with Bars(show) as bars:
        results = run_experiments(experiments, folder, quick, workers, scheduler, bars)
        reports = [
            (experiment, experiment.report(results[experiment.name]))
            for experiment in experiments
        ]
    return write_page(reports, folder, time.perf_counter() - start, quick)

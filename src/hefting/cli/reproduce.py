"""hefting reproduce: run the paper's experiments on simulated data, beside the
published figures."""

import argparse
from importlib.util import find_spec
from pathlib import Path
from textwrap import fill

from hefting.cli.options import add_workers
from hefting.cli.parser import WIDTH, wrote
from hefting.core.errors import MissingDependencyError

EXAMPLES = (
    "hefting reproduce --list",
    "hefting reproduce --quick",
    "hefting reproduce noise gravity --output results --jobs 2",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting reproduce``."""
    parser.add_argument(
        "names",
        metavar="NAME",
        nargs="*",
        help="experiments; default all (--list names them)",
    )
    parser.add_argument(
        "--list", action="store_true", help="list the experiments and stop"
    )
    parser.add_argument(
        "--quick", action="store_true", help="few seeds and short lists: under a minute"
    )
    add_workers(parser)
    parser.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        default="reproduction",
        help="tables, figures, page; a stopped run continues there; default %(default)s",
    )


def run(arguments: argparse.Namespace) -> None:
    """Run unfinished experiments, write tables, figures and page, and print where."""
    from hefting.reproduction import EXPERIMENTS, reproduce

    a = arguments
    if a.list:
        for experiment in EXPERIMENTS.values():
            text = f"{experiment.name:<14}{experiment.title} ({experiment.source})"
            print(fill(text, WIDTH - 1, subsequent_indent=14 * " "))
        return
    if find_spec("matplotlib") is None:
        raise MissingDependencyError("matplotlib", "plot")  # before what takes long
    path = reproduce(a.names, Path(a.output), a.quick, a.jobs, a.scheduler, show=True)
    wrote(path)

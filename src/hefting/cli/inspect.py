"""hefting inspect: what a log holds and what can be found from it."""

import typer

from hefting.cli.options import DEFAULT_GRAVITY, Gravity, Json, Log, numbers, progress


def inspect(log: Log, gravity: Gravity = DEFAULT_GRAVITY, json: Json = False) -> None:
    """Say what a log holds, its conventions, and what is identifiable from it."""
    from hefting.inspection import inspect as run
    from hefting.logs import read_log

    with progress("reading ..."):
        found = run(read_log(log), numbers(gravity, 3, "--gravity"))
    if json:
        import json as encoder

        typer.echo(encoder.dumps(found.to_dict()))
        return
    from hefting.report import inspection_report, print_report

    print_report(inspection_report(found))

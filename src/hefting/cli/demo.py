"""hefting demo: simulate, identify, write pictures."""

from typing import Annotated

import typer

from hefting.cli.options import progress


def demo(
    output: Annotated[str, typer.Option(metavar="FOLDER", help="Where to write log, mesh, estimate and pictures.")] = "hefting-demo",
) -> None:
    """Simulate a robot arm wielding a hammer, identify it, and write pictures."""
    from hefting.demo import run
    from hefting.report import estimate_report, print_report

    with progress("simulating a robot arm that wields a hammer, and identifying it ..."):
        shown = run(output)
    print_report(estimate_report(shown.estimate, shown.truth, shown.errors))
    typer.echo("wrote:")
    for path in shown.files:
        typer.echo(f"  {path}")

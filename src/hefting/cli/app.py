"""All commands by name. Each command's file imports the library only when it runs."""

import typer

from hefting.cli.demo import demo
from hefting.cli.export import export
from hefting.cli.identify import identify
from hefting.cli.inspect import inspect

app = typer.Typer(
    name="hefting",
    help="Tells what a robot is holding: mass, centre of mass and inertia tensor.",
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


@app.callback(invoke_without_command=True)
def common(version: bool = typer.Option(False, "--version", help="Print the version.")) -> None:
    """Tells what a robot is holding: mass, centre of mass and inertia tensor."""
    if version:
        from hefting import __version__

        typer.echo(__version__)
        raise typer.Exit


for command in (demo, inspect, identify, export):
    app.command()(command)

"""All commands by name. Each command's file imports the library only when it runs."""

import argparse

from hefting import __version__
from hefting.cli import calibrate, convert, demo, export, identify, inspect, methods, predict, reproduce, simulate
from hefting.errors import InputError

COMMANDS = {
    "demo": demo,
    "inspect": inspect,
    "identify": identify,
    "methods": methods,
    "calibrate": calibrate,
    "convert": convert,
    "export": export,
    "predict": predict,
    "reproduce": reproduce,
    "simulate": simulate,
}
"""A command's module has a docstring for its help, `add_arguments(parser)` and `run(arguments)`."""


class Parser(argparse.ArgumentParser):
    """Reports bad usage as an `InputError`, in one line."""

    def error(self, message: str):
        """Raise `message` as an `InputError`."""
        raise InputError(message, fix=f"see {self.prog} --help")


def build_parser() -> argparse.ArgumentParser:
    """The parser of ``hefting`` and all its commands."""
    about = "Tells what a robot is holding: mass, centre of mass and inertia tensor."
    parser = Parser(prog="hefting", description=about, allow_abbrev=False)
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, module in COMMANDS.items():
        text = (module.__doc__ or "").partition(": ")[2]
        command = commands.add_parser(name, help=text, description=text, allow_abbrev=False)
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser

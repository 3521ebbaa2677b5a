"""hefting map: guess a column map from the names and numbers of a log, to be
checked."""

import argparse

from hefting.cli.parser import say
from hefting.cli.standard_input import input_file

EXAMPLES = ("hefting map log.csv > map.toml", "hefting inspect log.csv --map map.toml")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting map``."""
    parser.add_argument(
        "log", metavar="LOG", help="a table with a header; - reads standard input"
    )


def run(arguments: argparse.Namespace) -> None:
    """Print the map, and on standard error the quantities that were not found."""
    from hefting.logs.map_guess import guess_map

    with input_file(arguments.log) as path:
        found = guess_map(path)
    print(found.text, end="")
    for line in found.missing:
        key = line.partition(" ")[0]
        say(f"warning: no column seems to hold the {key}; add it to the map by hand")

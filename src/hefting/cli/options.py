"""Options that several commands share, and how their texts are read."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from hefting.errors import InputError
from hefting.quantity import Kind, quantity

POSE = "x,y,z,qx,qy,qz,qw [m], or a JSON file with a 4 x 4 matrix"


def add_json(parser: argparse._ActionsContainer) -> None:
    """Output for machines."""
    parser.add_argument("--json", action="store_true", help="print one JSON object and nothing else")


def add_sensor_pose(parser: argparse._ActionsContainer) -> None:
    """Where the sensor is on the robot's flange."""
    parser.add_argument("--sensor-pose-in-flange", metavar="POSE", help=f"controllers want flange axes: {POSE}")


def numbers(text: str, count: int, option: str) -> list[float]:
    """`count` finite numbers separated by commas; `InputError` names the option otherwise."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) < float("inf") for value in values):
        raise InputError(f"'{text}' is not {count} finite numbers separated by commas", where=option)
    return values


def quantities(text: str, kinds: Sequence[Kind], option: str, example: str) -> tuple[float, ...]:
    """Numbers with units separated by commas, in SI units; `InputError` names the option otherwise."""
    parts = text.split(",")
    if len(parts) != len(kinds):
        raise InputError(f"'{text}' is not {len(kinds)} of them", where=option, fix=f"as in {example}")
    try:
        return tuple(quantity(part, kind) for part, kind in zip(parts, kinds, strict=True))
    except InputError as error:
        raise InputError(error.what, option, error.fix) from None


@contextmanager
def progress(what: str) -> Iterator[None]:
    """A line on standard error while something long goes on, in a terminal."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(what):
        yield

"""Options that several commands share, and how their texts are read."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

from hefting.errors import InputError

Log = Annotated[str, typer.Argument(metavar="LOG", help="Recording: a canonical .csv or .parquet file.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
Gravity = Annotated[str, typer.Option(metavar="X,Y,Z", help="Gravity in world axes [m/s²].")]
SensorPose = Annotated[
    str | None, typer.Option(metavar="POSE", help="Sensor in flange: x,y,z,qx,qy,qz,qw [m], or a JSON file.")
]
DEFAULT_GRAVITY = "0,0,-9.80665"


def numbers(text: str, count: int, option: str) -> list[float]:
    """`count` finite numbers separated by commas; `InputError` names the option otherwise."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) < float("inf") for value in values):
        raise InputError(f"'{text}' is not {count} numbers separated by commas", where=option)
    return values


@contextmanager
def progress(what: str) -> Iterator[None]:
    """A line on standard error while something long goes on, in a terminal."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(what):
        yield

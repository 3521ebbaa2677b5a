"""Layout of a text file of numbers, which a column map may state."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError

SEPARATORS = {
    ",": ",",
    ";": ";",
    "|": "|",
    "tab": "\t",
    "\t": "\t",
    "space": " ",
    " ": " ",
}
"""Separators a column map may name, and the character each stands for."""

LAYOUT_KEYS = ("separator", "header", "skip", "decimal", "nan")
"""Keys of a column map that are about the file as a whole."""


@dataclass(frozen=True)
class Layout:
    """Layout of a CSV file; None stands for what the file itself shows."""

    separator: str | None = None
    """between cells: a comma, semicolon, bar, tab, or runs of spaces"""
    header: int | None = None
    """line of the column names, from 1; 0: there are none; None: the first line with as
    many cells as the numbers below it"""
    skip: int | None = None
    """lines to skip after the header, such as units; None: those without numbers"""
    decimal: str | None = None
    """decimal mark"""


def layout_of(content: Mapping[str, Any], path: str | Path) -> Layout:
    """The layout in a column map's content at `path`; `InputError` names the key."""
    separator, header = content.get("separator"), content.get("header")
    skip, decimal = content.get("skip"), content.get("decimal")
    if separator is not None and not (
        isinstance(separator, str) and separator in SEPARATORS
    ):
        what = f"{brief(separator)} is no separator"
        raise InputError(what, f"{path}, key separator", "use , ; | tab or space")
    if decimal not in (".", ",", None):
        raise InputError(
            f"{brief(decimal)} is no decimal mark", f"{path}, key decimal", "use . or ,"
        )
    if separator is not None and separator == decimal:
        raise InputError(
            "cells and decimals are both separated by a comma", f"{path}, key decimal"
        )
    if header is not None and header is not False and not whole(header, 1):
        fix = "give the line of the column names, counted from 1, or false"
        raise InputError(
            f"{brief(header)} is no line number", f"{path}, key header", fix
        )
    if skip is not None and not whole(skip, 0):
        what = f"{brief(skip)} is no number of lines"
        raise InputError(what, f"{path}, key skip", "give 0 or more")
    line = None if header is None else int(header)
    return Layout(SEPARATORS[separator] if separator else None, line, skip, decimal)


def nan_is_blank(content: Mapping[str, Any], path: str | Path) -> bool:
    """Whether a map has NaN mean "not measured"; `InputError` for another word."""
    if content.get("nan", "blank") != "blank":
        fix = 'give nan = "blank" if NaN means "not measured", else leave it out'
        raise InputError(
            f"{brief(content['nan'])} is not known", f"{path}, key nan", fix
        )
    return "nan" in content


def whole(value: Any, least: int) -> bool:
    """Whether a value of TOML is an integer of at least `least`."""
    return (
        isinstance(value, int)
        and not isinstance(value, bool)
        and least <= value < 10**9
    )


def brief(value: Any) -> str:
    """A value of TOML, shortened for a message."""
    if not isinstance(value, int) or abs(value) < 10**18:
        return repr(value)[:40]
    return "a huge number"

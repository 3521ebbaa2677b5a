"""Reading TOML with care."""

import tomllib
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError
from hefting.core.files import check_readable

MAX_MAP = 64_000
"""Largest map that is read [bytes]; one that names a thousand columns has half."""

MAX_DOTS = 1000
"""Most dots in a line of a map. The time that `tomllib` takes for a dotted key grows
with the square of its dots: 2,000 take a quarter of a second, 50,000 two minutes and
more than 8 GB."""


def load_toml(
    path: str | Path, what: str = "column map", largest: int = MAX_MAP
) -> dict[str, Any]:
    """The content of a TOML file, which is to be a column map, say. `InputError` when
    it cannot be read, is larger than `largest` [bytes], has lines of too many dots, or
    is not TOML."""
    check_readable(path)
    try:
        with open(path, "rb") as stream:
            data = stream.read(largest + 1)
    except (OSError, ValueError) as error:
        raise InputError(
            f"cannot be read ({getattr(error, 'strerror', None) or error})", where=path
        ) from error
    if len(data) > largest:
        raise InputError(
            f"is larger than {largest:,} bytes, too large for a {what}", where=path
        )
    if any(line.count(b".") > MAX_DOTS for line in data.split(b"\n")):
        raise InputError(f"has a line of more than {MAX_DOTS:,} dots", where=path)
    try:
        return tomllib.loads(data.decode())
    except (ValueError, RecursionError) as error:
        fix = 'write lines such as wrench = { columns = ["fx", "fy", "fz", "tx", "ty", "tz"] }'
        raise InputError(f"is not TOML ({str(error)[:120]})", path, fix) from error

"""Reading JSON with care, and writing files whole or not at all."""

import json
import os
import tempfile
from pathlib import Path
from typing import Any

from hefting.errors import InputError

MAX_JSON = 100_000_000
"""Largest JSON file that is read [bytes]: an estimate with a million point masses fits."""


def read_json(path: str | Path) -> Any:
    """The content of a JSON file. `InputError` when it cannot be read, is too large or too deep, or is not JSON."""
    try:
        if Path(path).stat().st_size > MAX_JSON:
            raise InputError(f"is larger than {MAX_JSON:,} bytes", where=path)
        return json.loads(Path(path).read_text())
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", where=path) from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON ({str(error)[:80]})", where=path) from error


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write `content` to a temporary neighbour of `path`, then rename it: a reader never sees half a file.

    Raises `InputError` when the folder does not exist or cannot be written.
    """
    target = Path(path).resolve()  # a link stays a link
    data = content.encode() if isinstance(content, str) else content
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(data)
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(temporary, 0o666 & ~umask)
            os.replace(temporary, target)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", where=path) from error

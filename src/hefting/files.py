"""Writing files whole or not at all."""

import os
import tempfile
from pathlib import Path

from hefting.errors import InputError


def write_atomically(path: str | Path, content: str | bytes) -> None:
    """Write `content` to a temporary neighbour of `path`, then rename it: a reader never sees half a file.

    Raises `InputError` when the folder does not exist or cannot be written.
    """
    target = Path(path)
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

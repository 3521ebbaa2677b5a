"""Which source this process computes with: results of another are not comparable."""

import hashlib
from functools import cache
from pathlib import Path

import hefting


@cache
def source_version() -> str:
    """A hash of this library's source [64 hexadecimal digits]."""
    root = Path(hefting.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()

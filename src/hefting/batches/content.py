"""Content: what a result follows from, as a hash: the bytes of all files, the options
and the source of this library. And the hashes of the rows that an earlier run left."""

import json
import os
from collections.abc import Iterable, Mapping
from functools import lru_cache
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hefting.core.files import check_readable, check_size
from hefting.jobs import source_version
from hefting.request.request import Value, files_of

if TYPE_CHECKING:
    import pyarrow as pa

BLOCK = 2**20
"""Bytes that are read at a time."""

Signature = tuple[tuple[str, int, int, int], ...]
"""Of each file: its name, number, size [bytes] and time of change [ns]."""

Digests = NDArray[np.uint64]

HASH = 16
"""Bytes of a row's hash."""


def signature(path: str | Path) -> Signature:
    """What tells that a file, or any in a folder, has changed; empty where there is
    none."""
    return tuple(
        (name, about.st_ino, about.st_size, about.st_mtime_ns)
        for name, about in _files(Path(path))
    )


def hash_of(log: str, options: Mapping[str, Value]) -> str:
    """Hash of what the identification of a log by options follows from.

    Files count by their content, wherever they are. Raises `OSError` for a log that
    cannot be read, `InputError` for a pipe or a device, which may have no end.
    """
    files = files_of(options)
    words = {name: value for name, value in options.items() if name not in files}
    contents = {
        name: _digest_once(file, signature(file)) for name, file in files.items()
    }
    told = json.dumps([source_version(), words, contents], sort_keys=True)
    return blake2b((told + _digest(log)).encode(), digest_size=16).hexdigest()


@lru_cache(maxsize=64)
def _digest_once(path: str, _as_it_is: Signature) -> str:
    """Digest of a file that many recordings share; missing files are told by what reads
    them. `InputError` for one that is too large for what reads it."""
    if os.path.isfile(path):
        check_size(path)
    return _digest(path)


def _digest(path: str) -> str:
    """Digest of the bytes of a file, or of all in a folder with their names."""
    check_readable(path)
    found, buffer = blake2b(digest_size=16), bytearray(BLOCK)
    view = memoryview(buffer)
    for name, _ in _files(Path(path)):
        if os.path.isdir(path):
            found.update(f"{name}\0".encode(errors="surrogateescape"))
        with open(os.path.join(path, name) if name else path, "rb", 0) as stream:
            while count := stream.readinto(buffer):
                found.update(view[:count])
    return found.hexdigest()


def _files(path: Path) -> list[tuple[str, os.stat_result]]:
    """The file at a path, or those in the folder there, by name."""
    try:
        if not path.is_dir():
            return [("", path.stat())]
        inside = sorted(each for each in path.rglob("*") if each.is_file())
        return [(each.relative_to(path).as_posix(), each.stat()) for each in inside]
    except (OSError, ValueError):
        return []


class Kept:
    """Hash of each row by what identifies it, in 24 bytes a row, from `rows` of
    (identities, hashes), arrays of texts, of which later ones count."""

    def __init__(self, rows: "Iterable[tuple[pa.ChunkedArray, pa.ChunkedArray]]" = ()):
        names: list[Digests] = [np.empty(0, np.uint64)]
        hashes = [np.empty(0, f"S{HASH}")]
        for identities, known in rows:
            names.append(digests_of(identities))
            texts = (bytes.fromhex(text or "") for text in known.to_pylist())
            hashes.append(np.array(list(texts), f"S{HASH}"))
        name, hash_ = np.concatenate(names), np.concatenate(hashes)
        order = np.argsort(name, kind="stable")
        self._names, self._hashes = name[order], hash_[order]

    def __len__(self) -> int:
        return len(self._names)

    def get(self, identity: str) -> str | None:
        """Hash of the row that was written last; None where there is none, or it is to
        be made again."""
        digest = np.uint64(digest_of(identity))
        at = int(np.searchsorted(self._names, digest, side="right")) - 1
        if at < 0 or self._names[at] != digest:
            return None
        found = bytes(self._hashes[at])
        return found.ljust(HASH, b"\0").hex() if found else None


def digests_of(identities: "pa.ChunkedArray") -> Digests:
    """(n,) of texts."""
    return np.fromiter(map(digest_of, identities.to_pylist()), np.uint64)


def digest_of(identity: str) -> int:
    """A number of 64 bits for a text."""
    return int.from_bytes(blake2b(identity.encode(), digest_size=8).digest(), "big")

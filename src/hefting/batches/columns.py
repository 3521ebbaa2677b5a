"""Columns of the table of results, with their Arrow types; and hashes of what a row
depends on: the bytes of all files, the options and the source of this library.

The keys are those of ``hefting identify --json``; matrices are lists of fixed size, row
by row. A value that does not apply is null, as most of a recording that failed.
"""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hefting.core.estimate import Estimate
from hefting.core.files import check_readable, check_size
from hefting.jobs import source_version
from hefting.request.request import Value, files_of

if TYPE_CHECKING:
    import pyarrow as pa

SCHEMA = "hefting.batch/1"
"""Name and version of the schema, in the metadata of the files."""
STAGES: tuple[str, ...] = ("reading", "motion", "conditioning", "solving")
"""Stages of an identification, whose times [s] are kept."""

Row = dict[str, Any]


@cache
def columns() -> "pa.Schema":
    """The columns in order, with their types."""
    import pyarrow as pa

    real, text, truth = pa.float64(), pa.string(), pa.bool_()
    texts = pa.list_(text)

    def array(size: int, of: "pa.DataType" = real) -> "pa.DataType":
        return pa.list_(of, size)

    def struct(**fields: "pa.DataType") -> "pa.DataType":
        return pa.struct(list(fields.items()))

    ten = {"mass": real, "center_of_mass": array(3), "inertia_at_com": array(9)}
    margins = dict.fromkeys(
        ("mass", "inertia", "triangle", "pseudo_inertia", "hull"), real
    )
    message = struct(code=text, severity=text, text=text, argument=text)
    left_out = struct(recording=text, error=text, error_text=text)
    return pa.schema(
        {
            "recording": text,
            "name": text,
            "object": text,
            "recordings": texts,
            "left_out": pa.list_(left_out),
            "error": text,
            "error_text": text,
            "schema": text,
            "version": text,
            "method": text,
            "frame": text,
            "verdict": text,
            "reasons": texts,
            **ten,
            "inertia_at_origin": array(9),
            "vector": array(10),
            "covariance": array(100),
            "intervals": struct(
                mass=array(2),
                center_of_mass=array(6),
                inertia_at_com=array(18),
                inertia_at_origin=array(18),
            ),
            "std": struct(**ten),
            "undetermined": struct(
                mass=truth,
                center_of_mass=array(3, truth),
                inertia_at_com=array(9, truth),
                filled_from=text,
            ),
            "accuracy": struct(mass=real, center_of_mass=real, inertia=real),
            "sufficient": truth,
            "physically_consistent": truth,
            "consistency": struct(margins=struct(**margins), violated=text),
            "certificate": struct(
                objective=real,
                bound=real,
                iterations=pa.int64(),
                converged=truth,
                gap=real,
            ),
            "bias": pa.list_(real),
            "residual": array(2),
            "point_masses": pa.list_(real),
            "samples": pa.int64(),
            "duration": real,
            "warnings": texts,
            "messages": pa.list_(message),
            "provenance": text,
            "options": text,
            "hash": text,
            "seconds": struct(**dict.fromkeys(STAGES, real)),
        }.items(),
        metadata={"hefting": SCHEMA},
    )


def filled(row: Row, estimate: Estimate) -> Row:
    """A row with an estimate, by the keys of ``hefting identify --json``."""
    found = estimate.to_dict()
    found["provenance"] = json.dumps(found["provenance"])
    found["messages"] = [
        {key: message.get(key) for key in ("code", "severity", "text", "argument")}
        for message in found["messages"]
    ]
    return row | {key: flat(value) for key, value in found.items()}


def flat(value: Any) -> Any:
    """Nested lists of numbers as one list, also inside dictionaries."""
    if isinstance(value, Mapping):
        return {key: flat(own) for key, own in value.items()}
    if isinstance(value, list) and value and isinstance(value[0], list):
        return [number for row in value for number in flat(row)]
    return value


def table_of(rows: Sequence[Row]) -> "pa.Table":
    """Rows as a table; a key that a row does not have is null."""
    import pyarrow as pa

    return pa.Table.from_pylist(list(rows), schema=columns())


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
    """Metadata that change with the file at a path, or with any in the folder there;
    empty where there is none."""
    return tuple(
        (name, about.st_ino, about.st_size, about.st_mtime_ns)
        for name, about in _files(Path(path))
    )


def hash_of(log: str, options: Mapping[str, Value]) -> str:
    """Hash of what the identification of a log with options depends on.

    Of files it depends on the content, not on the path. Raises `OSError` for a log that
    cannot be read, `InputError` for a pipe or a device, which may have no end.
    """
    files = files_of(options)
    words = {name: value for name, value in options.items() if name not in files}
    contents = {
        name: _digest_once(file, signature(file)) for name, file in files.items()
    }
    settings = json.dumps([source_version(), words, contents], sort_keys=True)
    return blake2b((settings + _digest(log)).encode(), digest_size=16).hexdigest()


@lru_cache(maxsize=64)
def _digest_once(path: str, _as_it_is: Signature) -> str:
    """Digest of a file that many recordings share, cached by its signature.
    `InputError` for one that is too large; a missing one fails where it is read."""
    if os.path.isfile(path):
        check_size(path)
    return _digest(path)


def _digest(path: str) -> str:
    """Digest of the bytes of a file, or of all files in a folder and their names."""
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
    """Name, relative to the path, and metadata of the file there (with no name), or of
    the files in the folder there, sorted; empty where there is none."""
    try:
        if not path.is_dir():
            return [("", path.stat())]
        inside = sorted(each for each in path.rglob("*") if each.is_file())
        return [(each.relative_to(path).as_posix(), each.stat()) for each in inside]
    except (OSError, ValueError):
        return []


class Kept:
    """Hash of each row by its identity, in 24 bytes a row. `rows` gives pairs of arrays
    of texts (identities, hashes); later ones replace earlier ones."""

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
        """Hash of the row that was written last; None without a row, or where it has no
        hash, as after an error that may pass."""
        digest = np.uint64(digest_of(identity))
        at = int(np.searchsorted(self._names, digest, side="right")) - 1
        if at < 0 or self._names[at] != digest:
            return None
        found = bytes(self._hashes[at])
        return found.ljust(HASH, b"\0").hex() if found else None


def digests_of(identities: "pa.ChunkedArray") -> Digests:
    """(n,) 64-bit digests of texts."""
    return np.fromiter(map(digest_of, identities.to_pylist()), np.uint64)


def digest_of(identity: str) -> int:
    """The 64-bit digest of a text, as a number."""
    return int.from_bytes(blake2b(identity.encode(), digest_size=8).digest(), "big")

"""Kept: which rows of an earlier run are there, and what they follow from."""

from collections.abc import Iterable
from hashlib import blake2b
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyarrow as pa

Digests = NDArray[np.uint64]

HASH = 16
"""Bytes of a row's hash."""


class Kept:
    """Hash of each row by what identifies it, in 24 bytes a row.

    Parameters
    ----------
    rows : of (identities, hashes), arrays of texts; later ones count.
    """

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

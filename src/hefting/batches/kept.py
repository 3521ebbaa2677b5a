"""Kept: which rows of an earlier run are there, and what they follow from."""

from collections.abc import Iterable
from hashlib import blake2b
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyarrow as pa

HASH = 16
"""Bytes of a row's hash."""


class Kept:
    """Hash of each row by what identifies it, in 24 bytes a row.

    Parameters
    ----------
    rows : of (identities, hashes), arrays of texts; later ones count.
    """

    def __init__(self, rows: "Iterable[tuple[pa.ChunkedArray, pa.ChunkedArray]]" = ()):
        names, hashes = [np.empty(0, np.uint64)], [np.empty(0, f"S{HASH}")]
        for identities, known in rows:
            names.append(
                np.array([_digest(n) for n in identities.to_pylist()], np.uint64)
            )
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
        digest = np.uint64(_digest(identity))
        at = int(np.searchsorted(self._names, digest, side="right")) - 1
        if at < 0 or self._names[at] != digest:
            return None
        found = bytes(self._hashes[at])
        return found.ljust(HASH, b"\0").hex() if found else None


def _digest(identity: str) -> int:
    return int.from_bytes(blake2b(identity.encode(), digest_size=8).digest(), "big")

"""Bytes of a bag, read forward; lengths are checked against the file before use."""

import bz2
import os
from functools import cache
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError, needing, printable
from hefting.core.progress import report
from hefting.core.spatial import immutable
from hefting.logs.registry import READING

MAX_CHUNK = 256 * 1024**2
"""Largest record, and largest decompressed chunk, that is read [bytes]."""

MAX_RATIO = 200
"""Largest decompressed size (beyond one chunk) over file size; sensor data reach 20."""


LONGEST_TEXT = 200
"""Largest number of characters that are kept of a text in a bag."""


@immutable
class Topic:
    """One topic of a bag; the same object for all of its messages."""

    name: str
    type: str
    """as in ROS 2: package/msg/Name"""
    encoding: str
    """"cdr" (ROS 2), "ros1", or one that is not read"""
    definition: str = ""
    """the message definition in the bag, if any"""
    language: str = ""
    """of the definition: "ros1msg", "ros2msg" or "ros2idl" """

    def __post_init__(self):
        for name in ("name", "type", "encoding"):
            object.__setattr__(
                self, name, printable(getattr(self, name)[:LONGEST_TEXT])
            )

    def __str__(self) -> str:
        encoding = "" if self.encoding in ("cdr", "ros1") else f", {self.encoding}"
        return f"{self.name} ({self.type}{encoding})"


class Cut(Exception):
    """The rest of a file cannot be read; the text says why: "is truncated", "is damaged
    at byte 17"."""


class Source:
    """A file that is read forward. Reading beyond its end raises `Cut`, a too large
    record `InputError`."""

    def __init__(self, path: Path):
        self.path = path
        self.file = path.open("rb")
        self.size = os.fstat(self.file.fileno()).st_size
        self.position = 0

    def __enter__(self) -> "Source":
        return self

    def __exit__(self, *_) -> None:
        self.file.close()

    @property
    def left(self) -> int:
        """Bytes not yet read."""
        return self.size - self.position

    def take(self, count: int) -> bytes:
        """The next `count` bytes, or `Cut` when there are fewer."""
        if count > self.left:
            raise Cut("is truncated")
        return self.take_most(count)

    def take_most(self, count: int) -> bytes:
        """The next `count` bytes, or all that are left."""
        count = min(count, self.left)
        if count > MAX_CHUNK:
            what = f"a record at byte {self.position} has {count / 1e6:.0f} MB, more than 256 MiB"
            fix = "record the log again with smaller chunks"
            raise InputError(what, self.path, fix)
        self.position += count
        report(READING, self.position / self.size)
        return self.file.read(count)

    def skip(self, count: int) -> None:
        """Pass over `count` bytes, or `Cut` when there are fewer."""
        if count > self.left:
            raise Cut("is truncated")
        self.position += count
        self.file.seek(self.position)


class Budget:
    """Number of bytes to which a file may still decompress."""

    def __init__(self, path: Path, size: int):
        self.path, self.left = path, MAX_CHUNK + MAX_RATIO * size

    def inflate(self, kind: str, data: bytes, size: int = MAX_CHUNK) -> bytes:
        """`data` decompressed to at most `size` bytes; incomplete data as far as
        possible.

        `kind` is empty or "none", "bz2", "lz4" or "zstd". `InputError` for another kind
        and for a file that decompresses to too many bytes, `Cut` for damaged data.
        """
        if kind in ("", "none"):
            return data
        if size > MAX_CHUNK:
            what = f"a chunk has {size / 1e6:.0f} MB, more than 256 MiB"
            raise InputError(what, self.path, "record with smaller chunks")
        decompressor = _decompressor(kind, self.path)
        try:
            inflated = decompressor.decompress(data, max_length=size + 1)
        except (
            OSError,
            ValueError,
            RuntimeError,
            EOFError,
            zstandard().ZstdError,
        ) as error:
            raise Cut("is damaged (a compressed chunk)") from error
        if len(inflated) > size:
            raise Cut("is damaged (a chunk larger than it says)")
        self.spend(len(inflated))
        return inflated

    def spend(self, count: int) -> None:
        """Count `count` decompressed bytes; `InputError` when they are too many."""
        self.left -= count
        if self.left < 0:
            what = f"decompresses to more than {MAX_RATIO} times its size"
            raise InputError(what, self.path, "decompress it first")


@cache
def zstandard() -> Any:
    """The module that holds `ZstdDecompressor`, which comes with rosbags."""
    try:
        from compression import zstd  # type: ignore[import-not-found]  # Python 3.14
    except ImportError:
        with needing("rosbags", "ros"):
            from backports import zstd  # type: ignore[import-not-found]
    return zstd


def _decompressor(kind: str, path: Path) -> Any:
    if kind == "bz2":
        return bz2.BZ2Decompressor()
    if kind == "zstd":
        return zstandard().ZstdDecompressor()
    if kind == "lz4":
        with needing("rosbags", "ros"):
            from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]
        return LZ4FrameDecompressor()
    what = f"chunks are compressed as {kind[:20]!r}, which is not read"
    raise InputError(what, path, "use lz4, zstd, bz2 or none")

"""A folder that one process at a time may write to."""

import os
import socket
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

from hefting.core.errors import InputError

LOCK = ".lock"
"""File in the folder that is locked; the system unlocks it when its process ends,
however that comes."""


@contextmanager
def locked(folder: Path) -> Generator[None, None, None]:
    """No other process has the folder meanwhile.

    Raises `InputError` when one has it, or when the folder cannot be written.
    """
    path = folder / LOCK
    try:
        handle = _opened(path)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", folder) from error
    try:
        with suppress(OSError):  # a full disk
            os.ftruncate(handle, 0)
            os.pwrite(
                handle, f"process {os.getpid()} of {socket.gethostname()}".encode(), 0
            )
        yield
        with suppress(OSError):
            path.unlink()
    finally:
        os.close(handle)


def _opened(path: Path) -> int:
    """The file, locked by this process.

    Raises `InputError` when another one has it, and `OSError` when it cannot be
    written.
    """
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        if not _lock(handle):
            who = os.pread(handle, 200, 0).decode(errors="replace") or "another run"
            os.close(handle)
            what = f"{who} is writing there"
            fix = "wait for it, or choose another folder"
            raise InputError(what, path.parent, fix)
        if _is_there(path, handle):
            return handle
        os.close(handle)  # who had it has ended meanwhile, and took the file away


def _is_there(path: Path, handle: int) -> bool:
    """Whether the file that is open is still the one of this path."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(handle))
    except FileNotFoundError:
        return False


def _lock(handle: int) -> bool:
    """Whether the file is this process's now."""
    try:
        import fcntl
    except ImportError:  # Windows
        import msvcrt

        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        except OSError:
            return False
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True

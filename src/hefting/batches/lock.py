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
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", folder) from error
    try:
        if not _lock(handle):
            who = os.pread(handle, 200, 0).decode(errors="replace") or "another run"
            what = f"{who} is writing there"
            raise InputError(what, folder, "wait for it, or choose another folder")
        with suppress(OSError):  # a full disk
            os.ftruncate(handle, 0)
            os.pwrite(handle, f"process {os.getpid()} of {_host()}".encode(), 0)
        yield
        with suppress(OSError):
            path.unlink()
    finally:
        os.close(handle)


def _host() -> str:
    return socket.gethostname()


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

"""Attempt: what may be tried again, and what never: faults of the machine may pass,
those of the input do not."""

import errno
import time
from collections.abc import Callable
from typing import TypeVar

from hefting.core.errors import MissingDependencyError

T = TypeVar("T")

PAUSES = (0.5, 2.0)
"""[s] Waited before the second and the third attempt: a server that is busy answers."""

TRANSIENT = frozenset(
    getattr(errno, name)
    for name in (
        *("EIO", "EAGAIN", "ENOMEM", "EMFILE", "ENFILE", "EBUSY", "EINTR", "ESTALE"),
        *("ETIMEDOUT", "ENOTCONN", "EHOSTDOWN", "EHOSTUNREACH", "ENETUNREACH"),
        *("ECONNRESET", "ECONNABORTED", "EREMOTEIO"),
    )
    if hasattr(errno, name)
)
"""Errors of the system that may be gone the next time."""


class ChangedError(Exception):
    """A recording is not what it was when its reading began."""


def is_of_machine(error: BaseException) -> bool:
    """Whether an error, or what caused it, is no fault of the input."""
    causes: list[BaseException] = []
    cause: BaseException | None = error
    while cause is not None and cause not in causes:
        causes.append(cause)
        cause = cause.__cause__
    return any(
        isinstance(each, MemoryError | ChangedError | MissingDependencyError)
        or (isinstance(each, OSError) and each.errno in TRANSIENT)
        for each in causes
    )


def attempted(what: Callable[[], T], pause: Callable[[float], None] = time.sleep) -> T:
    """What a call returns; once more after each of `PAUSES` while it fails by a fault
    of the machine. Raises what the last attempt raised."""
    for seconds in PAUSES:
        try:
            return what()
        except Exception as error:
            if not is_of_machine(error) or isinstance(error, MissingDependencyError):
                raise
        pause(seconds)
    return what()

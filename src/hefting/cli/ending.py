"""Signals that request an end act as Ctrl-C."""

import os
import signal
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

ENDS = ("SIGTERM", "SIGHUP")
"""Those signals, where the system has them: of ``timeout``, and of a closed terminal."""


@contextmanager
def interrupted_by_signals() -> Iterator[None]:
    """Make signals that request an end raise `KeyboardInterrupt` within the block."""
    asked = [getattr(signal, name) for name in ENDS if hasattr(signal, name)]
    asked = [each for each in asked if signal.getsignal(each) != signal.SIG_IGN]
    before = [signal.signal(each, _end) for each in asked]
    try:
        yield
    finally:
        for each, handler in zip(asked, before, strict=True):
            if signal.getsignal(each) is _end:
                signal.signal(each, handler)


def _end(number: int, _: Any) -> None:
    """End as Ctrl-C does; a closed terminal gets no output."""
    if number != signal.SIGTERM:
        signal.signal(number, signal.SIG_IGN)  # it may come again, from the shell
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for output in (1, 2):
            if stat.S_ISCHR(os.fstat(output).st_mode):
                os.dup2(nowhere, output)
    raise KeyboardInterrupt

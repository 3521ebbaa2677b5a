"""Follower: work that follows what is wanted last, in a thread of its own."""

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Follower(Generic[T]):
    """Calls `work` with what was wanted last; what was wanted in between, while it
    worked, is passed over.

    Parameters
    ----------
    work : callable
        Called in the follower's thread.
    failed : callable
        Told of an exception that `work` raised; the follower goes on.
    """

    def __init__(self, work: Callable[[T], None], failed: Callable[[Exception], None]):
        self._work, self._failed = work, failed
        self._changed = threading.Condition()
        self._wanted: list[T] = []
        self._busy, self._closed = False, False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def want(self, what: T) -> None:
        """Work on this next."""
        with self._changed:
            self._wanted = [what]
            self._changed.notify_all()

    def settle(self, timeout: float = 60.0) -> bool:
        """Wait until nothing is wanted any more [s]; whether that came about."""
        with self._changed:
            return self._changed.wait_for(
                lambda: self._closed or not (self._wanted or self._busy), timeout
            )

    def close(self) -> None:
        """End the thread after what it works on now."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread is not threading.current_thread():
            self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._closed or self._wanted)
                if self._closed:
                    return
                what, self._busy = self._wanted.pop(), True
            try:
                self._work(what)
            except Exception as error:
                self._failed(error)

"""Pace: what comes often is decoded together, which costs half as much as one by one
(samples of RTDE at 500 Hz)."""

import time

GATHERING = 0.01
"""Between two looks at what came [s]. A live estimate is found right after a look
(`hefting.online.identifier.LONGEST_WAIT`), mostly in less time than to the next."""


class Pace:
    """Keeps looks apart."""

    def __init__(self):
        self._next = 0.0
        """[s] of the monotonic clock"""

    def wait(self) -> None:
        """Wait until `GATHERING` after the last time."""
        time.sleep(max(self._next - time.monotonic(), 0.0))
        self._next = time.monotonic() + GATHERING

"""Pace: what comes often is decoded together, which costs half as much as one by one
(samples of RTDE at 500 Hz)."""

import time

GATHERING = 0.005
"""Between two looks at what came [s]: live samples are averaged over as long."""


class Pace:
    """Keeps looks apart."""

    def __init__(self):
        self._next = 0.0
        """[s] of the monotonic clock"""

    def wait(self) -> None:
        """Wait until `GATHERING` after the last time."""
        time.sleep(max(self._next - time.monotonic(), 0.0))
        self._next = time.monotonic() + GATHERING

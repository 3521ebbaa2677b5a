"""Messages that another thread brings, until they are read."""

import queue
from collections import Counter

from hefting.sources.limits import MAX_QUEUED, QUEUE_FULL
from hefting.sources.ros_decoding import RosMessage

MOST = 1000
"""Most messages that are taken at once."""


class Inbox:
    """A bounded queue; what does not fit is counted in `skipped`."""

    def __init__(self):
        self.skipped: Counter[str] = Counter()
        self._queue: queue.Queue[RosMessage] = queue.Queue(MAX_QUEUED)

    def put(self, message: RosMessage) -> None:
        """Add a message; never waits."""
        try:
            self._queue.put_nowait(message)
        except queue.Full:
            self.skipped[QUEUE_FULL] += 1

    def take(self, timeout: float) -> list[RosMessage]:
        """What is there, after waiting at most `timeout` [s] for the first."""
        found: list[RosMessage] = []
        try:
            found.append(self._queue.get(timeout=max(timeout, 1e-3)))
            while len(found) < MOST:
                found.append(self._queue.get_nowait())
        except queue.Empty:
            pass
        return found

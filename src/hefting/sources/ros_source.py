"""ROS messages over any transport: topics are chosen from the first messages."""

import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable

from hefting.logs.ros.source import Topic
from hefting.online.samples import Samples
from hefting.sources import MAX_UNREAD, NamedSource, Pace, Request
from hefting.sources.ros_decoding import RosDecoder, RosMessage

SETTLING = 0.5
"""[s] Time from the first message to the choice of topics: latched transforms, and
rivals for the same role, come later than the first."""

PATIENCE = 5.0
"""[s] Longest wait for a wrench, and for poses or joints."""

STEP = 0.05
"""[s] Longest wait for a message while topics are chosen."""


class Transport(ABC):
    """A connection that receives ROS messages."""

    def __init__(self, name: str):
        self.name = name
        self.topics: list[Topic] = []
        """topics that are known to be offered"""
        self.skipped: Counter[str] = Counter()
        """set by the source: number of unreadable messages by reason"""
        self._wants: Callable[[Topic], bool] = lambda topic: False

    @abstractmethod
    def connect(self, wants: Callable[[Topic], bool]) -> None:
        """Connect, and subscribe to each wanted topic once it is offered; raises
        `InputError` where that fails."""

    @abstractmethod
    def receive(self, timeout: float) -> list[RosMessage]:
        """The messages that came, after waiting at most `timeout` [s] for them; raises
        `SourceLostError` when the connection is lost."""

    @abstractmethod
    def close(self) -> None:
        """Disconnect; further calls do nothing."""


def source_by(transport: Callable[[str], Transport]) -> Callable[..., "RosSource"]:
    """A function that makes sources with a kind of transport."""
    return lambda name, request: RosSource(name, request, transport(name))


class RosSource(NamedSource):
    """Decodes a transport's messages; see `hefting.online.samples.Source`."""

    def __init__(self, name: str, request: Request, transport: Transport):
        super().__init__(name)
        self._request, self._transport = request, transport
        transport.skipped = self.skipped
        self._decoder: RosDecoder | None = None
        self._first: list[Samples] = []
        self._pace = Pace()

    def open(self) -> None:
        """Connect, and choose topics unless they were chosen on an earlier connection;
        `InputError` where there are none to choose, or too many."""
        decoder = self._decoder or RosDecoder(self.name, self._request, self.skipped)
        self._transport.connect(decoder.wants)
        if decoder is self._decoder:
            return
        try:
            self._first = self._choose(decoder)
        except BaseException:
            self._transport.close()
            raise
        self._decoder, self.chosen = decoder, decoder.chosen

    def read(self, timeout: float) -> list[Samples]:
        """See `hefting.online.samples.Source`."""
        if self._first:
            found, self._first = self._first, []
            return found
        assert self._decoder is not None
        self._pace.wait()
        messages = self._transport.receive(timeout)
        return self._decoder.decode(messages) if messages else []

    def close(self) -> None:
        """Disconnect."""
        self._transport.close()

    def _choose(self, decoder: RosDecoder) -> list[Samples]:
        messages: list[RosMessage] = []
        end, due, size = time.monotonic() + PATIENCE, None, 0
        while (now := time.monotonic()) < end and size < MAX_UNREAD:
            new = self._transport.receive(STEP)
            messages += new
            size += sum(len(data) for _, _, data in new)
            if messages and due is None:
                due = now + SETTLING
            if due is not None and now >= due:
                if (found := decoder.choose(messages)) is not None:
                    return found
                due = now + SETTLING
        raise decoder.missing(self._transport.topics, messages)

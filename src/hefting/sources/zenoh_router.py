"""``zenoh://HOST[:PORT][/DOMAIN]``: ROS messages from a Zenoh router that rmw_zenoh
uses, or from zenoh-bridge-ros2dds.

Topics are found by the liveliness tokens of their publishers. Of rmw_zenoh:
``@ros2_lv/DOMAIN/SESSION/NODE/ENTITY/MP/ENCLAVE/NAMESPACE/NAME/TOPIC/TYPE/HASH/QOS``
with ``%`` for slashes, and messages at ``DOMAIN/TOPIC/TYPE/HASH``; of the bridge:
``@/BRIDGE/@ros2_lv/MP/TOPIC/TYPE/QOS`` with ``§`` for slashes, and messages at
``TOPIC``. The session is a client, as peers receive nothing through a router.
"""

import json
import queue
import threading
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from hefting.core.errors import InputError, needing
from hefting.logs.ros.source import Topic
from hefting.online.samples import SourceLostError
from hefting.sources import (
    MAX_MESSAGE,
    MAX_UNREAD,
    QUEUE_FULL,
    TOO_LARGE,
    address_of,
)
from hefting.sources.ros_decoding import RosMessage
from hefting.sources.ros_source import Transport, source_by

MOST = 1000


class Inbox:
    """Bounded queue of another thread's messages; `skipped` counts the others."""

    def __init__(self):
        self.skipped: Counter[str] = Counter()
        self._queue: queue.Queue[RosMessage] = queue.Queue()

    def put(self, message: RosMessage) -> None:
        """Add a message; never waits."""
        if self._queue.qsize() * (len(message[2]) + 1000) < MAX_UNREAD:
            self._queue.put(message)
        else:
            self.skipped[QUEUE_FULL] += 1

    def take(self, timeout: float) -> list[RosMessage]:
        """The waiting messages, after at most `timeout` [s] for the first."""
        found: list[RosMessage] = []
        try:
            found.append(self._queue.get(timeout=max(timeout, 1e-3)))
            while len(found) < MOST:
                found.append(self._queue.get_nowait())
        except queue.Empty:
            pass
        return found


PORT = 7447
"""Default port of a Zenoh router."""

EXAMPLE = f"zenoh://localhost:{PORT}/0"

BRIDGE_TOKENS = "@/*/@ros2_lv/MP/**"
"""Liveliness tokens of zenoh-bridge-ros2dds."""

CHECK = 1.0
"""[s] Time between checks that the router runs."""

MAX_TOPICS = 10_000


class ZenohTransport(Transport):
    """One client of a Zenoh router."""

    def __init__(self, name: str):
        super().__init__(name)
        address = address_of(name, PORT, EXAMPLE)
        if address.path and not address.path.isdigit():
            raise InputError("the domain is a number", name, f"as in {EXAMPLE}")
        self._endpoint, self._domain = f"tcp/{address.place}", address.path or "0"
        self._session: Any = None
        self._inbox = Inbox()
        self._found: list[str] = []
        self._lock, self._checked = threading.Lock(), 0.0
        self._subscribers: dict[str, Any] = {}

    def connect(self, wants: Callable[[Topic], bool]) -> None:
        """As `Transport`."""
        with needing("eclipse-zenoh", "live"):
            import zenoh
        self._wants, self.topics, self._found = wants, [], []
        self._inbox.skipped = self.skipped
        config = zenoh.Config()
        for key, value in (
            ("mode", "client"),
            ("connect/endpoints", [self._endpoint]),
            ("connect/timeout_ms", 3000),
            ("connect/exit_on_failure", True),
            ("scouting/multicast/enabled", False),
        ):
            config.insert_json5(key, json.dumps(value))
        try:
            self._session = zenoh.open(config)
        except zenoh.ZError as error:
            raise InputError(
                "cannot be reached",
                self.name,
                "check the host and the port, and that a Zenoh router runs there",
            ) from error
        self._checked = time.monotonic()
        tokens = self._session.liveliness()
        for key in (f"@ros2_lv/{self._domain}/**", BRIDGE_TOKENS):
            self._subscribers[key] = tokens.declare_subscriber(
                key, self._hear, history=True
            )

    def receive(self, timeout: float) -> list[RosMessage]:
        """As `Transport`."""
        if self._session is None:
            raise SourceLostError(f"{self.name}: is closed")
        self._subscribe()
        found = self._inbox.take(timeout)
        if not found and time.monotonic() - self._checked > CHECK:
            self._checked = time.monotonic()
            if not self._session.info.routers_zid():
                raise SourceLostError(f"{self.name}: the router is gone")
        return found

    def close(self) -> None:
        """Disconnect."""
        session, self._session, self._subscribers = self._session, None, {}
        if session is not None:
            session.close()

    def _hear(self, sample: Any) -> None:
        with self._lock:
            if len(self._found) < MAX_TOPICS:
                self._found.append(str(sample.key_expr))

    def _subscribe(self) -> None:
        with self._lock:
            found, self._found = self._found, []
        for token in found:
            parsed = parse_token(token)
            if parsed is None or parsed[1] in self._subscribers:
                continue
            topic, key = parsed
            if len(self.topics) < MAX_TOPICS:
                self.topics.append(topic)
            if self._wants(topic):
                self._subscribers[key] = self._listen(topic, key)

    def _listen(self, topic: Topic, key: str) -> Any:
        """A subscriber, which also requests earlier messages."""
        from zenoh.ext import HistoryConfig, declare_advanced_subscriber

        def take(sample: Any) -> None:
            if len(sample.payload) > MAX_MESSAGE:
                self.skipped[TOO_LARGE] += 1
                return
            self._inbox.put((topic, time.time_ns(), sample.payload.to_bytes()))

        return declare_advanced_subscriber(
            self._session, key, take, history=HistoryConfig(max_samples=100)
        )


def parse_token(token: str) -> tuple[Topic, str] | None:
    """The topic of a publisher's liveliness token, and the key of its messages; None
    for other tokens."""
    parts = token.split("/")
    if parts[0] == "@ros2_lv" and len(parts) >= 12 and parts[5] == "MP":
        name, kind = parts[9].replace("%", "/"), parts[10]
        topic = Topic(name, ros_type(kind), "cdr")
        return topic, f"{parts[1]}/{name.strip('/')}/{kind}/*"
    if parts[0] == "@" and len(parts) >= 6 and parts[2:4] == ["@ros2_lv", "MP"]:
        name, kind = (part.replace("§", "/") for part in parts[4:6])
        return Topic(f"/{name.strip('/')}", ros_type(kind), "cdr"), name.strip("/")
    return None


def ros_type(name: str) -> str:
    """``geometry_msgs::msg::dds_::Wrench_`` as geometry_msgs/msg/Wrench."""
    return name.replace("::dds_::", "::").replace("::", "/").removesuffix("_")


SOURCE = source_by(ZenohTransport)

"""``ws://HOST[:PORT]``: ROS messages from foxglove_bridge, or from any program of the
Foxglove SDK.

Protocol: https://github.com/foxglove/ws-protocol. Bridges from 3 on speak it as
``foxglove.sdk.v1``, older ones as ``foxglove.websocket.v1``.
"""

import json
import struct
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

from hefting.core.errors import InputError, needing
from hefting.logs.ros.records import full_type
from hefting.logs.ros.source import Topic
from hefting.online.samples import SourceLostError
from hefting.sources import (
    MAX_MESSAGE,
    UNREADABLE,
    address_of,
)
from hefting.sources.ros_decoding import RosMessage
from hefting.sources.ros_source import Transport, source_by

if TYPE_CHECKING:
    from websockets.sync.client import ClientConnection

PORT = 8765
"""Default port of foxglove_bridge."""

PROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Subprotocols that are offered; the parts that are used here are the same in both."""

MAX_FRAME = 16_000_000
"""Largest frame [bytes]: one frame lists all channels with their schemas."""

MAX_CHANNELS = 10_000

PATIENCE = 3.0

MOST = 1000

MESSAGE = struct.Struct("<BIQ")
"""Header of a message: 1, its subscription, and the time when it was sent [ns]."""


class FoxgloveTransport(Transport):
    """One connection to a Foxglove WebSocket server."""

    def __init__(self, name: str):
        super().__init__(name)
        self._channels: dict[int, Topic] = {}
        self._connection: ClientConnection | None = None
        self._address = address_of(name, PORT, f"ws://localhost:{PORT}")

    def connect(self, wants: Callable[[Topic], bool]) -> None:
        """As `Transport`."""
        with needing("websockets", "live"):
            from websockets.exceptions import InvalidHandshake, InvalidURI
            from websockets.sync.client import connect
            from websockets.typing import Subprotocol
        self._wants, self.topics, self._channels = wants, [], {}
        scheme = self.name.partition("://")[0].lower()
        try:
            self._connection = connect(
                f"{scheme}://{self._address.place}/{self._address.path}",
                subprotocols=[Subprotocol(name) for name in PROTOCOLS],
                compression=None,
                open_timeout=PATIENCE,
                close_timeout=1,
                max_size=MAX_FRAME,
                proxy=None,
            )
        except (OSError, InvalidHandshake, InvalidURI) as error:
            raise InputError(
                f"cannot be reached ({getattr(error, 'strerror', None) or error})",
                self.name,
                "check the host and the port, and that foxglove_bridge runs there",
            ) from error

    def receive(self, timeout: float) -> list[RosMessage]:
        """As `Transport`."""
        from websockets.exceptions import ConnectionClosed

        if self._connection is None:
            raise SourceLostError(f"{self.name}: is closed")
        found: list[RosMessage] = []
        size = 0
        try:
            for _ in range(MOST):
                frame = self._connection.recv(timeout=timeout)
                timeout, size = 0, size + len(frame)
                if isinstance(frame, str):
                    self._read_text(frame)
                else:
                    found += self._message(frame)
                if size > MAX_MESSAGE:
                    break
        except TimeoutError:
            pass
        except (ConnectionClosed, OSError) as error:
            if not found:
                raise SourceLostError(
                    f"{self.name}: the connection was closed"
                ) from error
        return found

    def close(self) -> None:
        """Disconnect."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _message(self, frame: bytes) -> list[RosMessage]:
        if frame[:1] != b"\1":
            return []  # such as the time, an asset, or the answer of a service
        if len(frame) < MESSAGE.size:
            self.skipped[UNREADABLE] += 1
            return []
        _, subscription, sent = MESSAGE.unpack_from(frame)
        topic = self._channels.get(subscription)
        if topic is None or sent >= 2**63:
            return []
        return [(topic, sent or time.time_ns(), frame[MESSAGE.size :])]

    def _read_text(self, text: str) -> None:
        """Subscribe to the wanted ones of the channels that a text frame advertises."""
        try:
            content: Any = json.loads(text)
        except (ValueError, RecursionError):
            content = None
        if not isinstance(content, dict):
            self.skipped["not a JSON object"] += 1
            return
        channels = content.get("channels")
        if content.get("op") != "advertise" or not isinstance(channels, list):
            return
        wanted: list[dict[str, int]] = []
        for channel in channels[:MAX_CHANNELS]:
            topic = topic_of(channel)
            if topic is None or len(self.topics) >= MAX_CHANNELS:
                self.skipped["a channel without a name"] += 1
                continue
            self.topics.append(topic)
            if self._wants(topic):
                own = int(channel["id"])
                self._channels[own] = topic
                wanted.append({"id": own, "channelId": own})
        if wanted and self._connection is not None:
            request = {"op": "subscribe", "subscriptions": wanted}
            self._connection.send(json.dumps(request))


def topic_of(channel: Any) -> Topic | None:
    """The topic of an advertised channel; None for an invalid one."""
    if not isinstance(channel, dict):
        return None
    entry = cast(dict[str, Any], channel)
    keys = "topic", "schemaName", "encoding", "schema"
    texts = [entry.get(key, "") for key in keys]
    language = entry.get("schemaEncoding") or "ros2msg"
    number = entry.get("id")
    if not (
        type(number) is int
        and 0 <= number < 2**32
        and all(isinstance(text, str) for text in (*texts, language))
    ):
        return None
    name, kind, encoding, schema = texts
    return Topic(name, full_type(kind), encoding, schema, language)


SOURCE = source_by(FoxgloveTransport)

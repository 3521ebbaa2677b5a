"""``dds://DOMAIN``: ROS 2 messages straight from its middleware, such as rmw_fastrtps
and rmw_cyclonedds.

ROS calls topic ``/wrench`` ``rt/wrench`` and type pkg/msg/Name
``pkg::msg::dds_::Name_`` there. Without multicast, environment variable CYCLONEDDS_URI
names peers.
"""

import time
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from hefting.core.errors import InputError, needing
from hefting.logs.ros.layout import PLACEHOLDER, standard_definitions
from hefting.logs.ros.source import Topic
from hefting.online.samples import SourceLostError
from hefting.sources import MAX_MESSAGE, TOO_LARGE
from hefting.sources.ros_decoding import RosMessage
from hefting.sources.ros_source import Transport, source_by
from hefting.sources.zenoh_router import ros_type


@lru_cache
def type_for(name: str) -> Any:
    """A class for ``pkg/msg/Name`` that `cyclonedds` takes as the type of a topic.

    Its `deserialize` returns a `RawMessage`, as decoding by cyclonedds takes a
    millisecond per message. ROS publishers announce only the name of their type, so that
    the name suffices.
    """
    made = _struct(name)

    def deserialize(
        cls: Any, data: bytes, has_header: bool = True, use_version_2: Any = None
    ) -> RawMessage:
        return RawMessage(data)

    made.deserialize = classmethod(deserialize)
    return made


class RawMessage:
    """The bytes of a message with its encapsulation header."""

    sample_info: Any = None

    def __init__(self, data: bytes):
        self.data = bytes(data)


@lru_cache
def struct_for(name: str) -> Any:
    """A class for ``pkg/msg/Name`` that `cyclonedds` decodes."""
    return _struct(name)


def _struct(name: str) -> Any:
    from cyclonedds.idl import annotations, make_idl_struct

    definitions = standard_definitions("cdr")
    if name not in definitions:
        raise InputError(f"the schema of {name} is not understood")
    package, _, kind = name.rpartition("/")
    fields = {
        field: _type_of(node, detail)
        for field, (node, detail) in definitions[name][1]
        if field != PLACEHOLDER
    }
    typename = f"{package.replace('/', '::')}::dds_::{kind}_"
    made = make_idl_struct(kind, typename, fields)
    annotations.final(made)
    return made


def _type_of(node: int, detail: Any) -> Any:
    from cyclonedds.idl import types

    if int(node) == 1:
        if detail[0] == "string":
            return str
        plain = {"bool": bool, "byte": types.uint8, "char": types.uint8}
        return plain.get(detail[0]) or getattr(types, detail[0])
    if int(node) == 2:
        return struct_for(detail)
    (element, content), count = detail
    inner = _type_of(element, content)
    return types.array[inner, count] if int(node) == 3 else types.sequence[inner]


HIGHEST_DOMAIN = 232
"""Highest domain of DDS; higher ones have no port."""

DEPTH = 5000
"""Largest number of unread messages of a topic."""

LOOKING = 0.2
"""[s] Time between searches for new topics."""

MAX_TOPICS = 10_000


class DdsTransport(Transport):
    """One participant of a DDS domain."""

    def __init__(self, name: str):
        super().__init__(name)
        domain = name.partition("://")[2].strip("/")
        if not domain.isdecimal() or int(domain) > HIGHEST_DOMAIN:
            what = f"the domain is a number from 0 to {HIGHEST_DOMAIN}"
            raise InputError(what, name, "as in dds://0")
        self._domain = int(domain)
        self._participant: Any = None
        self._found: Any = None
        self._waiting: Any = None
        self._readers: dict[str, tuple[Topic, Any]] = {}
        self._names: set[tuple[str, str]] = set()
        self._looked = 0.0

    def connect(self, wants: Callable[[Topic], bool]) -> None:
        """As `Transport`."""
        with needing("cyclonedds", "live"):
            from cyclonedds.builtin import (
                BuiltinDataReader,
                BuiltinTopicDcpsPublication,
            )
            from cyclonedds.core import DDSException, WaitSet
            from cyclonedds.domain import DomainParticipant
        self._wants, self.topics = wants, []
        self._readers, self._names = {}, set()
        try:
            self._participant = DomainParticipant(self._domain)
            self._waiting = WaitSet(self._participant)
            self._found = BuiltinDataReader(
                self._participant, BuiltinTopicDcpsPublication
            )
        except DDSException as error:
            raise InputError(
                f"cannot be joined ({error.msg})",
                self.name,
                "check the network, and CYCLONEDDS_URI if it is set",
            ) from error

    def receive(self, timeout: float) -> list[RosMessage]:
        """As `Transport`."""
        if self._participant is None:
            raise SourceLostError(f"{self.name}: is closed")
        now = time.monotonic()
        if now - self._looked > LOOKING:
            self._looked = now
            self._subscribe()
        if not self._readers:
            time.sleep(min(timeout, LOOKING))
            return []
        self._waiting.wait(int(max(timeout, 1e-3) * 1e9))
        return [each for pair in self._readers.values() for each in self._take(*pair)]

    def close(self) -> None:
        """Leave the domain."""
        self._readers, self._waiting, self._found = {}, None, None
        self._participant = None  # cyclonedds closes it once it has no references

    def _take(self, topic: Topic, reader: Any) -> list[RosMessage]:
        found: list[RosMessage] = []
        for sample in reader.take(N=DEPTH):
            data = getattr(sample, "data", None)
            if data is None:
                continue  # its publisher has ended
            if len(data) > MAX_MESSAGE:
                self.skipped[TOO_LARGE] += 1
                continue
            stamp = sample.sample_info.source_timestamp
            found.append((topic, stamp if stamp > 0 else time.time_ns(), data))
        return found

    def _subscribe(self) -> None:
        for endpoint in self._found.take(N=1000):
            # both are None for a publisher that has ended
            name = getattr(endpoint, "topic_name", None) or ""
            kind = getattr(endpoint, "type_name", None) or ""
            if (name, kind) in self._names or not name.startswith("rt/"):
                continue
            if len(self._names) >= MAX_TOPICS:
                return
            self._names.add((name, kind))
            topic = Topic(name.removeprefix("rt"), ros_type(kind), "cdr")
            self.topics.append(topic)
            if self._wants(topic):
                self._readers[name] = (topic, self._listen(topic, name, endpoint.qos))

    def _listen(self, topic: Topic, name: str, offered: Any) -> Any:
        from cyclonedds.core import (
            InstanceState,
            Policy,
            Qos,
            ReadCondition,
            SampleState,
            ViewState,
        )
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic as DdsTopic
        from cyclonedds.util import duration

        reliable = Policy.Reliability.Reliable(duration(seconds=1))
        is_reliable = any(
            isinstance(policy, Policy.Reliability.Reliable) for policy in offered
        )
        policies = [
            reliable if is_reliable else Policy.Reliability.BestEffort,
            Policy.History.KeepLast(DEPTH),
        ]
        if Policy.Durability.TransientLocal in offered:
            policies.append(Policy.Durability.TransientLocal)
        qos = Qos(*policies)
        own = DdsTopic(self._participant, name, type_for(topic.type))
        reader = DataReader(self._participant, own, qos=qos)
        state = SampleState.Any | ViewState.Any | InstanceState.Any
        self._waiting.attach(ReadCondition(reader, state))
        return reader


SOURCE = source_by(DdsTransport)

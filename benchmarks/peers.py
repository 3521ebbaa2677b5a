"""What sends live samples, in a process of its own: ``python -m benchmarks.peers
TRANSPORT PORT SECONDS``.

Each sends 500 wrenches and 100 poses a second (RTDE: 500), stamped with the clock of this
machine; the force along x counts the wrenches, x counts the poses. A fourth number N
sends something malformed after every Nth wrench.
"""

import json
import socket
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from benchmarks.fast_dds import FastDds
from hefting.logs.ros.writing import Messages, serialise

RATE, RATIO = 500, 5
"""Wrenches a second, and wrenches to each pose."""

GARBAGE = b"\xff\xfe no message"


def ticks(seconds: float) -> Iterator[tuple[int, int]]:
    """Number and time [ns] of each wrench, when it is due."""
    begin = time.perf_counter()
    for k in range(round(seconds * RATE)):
        late = time.perf_counter() - begin - k / RATE
        if late < 0:
            time.sleep(-late)
        yield k, time.time_ns()


def count(seconds: float) -> tuple[int, int]:
    """How many wrenches and poses are sent."""
    wrenches = round(seconds * RATE)
    return wrenches, -(-wrenches // RATIO)


def wrench_of(k: int) -> list[float]:
    """Force [N] and torque [N m]."""
    return [float(k), 0.0, -9.8, 0.01, 0.02, 0.0]


def position_of(k: int) -> list[float]:
    """[m]"""
    return [k / RATIO, 0.5, 0.25]


ORIENTATION = [0.0, 0.0, 0.0, 1.0]


def line(k: int, stamp: int) -> bytes:
    """A line of JSON."""
    entry: dict[str, Any] = {"time": stamp / 1e9, "wrench": wrench_of(k)}
    if k % RATIO == 0:
        entry |= {"position": position_of(k), "orientation": ORIENTATION}
    return json.dumps(entry).encode() + b"\n"


def json_lines(seconds: float, bad: int, send: Callable[[bytes], Any]) -> None:
    """Lines of JSON."""
    for k, stamp in ticks(seconds):
        send(line(k, stamp))
        if bad and k % bad == 0:
            send(b'{"time": 1, "wrench": [1, 2\n')


def tcp(port: int, seconds: float, bad: int) -> None:
    """Lines of JSON to the first that connects."""
    with accepted(port) as connection:
        json_lines(seconds, bad, connection.sendall)


def standard_output(port: int, seconds: float, bad: int) -> None:
    """Lines of JSON on standard output."""

    def send(data: bytes) -> None:
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()

    json_lines(seconds, bad, send)


def accepted(port: int) -> socket.socket:
    """The connection of the first that connects."""
    with socket.create_server(("127.0.0.1", port)) as server:
        print("ready", flush=True)
        connection, _ = server.accept()
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return connection


class Ros:
    """Bytes of ROS 2 messages."""

    def __init__(self):
        from rosbags.typesys import Stores, get_typestore

        self.store = get_typestore(Stores.ROS2_HUMBLE)

    def definition(self, kind: str) -> bytes:
        """The definition of a message, as ROS writes it."""
        return self.store.generate_msgdef(kind, ros_version=2)[0].encode()

    def message(self, kind: str, frame: str, stamp: int, fields: dict) -> bytes:
        """One message."""
        own = {name: np.array([[value]]) for name, value in fields.items()}
        group = Messages("", kind, frame, np.array([stamp]), own)
        return serialise(group, self.store, "cdr")[0].tobytes()

    def wrench(self, k: int, stamp: int) -> bytes:
        """The wrench of a tick."""
        places = [f"wrench.{part}.{a}" for part in ("force", "torque") for a in "xyz"]
        fields = dict(zip(places, wrench_of(k), strict=True))
        return self.message(WRENCH, "sensor", stamp, fields)

    def pose(self, k: int, stamp: int) -> bytes:
        """The pose of a tick."""
        places = [f"pose.position.{a}" for a in "xyz"]
        places += [f"pose.orientation.{a}" for a in "xyzw"]
        fields = dict(zip(places, [*position_of(k), *ORIENTATION], strict=True))
        return self.message(POSE, "world", stamp, fields)


WRENCH, POSE = "geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/PoseStamped"


def send_ros(seconds: float, bad: int, send: Callable[[str, bytes, int], Any]) -> None:
    """Messages of both topics through `send(topic, data, stamp)`."""
    ros = Ros()
    for k, stamp in ticks(seconds):
        send("/wrench", ros.wrench(k, stamp), stamp)
        if k % RATIO == 0:
            send("/pose", ros.pose(k, stamp), stamp)
        if bad and k % bad == 0:
            send("/wrench", GARBAGE, stamp)


def websocket(port: int, seconds: float, bad: int) -> None:
    """A Foxglove WebSocket server, as foxglove_bridge is one."""
    import foxglove

    ros = Ros()
    server = foxglove.start_server(name="peer", host="127.0.0.1", port=port)
    channels = {}
    for topic, kind in (("/wrench", WRENCH), ("/pose", POSE)):
        schema = foxglove.Schema(
            name=kind, encoding="ros2msg", data=ros.definition(kind)
        )
        channels[topic] = foxglove.Channel(topic, schema=schema, message_encoding="cdr")
    print("ready", flush=True)
    while not all(channel.has_sinks() for channel in channels.values()):
        time.sleep(0.01)
    send_ros(
        seconds,
        bad,
        lambda topic, data, stamp: channels[topic].log(data, log_time=stamp),
    )
    time.sleep(1.0)
    server.stop()


def zenoh(port: int, seconds: float, bad: int) -> None:
    """A Zenoh router, and a client that publishes as rmw_zenoh does."""
    import zenoh

    place = f'["tcp/127.0.0.1:{port}"]'
    router = session_of("router", "listen/endpoints", place)
    session = session_of("client", "connect/endpoints", place)
    publishers, tokens = {}, []
    for n, (topic, kind) in enumerate((("wrench", WRENCH), ("pose", POSE))):
        name = "::".join(kind.split("/")[:2]) + f"::dds_::{kind.split('/')[2]}_"
        options = {
            "congestion_control": zenoh.CongestionControl.BLOCK,
            "express": True,
        }
        key = f"0/{topic}/{name}/RIHS01_0123"
        publishers[f"/{topic}"] = session.declare_publisher(key, **options)
        token = f"@ros2_lv/0/{session.info.zid()}/0/{n}/MP/%/%/peer/%{topic}/{name}"
        tokens.append(
            session.liveliness().declare_token(f"{token}/RIHS01_0123/::,10:,:,:,,")
        )
    print("ready", flush=True)
    while not all(each.matching_status.matching for each in publishers.values()):
        time.sleep(0.01)
    time.sleep(0.1)
    send_ros(seconds, bad, lambda topic, data, _: publishers[topic].put(data))
    time.sleep(1.0)
    session.close()
    router.close()


def session_of(mode: str, key: str, value: str) -> Any:
    """A Zenoh session."""
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", f'"{mode}"')
    config.insert_json5(key, value)
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


def dds(port: int, seconds: float, bad: int) -> None:
    """A DDS participant of domain `port`, as a ROS 2 node is one."""
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.topic import Topic
    from cyclonedds.util import duration

    from hefting.sources.dds import struct_for

    participant = DomainParticipant(port)
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepAll)
    writers = {
        topic: DataWriter(
            participant, Topic(participant, f"rt{topic}", struct_for(kind)), qos=qos
        )
        for topic, kind in (("/wrench", WRENCH), ("/pose", POSE))
    }
    types = {"/wrench": struct_for(WRENCH), "/pose": struct_for(POSE)}
    print("ready", flush=True)
    while not all(each.get_matched_subscriptions() for each in writers.values()):
        time.sleep(0.01)
    time.sleep(0.2)

    def send(topic: str, data: bytes, stamp: int) -> None:
        if data is not GARBAGE:
            writers[topic].write(types[topic].deserialize(data))

    send_ros(seconds, bad, send)
    time.sleep(1.0)


def fast_dds(port: int, seconds: float, bad: int) -> None:
    """The same by Fast DDS; what is malformed is cut short, but has the first bytes of a
    message, by which middleware tells what comes."""
    peer = FastDds(port, {"/wrench": WRENCH, "/pose": POSE})
    print("ready", flush=True)
    peer.wait_for_readers()
    time.sleep(0.2)

    def send(topic: str, data: bytes, stamp: int) -> None:
        peer.send(topic, bytes((0, 1, 0, 0, *range(8))) if data is GARBAGE else data)

    send_ros(seconds, bad, send)
    time.sleep(1.0)


def rtde(port: int, seconds: float, bad: int) -> None:
    """A controller of Universal Robots."""
    from benchmarks.fake_controller import Controller

    with accepted(port) as connection:
        Controller(connection).serve(ticks(seconds), bad)


PEERS = {
    "-": standard_output,
    "tcp": tcp,
    "ws": websocket,
    "zenoh": zenoh,
    "dds": dds,
    "fastdds": fast_dds,
    "rtde": rtde,
}


def main() -> None:
    """Send for as long as asked."""
    name, port, seconds, *bad = sys.argv[1:]
    PEERS[name](int(port), float(seconds), int(bad[0]) if bad else 0)


if __name__ == "__main__":
    main()

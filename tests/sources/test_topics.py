"""What transports say of their topics is read as far as it makes sense."""

import pytest

from hefting.sources import UNREADABLE
from hefting.sources.dds import DdsTransport
from hefting.sources.foxglove_websocket import FoxgloveTransport, topic_of
from hefting.sources.zenoh_router import parse_token

KIND = "geometry_msgs::msg::dds_::WrenchStamped_"
HASH = "RIHS01_8dc3deaf06b2ab281f9f9a742a8961c328ca7cec16e3fd6586d3a5c83fa78f77"


def test_tokens_of_rmw_zenoh():
    token = f"@ros2_lv/7/1f/0/11/MP/%/%/driver/%arm%wrench/{KIND}/{HASH}/::,10:,:,:,,"
    found = parse_token(token)
    assert found is not None
    topic, key = found
    assert (topic.name, topic.encoding) == ("/arm/wrench", "cdr")
    assert topic.type == "geometry_msgs/msg/WrenchStamped"
    # whatever the hash: Humble has another one
    assert key == f"7/arm/wrench/{KIND}/*"


def test_tokens_of_the_bridge():
    kind = "geometry_msgs§msg§WrenchStamped"
    found = parse_token(f"@/1f/@ros2_lv/MP/arm§wrench/{kind}/::,10")
    assert found is not None
    topic, key = found
    assert (topic.name, key) == ("/arm/wrench", "arm/wrench")
    assert topic.type == "geometry_msgs/msg/WrenchStamped"


@pytest.mark.parametrize(
    "token",
    [
        "",
        "/",
        "@ros2_lv/7",
        f"@ros2_lv/7/1f/0/11/MS/%/%/driver/%wrench/{KIND}/{HASH}/q",
        "@ros2_lv/7/1f/0/0/NN/%/%/driver",
        "@/1f/@ros2_lv/MS/wrench/kind/q",
        "@/1f/@ros2_lv/MP",
    ],
)
def test_other_tokens_are_no_publishers(token):
    assert parse_token(token) is None


CHANNEL = {
    "id": 3,
    "topic": "/wrench",
    "encoding": "ros1",
    "schemaName": "geometry_msgs/WrenchStamped",
    "schema": "Header header",
}


def test_channels():
    topic = topic_of(CHANNEL)
    assert topic is not None
    assert topic.type == "geometry_msgs/msg/WrenchStamped"
    assert (topic.name, topic.encoding) == ("/wrench", "ros1")


@pytest.mark.parametrize(
    "channel",
    [
        None,
        [],
        CHANNEL | {"id": "3"},
        CHANNEL | {"id": -1},
        CHANNEL | {"id": 2**32},
        CHANNEL | {"id": True},
        CHANNEL | {"topic": 5},
        CHANNEL | {"schema": ["x"]},
        CHANNEL | {"schemaEncoding": 1},
    ],
)
def test_what_is_no_channel(channel):
    assert topic_of(channel) is None


@pytest.mark.parametrize("text", ["", "nothing", "[]", "[" * 100_000, '{"op": 1}'])
def test_what_a_server_should_not_say_is_survived(text):
    transport = FoxgloveTransport("ws://localhost")
    transport._read_text(text)
    transport._read_text('{"op": "advertise", "channels": 7}')
    assert transport.topics == []


def test_frames_that_are_no_messages():
    transport = FoxgloveTransport("ws://localhost")
    for frame in (b"", b"\2" * 20, b"\1" + bytes(12)):
        assert transport._message(frame) == []
    assert not transport.skipped
    assert transport._message(b"\1short") == []
    assert transport.skipped == {UNREADABLE: 1}


def test_a_dds_publisher_that_went_away_is_passed_over():
    """What cyclonedds gives then has no names."""

    class Gone:
        topic_name = type_name = None

    class Found:
        def take(self, N):
            return [Gone()]

    transport = DdsTransport("dds://0")
    transport._found = Found()
    transport._subscribe()
    assert transport.topics == []

"""Samples that cannot be are left out and counted; the others pass unchanged."""

from collections import Counter

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.logs.ros.source import Topic
from hefting.online.samples import Samples
from hefting.sources import QUEUE_FULL, Request, check
from hefting.sources.foxglove_websocket import MESSAGE, FoxgloveTransport
from hefting.sources.ros_source import RosSource, Transport
from hefting.sources.zenoh_router import Inbox

TIME = np.arange(5.0)


def bad(width: int, value: float, row: int = 2) -> np.ndarray:
    values = np.zeros((5, width))
    values[row, -1] = value
    return values


def turned(norm: float) -> np.ndarray:
    values = np.tile([0.0, 0.0, 0.0, 1.0], (5, 1))
    values[2] *= norm
    return values


@pytest.mark.parametrize(
    ("samples", "reason"),
    [
        (Samples("wrench", TIME, bad(6, np.nan)), "values that are not finite"),
        (Samples("wrench", TIME, bad(6, np.inf)), "values that are not finite"),
        (Samples("wrench", TIME, bad(6, 1e11)), "values that cannot be"),
        (Samples("position", TIME, bad(3, -1e9)), "values that cannot be"),
        (
            Samples("orientation", TIME, turned(1.1)),
            "quaternions that are not of unit norm",
        ),
        (
            Samples("orientation", TIME, turned(0.0)),
            "quaternions that are not of unit norm",
        ),
        (
            Samples("wrench", np.where(TIME == 2, 1e13, TIME), bad(6, 0.0)),
            "times that cannot be seconds",
        ),
    ],
)
def test_one_bad_sample_is_left_out(samples, reason):
    skipped: Counter[str] = Counter()
    found = check(samples, skipped)
    assert found is not None
    assert skipped == {reason: 1}
    assert found.time.tolist() == [0, 1, 3, 4]
    assert np.array_equal(found.values, np.delete(samples.values, 2, axis=0))


@pytest.mark.parametrize(
    "samples",
    [
        Samples("torque", TIME, np.zeros((5, 6))),
        Samples("wrench", TIME, np.zeros((5, 5))),
        Samples("wrench", TIME, np.zeros(5)),
        Samples("wrench", TIME[:4], np.zeros((5, 6))),
        Samples("joint_positions", TIME, np.zeros((5, 1001))),
    ],
)
def test_what_is_no_stream_is_left_out(samples):
    skipped: Counter[str] = Counter()
    assert check(samples, skipped) is None
    assert list(skipped) == ["not the shape of a stream"]


def test_good_samples_pass():
    skipped: Counter[str] = Counter()
    samples = Samples("joint_positions", TIME, np.ones((5, 7)))
    found = check(samples, skipped)
    assert found is not None
    assert np.array_equal(found.values, samples.values)
    assert not skipped


TOPIC = Topic("/big", "geometry_msgs/msg/WrenchStamped", "cdr")


def test_unread_messages_are_bounded_by_their_size():
    """50,000 messages of a megabyte would be 50 GB."""
    inbox = Inbox()
    for _ in range(70):
        inbox.put((TOPIC, 1, bytes(10**6)))
    assert inbox.skipped == {QUEUE_FULL: 20}
    assert len(inbox.take(0.0)) == 50
    inbox.put((TOPIC, 1, b""))
    assert len(inbox.take(0.0)) == 1


def test_what_comes_before_topics_are_chosen_is_bounded():
    """A sender of gigabytes a second, none of it a wrench, for five seconds."""
    parts = []

    class Loud(Transport):
        def connect(self, wants): ...

        def close(self): ...

        def receive(self, timeout):
            parts.append(len(parts))
            return [(TOPIC, len(parts), bytes(10**6))] * 10

    source = RosSource("loud", Request(), Loud("loud"))
    with pytest.raises(InputError):
        source.open()
    assert len(parts) == 5


def test_large_frames_are_received_one_at_a_time(monkeypatch):
    """A thousand frames of 16 MB would be 16 GB."""
    pytest.importorskip("websockets")

    class Connection:
        received = 0

        def recv(self, timeout):
            self.received += 1
            return MESSAGE.pack(1, 7, 1) + bytes(16_000_000 if self.received % 2 else 9)

    transport, connection = FoxgloveTransport("ws://localhost:1"), Connection()
    monkeypatch.setattr(transport, "_connection", connection)
    monkeypatch.setattr(transport, "_channels", {7: TOPIC})
    assert len(transport.receive(0.0)) == 1
    assert len(transport.receive(0.0)) == 2
    assert connection.received == 3

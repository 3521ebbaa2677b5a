"""ROS messages as they come give what the bag reader finds in the same messages."""

from collections import Counter

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bag_messages import (
    EPOCH,
    STEP,
    N,
    imu,
    joints,
    pose,
    read_bag,
    stamp,
    transform,
    wrench,
    write,
)
from bags import serialised
from hefting.core.errors import InputError
from hefting.logs.ros.source import Topic
from hefting.sources import MAX_MESSAGE, TOO_LARGE, UNREADABLE, Request
from hefting.sources.ros_decoding import UNFITTING, RosDecoder

TURNS = Rotation.random(N, rng=np.random.default_rng(3)).as_quat()
PLACES = np.random.default_rng(5).normal(size=(N, 3))
MOUNT = ("flange", "sensor", [0, 0, 0.1], [0, 0, 0, 1])


def messages(entries, topics=None):
    """Entries of a bag as messages of a transport."""
    topics = {} if topics is None else topics
    found = []
    for name, kind, logged, fields in entries:
        kind = kind.replace("/", "/msg/")
        topic = topics.setdefault((name, kind), Topic(name, kind, "cdr"))
        data = fields if isinstance(fields, bytes) else serialised(kind, fields)
        found.append((topic, logged, data))
    return found


def decoded(entries, batch=3, first=60, request=Request()):  # noqa: B008
    """All samples by stream: time, then values; and the decoder."""
    decoder = RosDecoder("a robot", request, Counter())
    everything = messages(entries)
    samples = decoder.choose(everything[:first])
    assert samples is not None
    for k in range(first, len(everything), batch):
        samples += decoder.decode(everything[k : k + batch])
    found: dict[str, list] = {}
    for each in samples:
        rows = np.column_stack([each.time - EPOCH * 1e-9, each.values])
        found.setdefault(each.stream, []).append(rows)
    return {name: np.concatenate(parts) for name, parts in found.items()}, decoder


def agree(found, folder, entries, **options) -> bool:
    """Whether the bag reader finds the same."""
    recording = read_bag(write(folder, "mcap", entries), **options)
    assert set(found) == set(recording.streams)
    for name, stream in recording.streams.items():
        rows = found[name]
        # stamps since 1970 in seconds are multiples of 2.4e-7
        assert rows[:, 0] - rows[0, 0] == pytest.approx(
            stream.time - stream.time[0], abs=5e-7
        )
        assert rows[:, 1:] == pytest.approx(stream.values, abs=1e-12)
    return True


def chain(k, moving=True):
    """World -> arm -> flange -> sensor: two links move, one is static."""
    i = k if moving else 0
    return transform(
        k,
        ("world", "arm", PLACES[i], TURNS[i]),
        ("arm", "flange", PLACES[-i - 1], TURNS[-i - 1]),
    )


def with_tf(moving=True):
    entries = [transform(0, MOUNT, topic="/tf_static")]
    for k in range(N):
        entries += [chain(k, moving), wrench(k)]
    return entries


@pytest.mark.parametrize("batch", [1, 2, 7, 40])
def test_pose_topic(batch, tmp_path):
    entries = [each for k in range(N) for each in (wrench(k), pose(k), imu(k))]
    found, decoder = decoded(entries, batch)
    assert agree(found, tmp_path, entries)
    said = [message.code for message in decoder.chosen]
    assert said[:3] == ["wrench-source", "pose-source", "imu-source"]
    assert not decoder.skipped


@pytest.mark.parametrize("batch", [1, 2, 7, 40])
def test_poses_of_a_chain_of_transforms(batch, tmp_path):
    found, decoder = decoded(with_tf(), batch, first=30)
    assert agree(found, tmp_path, with_tf())
    assert not decoder.skipped


def test_a_robot_that_stands_still_has_poses():
    """In a bag a link that never moves has one pose; a stream goes on."""
    found, _ = decoded(with_tf(moving=False), batch=2, first=30)
    assert len(found["orientation"]) == len(found["wrench"]) == N
    assert np.ptp(found["orientation"][:, 1:], axis=0).max() < 1e-12


def test_links_are_kept_no_longer_than_needed():
    _, decoder = decoded(with_tf() * 1, batch=1, first=30)
    kept = [series for each in decoder._tf.all() for series in each.series.values()]
    assert len(kept) == 3
    assert max(map(len, kept)) <= 12


def test_joints_of_the_arm_in_the_order_of_its_first_message():
    """A gripper says its joints on the same topic, and the arm's change places."""
    entries = []
    for k in range(N):
        names, angles = ["a", "b", "c"], [k, 10.0 + k, 20.0 + k]
        if k > 30:
            names, angles = names[::-1], angles[::-1]
        entries += [
            wrench(k),
            joints(k, names, position=np.array(angles)),
            joints(k, ["finger"], position=np.array([0.04])),
        ]
    found, _ = decoded(entries, batch=5)
    expected = np.arange(N)[:, None] + np.array([0.0, 10.0, 20.0])
    assert np.array_equal(found["joint_positions"][:, 1:], expected)


def test_a_rival_that_begins_later_is_not_taken():
    entries = [each for k in range(N) for each in (wrench(k), pose(k))]
    entries += [wrench(k, topic="/other") for k in range(N)]
    found, _ = decoded(entries, batch=4)
    assert len(found["wrench"]) == N


def test_topics_that_could_both_be_meant_are_listed():
    entries = [each for k in range(9) for each in (wrench(k), pose(k))]
    both = [*entries, *(wrench(k, topic="/other") for k in range(9))]
    decoder = RosDecoder("a robot", Request(), Counter())
    with pytest.raises(InputError, match=r"/ft/wrench .*/other .*`wrench_topic`"):
        decoder.choose(messages(both))
    named = Request(topics={"wrench": "/other"})
    assert RosDecoder("a robot", named, Counter()).choose(messages(both))


def test_nothing_is_chosen_before_there_are_poses():
    decoder = RosDecoder("a robot", Request(), Counter())
    assert decoder.choose(messages([wrench(k) for k in range(9)])) is None
    assert decoder.choose(messages([pose(k) for k in range(9)])) is None


@pytest.mark.parametrize(
    ("offered", "sending", "words"),
    [
        ([], [], ("offers no wrench", "no topics")),
        ([pose(0)], [pose(0)], ("offers no wrench", "/pose (geometry_msgs/msg/P")),
        ([wrench(0), pose(0)], [pose(0)], ("nothing arrives on /ft/wrench",)),
        ([wrench(0)], [wrench(0)], ("no orientation and no joint positions",)),
    ],
)
def test_what_is_missing_is_told(offered, sending, words):
    decoder = RosDecoder("a robot", Request(), Counter())
    known: dict = {}
    topics = [topic for topic, _, _ in messages(offered, known)]
    error = decoder.missing(topics, messages(sending, known))
    for word in words:
        assert word in str(error)


def test_a_topic_that_is_not_there_is_told_with_those_that_are():
    named = Request(topics={"wrench": "/wrist"})
    decoder = RosDecoder("a robot", named, Counter())
    topics = [topic for topic, _, _ in messages([wrench(0)])]
    error = decoder.missing(topics, [])
    assert "no topic '/wrist'" in str(error)
    assert "/ft/wrench" in str(error)


@pytest.mark.parametrize(
    "topic",
    [
        Topic("/wrench", "geometry_msgs/msg/WrenchStamped", "protobuf"),
        Topic("/wrench", "acme_msgs/msg/Force", "cdr"),
    ],
)
def test_a_schema_that_is_not_understood_is_told(topic):
    decoder = RosDecoder("a robot", Request(topics={"wrench": "/wrench"}), Counter())
    with pytest.raises(InputError, match=r"the schema of /wrench .* not understood"):
        decoder.wants(topic)


def test_bad_messages_are_counted_and_the_others_kept():
    """Garbage, a huge message, a value that is not finite, and another frame."""
    entries = [each for k in range(N) for each in (wrench(k), pose(k))]
    bad = [
        (*wrench(0)[:3], b"\0\1garbage"),
        (*wrench(0)[:3], bytes(MAX_MESSAGE + 1)),
        (*wrench(40)[:3], wrench(40)[3] | {"wrench.force": [np.nan, 0, 0]}),
        pose(40, frame="elsewhere"),
    ]
    found, decoder = decoded([*entries[:70], *bad, *entries[70:]], batch=30)
    assert decoder.skipped == {
        UNREADABLE: 1,
        TOO_LARGE: 1,
        "values that are not finite": 1,
        UNFITTING: 1,
    }
    assert len(found["wrench"]) == len(found["orientation"]) == N


@pytest.mark.parametrize("with_chain", [True, False])
def test_a_clock_that_is_set_back_is_followed(with_chain):
    """An hour back in the middle: nothing is lost, and stamps are as sent."""

    def back(entry):
        topic, kind, logged, fields = entry
        hour = 3600 * 10**9
        links = fields.get("transforms")
        if links:
            fields = {"transforms": [x | {"stamp": x["stamp"] - hour} for x in links]}
        else:
            fields = fields | {"stamp": fields["stamp"] - hour}
        return topic, kind, logged - hour, fields

    first = [transform(0, MOUNT, topic="/tf_static")] if with_chain else []
    later = []
    for k in range(N):
        both = [chain(k) if with_chain else pose(k), wrench(k)]
        (first if k < N // 2 else later).extend(both)
    found, decoder = decoded([*first, *map(back, later)], batch=5, first=30)
    assert len(found["wrench"]) == len(found["orientation"]) == N
    jump = np.diff(found["orientation"][:, 0]).min()
    assert jump == pytest.approx(STEP * 1e-9 - 3600, abs=1e-6)
    assert not decoder.skipped


def test_stamps_are_read_to_the_last_digit():
    entries = [each for k in range(N) for each in (wrench(k), pose(k))]
    decoder = RosDecoder("a robot", Request(), Counter())
    samples = decoder.choose(messages(entries))
    assert samples is not None
    assert samples[0].stream in ("wrench", "orientation", "position")
    exact = [stamp(k) / 10**9 for k in range(N)]
    for each in samples:
        # half a unit in the last place of 1.7e9 s
        assert each.time == pytest.approx(exact, abs=1.2e-7, rel=0)

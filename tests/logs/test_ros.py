"""Bags as logs: topics found by type, frames composed, clocks tidied; each bad input is
one clear line.

The bags are written by `rosbags`, an independent implementation of the formats. About 5
s.
"""

import sys

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

from bag_messages import (
    FORCE,
    POSE,
    POSES,
    STEP,
    WRENCH,
    N,
    basic,
    imu,
    pose,
    read,
    stamp,
    transform,
    wrench,
)
from bags import (
    FORMATS,
    ROS1,
    ROS2,
    mcap,
    mcap_message,
    mcap_topic,
    message,
    serialised,
    write,
)
from hefting.core.errors import InputError, MissingDependencyError
from hefting.logs.ros import read_bag
from hefting.logs.ros.layout import lay_out, standard_definitions
from hefting.logs.ros_bag import is_bag


@pytest.mark.parametrize("form", FORMATS)
def test_every_container_gives_the_same_numbers(tmp_path, form):
    path = write(tmp_path, form, basic())
    got = read_bag(path)
    assert is_bag(path)
    assert set(got.streams) == {"position", "orientation", "wrench"}
    assert (got["wrench"].values == FORCE).all()
    assert (got["position"].values == POSES[:, :3]).all()
    # quaternions are normalised once more on the way into a recording
    np.testing.assert_allclose(got["orientation"].values, POSES[:, 3:], atol=5e-16)
    assert (got["wrench"].time == np.arange(N) * STEP / 1e9).all()
    assert not got.warnings
    assert (
        got.notes[0]
        == "wrench from /ft/wrench (geometry_msgs/msg/WrenchStamped, frame sensor)"
    )
    assert got.source == str(path)


@pytest.mark.parametrize(
    ("ros1", "little_endian"), [(True, True), (False, True), (False, False)]
)
def test_layouts_agree_with_the_deserialisers_of_rosbags(ros1, little_endian):
    """Every number and text of each type, for texts and sequences of many lengths."""
    rng = np.random.default_rng(2)
    store = ROS1 if ros1 else ROS2
    encoding = "ros1" if ros1 else "cdr"
    kinds = [
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "nav_msgs/msg/Odometry",
        "sensor_msgs/msg/Imu",
    ]
    for trial in range(60):
        kind = (*kinds, "sensor_msgs/msg/JointState", "tf2_msgs/msg/TFMessage")[
            trial % 5
        ]
        n, label = int(rng.integers(0, 5)), "é" * int(rng.integers(0, 9))
        fields = {"frame": label} if trial % 5 < 4 else {}
        if trial % 5 == 1:
            fields |= {
                "child_frame_id": label[1:],
                "pose.pose.position": rng.normal(size=3),
            }
        if trial % 5 == 3:
            fields |= {
                "name": [label[:i] for i in range(n)],
                "velocity": rng.normal(size=n),
                "effort": np.ones(1),
            }
        if trial % 5 == 4:
            fields = {
                "transforms": [
                    {"frame": label, "transform.rotation": rng.normal(size=4)}
                    for _ in range(n)
                ]
            }
        data = serialised(kind, fields, ros1, little_endian)
        message = (
            store.deserialize_ros1(data, kind)
            if ros1
            else store.deserialize_cdr(data, kind)
        )
        layout = lay_out(data, kind, standard_definitions(encoding), encoding)
        table = np.frombuffer(data, np.uint8)[None]

        def value(path, message=message):
            for part in path.split("."):
                message = (
                    message[int(part)] if part.isdigit() else getattr(message, part)
                )
            return message

        assert len(layout.numbers) > 2 or (trial % 5 == 4 and n == 0)
        for path in layout.numbers:
            assert np.array_equal(
                layout.read(table, path)[0], np.atleast_1d(value(path))
            ), path
        for path, found in layout.texts.items():
            assert found == value(path)


def test_tf_is_composed_along_the_chain(tmp_path):
    """Against products of matrices; the slow link lies on its own stamps at every
    fourth of the fast one's."""
    rng = np.random.default_rng(8)
    angle = rng.uniform(-2, 2, N)
    static = Rotation.random(rng=rng)
    axis = np.array([0.6, 0.0, 0.8])
    entries = [
        transform(
            0, ("tool", "ft", (0.1, 0.2, 0.3), static.as_quat()), topic="/tf_static"
        )
    ]
    turn = [Rotation.from_rotvec(a * axis) for a in angle]
    base = [Rotation.from_euler("z", 0.01 * k) for k in range(N)]
    for k in range(N):
        entries.append(wrench(k, frame="ft"))
        entries.append(
            transform(k, ("/base", "tool", (k * 1e-3, 0, 1), turn[k].as_quat()))
        )
        if k % 4 == 0:  # turns evenly and moves evenly: between its samples too
            entries.append(
                transform(
                    k,
                    ("map", "base", (0, k * 1e-3, 0), base[k].as_quat()),
                    ("map", "x", *[(0,) * 4] * 2),
                )
            )
    got = read(tmp_path, entries)
    last = 4 * ((N - 1) // 4)
    assert len(got["orientation"]) == last + 1, "no extrapolation beyond the slow link"
    assert any(
        "orientation and position from tf: map -> base -> tool -> ft" in note
        for note in got.notes
    )
    for k in range(last + 1):
        expected = base[k] * turn[k] * static
        position = turn[k].apply((0.1, 0.2, 0.3)) + np.array((k * 1e-3, 0, 1))
        position = base[k].apply(position) + np.array((0, k * 1e-3, 0))
        # a float of nanoseconds, and a slerp of small angles
        assert (
            expected.inv() * Rotation.from_quat(got["orientation"].values[k])
        ).magnitude() < 1e-9
        np.testing.assert_allclose(got["position"].values[k], position, atol=1e-9)
    seen_from_base = read_bag(
        tmp_path / "bare-mcap" / "bare-mcap.mcap",
        world_frame="base",
        sensor_frame="tool",
    )
    np.testing.assert_allclose(
        seen_from_base["position"].values[:, 0], np.arange(N) * 1e-3, atol=1e-12
    )
    assert any(
        "says it is in frame ft" in warning for warning in seen_from_base.warnings
    )
    from_tool = read_bag(
        tmp_path / "bare-mcap" / "bare-mcap.mcap",
        world_frame="tool",
        sensor_frame="base",
    )
    inverse = turn[5].inv()
    np.testing.assert_allclose(
        from_tool["position"].values[5], -inverse.apply((5e-3, 0, 1)), atol=1e-12
    )
    for options, listed in (
        ({"world_frame": "mop"}, "did you mean 'map'"),
        ({"sensor_frame": "q"}, "base, ft, map"),
    ):
        with pytest.raises(InputError, match=listed):
            read_bag(tmp_path / "bare-mcap" / "bare-mcap.mcap", **options)


def test_no_link_is_interpolated_across_a_long_gap(tmp_path):
    still = (0, 0, 0, 1)
    entries = basic(
        lambda k: wrench(k, frame="ft"),
        lambda k: transform(k, ("a", "ft", (k, 0, 0), still)),
    )
    entries += [
        transform(k, ("w", "a", (0, k, 0), still))
        for k in range(0, N, 2)
        if not 20 < k < 44
    ]
    got = read(tmp_path, entries)
    kept = [*range(21), *range(44, 59)]
    np.testing.assert_allclose(
        got["position"].values, [(k, k, 0) for k in kept], atol=1e-9
    )
    assert (
        "24 of 60 stamps of ft lie where another link of the chain has none"
        in got.warnings
    )


def test_poses_of_another_frame_go_through_tf_or_warn(tmp_path):
    flip = (0, 1, 0, 0)  # half a turn about y
    odometry = [
        (
            "/odom",
            "nav_msgs/Odometry",
            stamp(k),
            fields | {"child_frame_id": "flange", "stamp": stamp(k), "frame": "w"},
        )
        for k in range(N)
        for fields in [
            {"pose.pose.position": POSES[k, :3], "pose.pose.orientation": POSES[k, 3:]}
        ]
    ]
    link = transform(0, ("flange", "sensor", (0, 0, 0.1), flip), topic="/tf_static")
    got = read(tmp_path, [link, *basic(wrench), *odometry])
    rotation = Rotation.from_quat(POSES[:, 3:])
    np.testing.assert_allclose(
        got["position"].values, POSES[:, :3] + rotation.apply((0, 0, 0.1)), atol=1e-12
    )
    error = (rotation * Rotation.from_quat(flip)).inv() * Rotation.from_quat(
        got["orientation"].values
    )
    # the sine of half the angle is lost near zero
    assert error.magnitude().max() < 1e-7
    assert not got.warnings
    moved = transform(9, ("flange", "sensor", (0, 0, 0.2), flip), topic="/tf_static")
    got = read(tmp_path, [link, link, moved, *basic(wrench), *odometry], "db3-file")
    assert got.warnings == (
        "static tf flange -> sensor changes in the bag: the last one is taken",
    )
    np.testing.assert_allclose(
        got["position"].values, POSES[:, :3] + rotation.apply((0, 0, 0.2)), atol=1e-12
    )
    unlinked = read(tmp_path, [*basic(wrench), *odometry], "bare-storage.mcap")
    assert (unlinked["position"].values == POSES[:, :3]).all()
    assert "poses of flange of /odom" in unlinked.warnings[0]
    elsewhere = read(
        tmp_path, basic(wrench, lambda k: pose(k, frame="base")), "ros1.bag"
    )
    assert "taken to be the sensor's own" in elsewhere.warnings[0]


def test_types_of_one_s_own_are_read_by_the_definition_in_the_bag(tmp_path):
    definition = "std_msgs/Header header\nfloat32 gain\nstring[] labels\ngeometry_msgs/Wrench load\n"
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(definition, "my_msgs/msg/Load"))
    fields = {
        "frame": "sensor",
        "labels": ["a", "bcd"],
        "load.force": FORCE[3, :3],
        "load.torque": FORCE[3, 3:],
    }
    data = bytes(
        store.serialize_cdr(
            message(store, "my_msgs/msg/Load", fields), "my_msgs/msg/Load"
        )
    )
    poses = [
        mcap_message(
            2, stamp(k), serialised("geometry_msgs/msg/PoseStamped", pose(k)[3])
        )
        for k in range(9)
    ]
    records = lambda text: mcap(  # noqa: E731
        [
            *mcap_topic(1, "/mine", "my_msgs/msg/Load", definition=text),
            *mcap_topic(2, "/pose", "geometry_msgs/msg/PoseStamped"),
            *poses,
            mcap_message(1, stamp(3), data),
        ]
    )
    (tmp_path / "mine.mcap").write_bytes(records(definition))
    with pytest.raises(
        InputError, match=r"holds no wrench, only /mine \(my_msgs/msg/Load\), /pose"
    ):
        read_bag(tmp_path / "mine.mcap")
    got = read_bag(tmp_path / "mine.mcap", wrench_topic="mine")
    assert (got["wrench"].values == FORCE[3]).all()
    (tmp_path / "lost.mcap").write_bytes(records(""))
    with pytest.raises(
        InputError,
        match="no message definition of my_msgs/msg/Load, the type of /mine; record as",
    ):
        read_bag(tmp_path / "lost.mcap", wrench_topic="/mine")
    (tmp_path / "part.mcap").write_bytes(records("my_msgs/Inner inner\n"))
    with pytest.raises(InputError, match="no message definition of my_msgs/msg/Inner"):
        read_bag(tmp_path / "part.mcap", wrench_topic="/mine")


def test_mcap_without_chunks_with_ros_1_messages_and_with_json(tmp_path):
    kinds = {1: ("/w", WRENCH, wrench), 2: ("/p", POSE, pose)}
    for encoding, language in (("ros1", "ros1msg"), ("json", "jsonschema")):
        records = [
            r
            for n, (topic, kind, _) in kinds.items()
            for r in mcap_topic(n, topic, kind, encoding, language)
        ]
        for k in range(5):
            for n, (_, kind, make) in kinds.items():
                data = (
                    serialised(kind.replace("/", "/msg/"), make(k)[3], ros1=True)
                    if encoding == "ros1"
                    else b"{}"
                )
                records.append(mcap_message(n, stamp(k), data))
        (tmp_path / f"{encoding}.mcap").write_bytes(mcap(records))
    assert (read_bag(tmp_path / "ros1.mcap")["wrench"].values == FORCE[:5]).all()
    with pytest.raises(
        InputError,
        match=r"messages of /w \(geometry_msgs/msg/WrenchStamped, json\) are encoded as",
    ):
        read_bag(tmp_path / "json.mcap")


def bad(what):
    two = basic(wrench, pose, lambda k: wrench(k, "/other/wrench"))

    def link(k, parent, child):
        return transform(k, (parent, child, (k, 0, 0), (0, 0, 0, 1)))

    tf = [link(k, "a", "ft") for k in range(N)]
    tf_and_wrench = [*basic(lambda k: wrench(k, frame="ft")), *tf]
    return {
        "two wrenches": (
            two,
            {},
            r"2 topics could be the wrench: /ft/wrench .*, /other/wrench .*`wrench_topic`$",
        ),
        "two imus": (
            basic(wrench, pose, imu, lambda k: imu(k, topic="/cam")),
            {},
            "choose one with `imu_topic`, or none",
        ),
        "unknown topic": (
            basic(),
            {"wrench_topic": "/ft/wrenhc"},
            r"no topic '/ft/wrenhc' \(did you mean '/ft/wrench'",
        ),
        "wrong type": (
            basic(),
            {"wrench_topic": "/pose"},
            r"no wrench can be read from topic /pose \(geometry_msgs.*export its numbers",
        ),
        "no wrench": (
            basic(pose),
            {},
            r"only /pose \(geometry_msgs/msg/PoseStamped\); name its .* of other types",
        ),
        "two roles": (
            basic(),
            {"imu_topic": "/pose", "pose_topic": "/pose"},
            "topic /pose cannot be the imu, as",
        ),
        "no motion": (
            basic(wrench),
            {},
            "no orientation and no joint positions, only /ft/wrench.*`pose_topic`, or record",
        ),
        "no frame": (
            [*basic(lambda k: wrench(k, frame="")), *tf],
            {},
            "give `sensor_frame` one of a, ft",
        ),
        "other frame": (
            [*basic(wrench), *tf],
            {},
            "tf does not hold its frame sensor; give `sensor_frame` one of a, ft",
        ),
        "a frame that rests": (
            [*basic(lambda k: wrench(k, frame="a")), *tf],
            {},
            "in tf nothing moves between the root and a; if it is the sensor, give "
            "`world_frame` one of ft; if not, `sensor_frame` one of them",
        ),
        "mixed frames": (
            basic(lambda k: wrench(k, frame="a" if k < 7 else "b"), pose),
            {},
            "message 8: .* 'a', then 'b'",
        ),
        "clock": (
            [*basic(n=50), wrench(51, time=stamp(0) - 10**9)],
            {},
            "message 51: time goes back by 1.49 s",
        ),
        "no overlap": (
            [*basic(wrench), *[pose(k + 100, values=POSES[k]) for k in range(N)]],
            {},
            "no time in common",
        ),
        "two parents": (
            [*tf_and_wrench, link(1, "b", "ft")],
            {},
            "frame ft has two parents, a and b",
        ),
        "a circle": ([*tf_and_wrench, link(1, "ft", "a")], {}, "in a circle"),
        "no quaternion": (
            [*tf_and_wrench, transform(70, ("a", "ft", (0, 0, 0), (0, 0, 0, 0)))],
            {},
            "message 61: the quaternion has norm 0, not 1",
        ),
    }[what]


@pytest.mark.parametrize(
    "what",
    [
        *(
            "two wrenches",
            "two imus",
            "unknown topic",
            "wrong type",
            "two roles",
            "no wrench",
            "no motion",
            "no frame",
        ),
        *(
            "other frame",
            "mixed frames",
            "clock",
            "no overlap",
            "two parents",
            "a circle",
            "no quaternion",
        ),
    ],
)
def test_what_cannot_be_read_without_guessing_is_one_clear_line(tmp_path, what):
    entries, options, match = bad(what)
    with pytest.raises(InputError, match=match) as caught:
        read(tmp_path, entries, **options)
    assert "\n" not in str(caught.value)


def test_without_rosbags_the_command_that_installs_it_is_told(tmp_path, monkeypatch):
    path = write(tmp_path, "ros1.bag", basic())
    monkeypatch.setitem(sys.modules, "rosbags.typesys", None)
    standard_definitions.cache_clear()
    with pytest.raises(MissingDependencyError, match=r"pip install 'hefting\[ros\]'"):
        read_bag(path)


def test_a_choice_settles_two_candidates(tmp_path):
    path = write(tmp_path, "mcap", bad("two wrenches")[0])
    assert (
        read_bag(path, wrench_topic="other/wrench")
        .notes[0]
        .startswith("wrench from /other/wrench")
    )
    path = write(tmp_path, "db3", bad("two imus")[0])
    assert not read_bag(path, imu_topic="none").has("gyroscope")
    assert read_bag(path, imu_topic="/cam").has("gyroscope")

"""Bags as logs: topics found by type, frames composed, clocks tidied; each bad input is one clear line.

The bags are written by `rosbags`, an independent implementation of the formats. About 5 s.
"""

import sys

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

from bags import FORMATS, ROS1, ROS2, mcap, mcap_message, mcap_topic, message, serialised, write
from hefting.errors import InputError, MissingDependencyError
from hefting.logs.ros import is_bag, read_bag
from hefting.logs.ros.layout import lay_out, standard_definitions

WRENCH, POSE = "geometry_msgs/WrenchStamped", "geometry_msgs/PoseStamped"
EPOCH = 1_700_000_000_123_456_789
STEP = 10_000_000
N = 60
RNG = np.random.default_rng(4)
FORCE = RNG.normal(size=(N, 6))
POSES = np.concatenate([RNG.normal(size=(N, 3)), Rotation.random(N, rng=RNG).as_quat()], axis=1)


def stamp(k: int) -> int:
    return EPOCH + k * STEP


def wrench(k: int, topic="/ft/wrench", frame="sensor", time=None, kind=WRENCH):
    fields = {"stamp": stamp(k) if time is None else time, "frame": frame}
    return topic, kind, stamp(k), {**fields, "wrench.force": FORCE[k, :3], "wrench.torque": FORCE[k, 3:]}


def pose(k: int, topic="/pose", frame="world", values=None):
    values = POSES[k] if values is None else values
    fields = {"stamp": stamp(k), "frame": frame, "pose.position": values[:3], "pose.orientation": values[3:]}
    return topic, POSE, stamp(k), fields


def transform(k: int, *links, topic="/tf"):
    """A tf message of links (parent, child, position, quaternion)."""
    fields = [
        {"stamp": stamp(k), "frame": p, "child_frame_id": c, "transform.translation": x, "transform.rotation": q}
        for p, c, x, q in links
    ]
    return topic, "tf2_msgs/TFMessage", stamp(k), {"transforms": fields}


def joints(k: int, names, topic="/joint_states", **fields):
    return topic, "sensor_msgs/JointState", stamp(k), {"stamp": stamp(k), "name": list(names), **fields}


def imu(k: int, frame="sensor", topic="/imu", gyro=(1, 2, 3), accel=(4, 5, 6), **fields):
    fields = {"stamp": stamp(k), "frame": frame, "angular_velocity": gyro, "linear_acceleration": accel, **fields}
    return topic, "sensor_msgs/Imu", stamp(k), fields


def twist(k: int, frame: str, values):
    fields = {"stamp": stamp(k), "frame": frame, "twist.linear": values[:3], "twist.angular": values[3:]}
    return "/twist", "geometry_msgs/TwistStamped", stamp(k), fields


def basic(*makers, n=N):
    makers = makers or (wrench, pose)
    return [make(k) for k in range(n) for make in makers]


def read(folder, entries, form="bare.mcap", **options):
    return read_bag(write(folder, form, entries), **options)


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
    assert got.notes[0] == "wrench from /ft/wrench (geometry_msgs/msg/WrenchStamped, frame sensor)"
    assert got.source == str(path)


@pytest.mark.parametrize(("ros1", "little_endian"), [(True, True), (False, True), (False, False)])
def test_layouts_agree_with_the_deserialisers_of_rosbags(ros1, little_endian):
    """Every number and text of each type, for texts and sequences of many lengths."""
    rng = np.random.default_rng(2)
    store = ROS1 if ros1 else ROS2
    encoding = "ros1" if ros1 else "cdr"
    kinds = ["geometry_msgs/msg/PoseWithCovarianceStamped", "nav_msgs/msg/Odometry", "sensor_msgs/msg/Imu"]
    for trial in range(60):
        kind = (*kinds, "sensor_msgs/msg/JointState", "tf2_msgs/msg/TFMessage")[trial % 5]
        n, label = int(rng.integers(0, 5)), "é" * int(rng.integers(0, 9))
        fields = {"frame": label} if trial % 5 < 4 else {}
        if trial % 5 == 1:
            fields |= {"child_frame_id": label[1:], "pose.pose.position": rng.normal(size=3)}
        if trial % 5 == 3:
            fields |= {"name": [label[:i] for i in range(n)], "velocity": rng.normal(size=n), "effort": np.ones(1)}
        if trial % 5 == 4:
            fields = {"transforms": [{"frame": label, "transform.rotation": rng.normal(size=4)} for _ in range(n)]}
        data = serialised(kind, fields, ros1, little_endian)
        message = store.deserialize_ros1(data, kind) if ros1 else store.deserialize_cdr(data, kind)
        layout = lay_out(data, kind, standard_definitions(encoding), encoding)
        table = np.frombuffer(data, np.uint8)[None]

        def value(path, message=message):
            for part in path.split("."):
                message = message[int(part)] if part.isdigit() else getattr(message, part)
            return message

        assert len(layout.numbers) > 2 or (trial % 5 == 4 and n == 0)
        for path in layout.numbers:
            assert np.array_equal(layout.read(table, path)[0], np.atleast_1d(value(path))), path
        for path, found in layout.texts.items():
            assert found == value(path)


def test_tf_is_composed_along_the_chain(tmp_path):
    """Against products of matrices; the slow link lies on its own stamps at every fourth of the fast one's."""
    rng = np.random.default_rng(8)
    angle = rng.uniform(-2, 2, N)
    static = Rotation.random(rng=rng)
    axis = np.array([0.6, 0.0, 0.8])
    entries = [transform(0, ("tool", "ft", (0.1, 0.2, 0.3), static.as_quat()), topic="/tf_static")]
    turn = [Rotation.from_rotvec(a * axis) for a in angle]
    base = [Rotation.from_euler("z", 0.01 * k) for k in range(N)]
    for k in range(N):
        entries.append(wrench(k, frame="ft"))
        entries.append(transform(k, ("/base", "tool", (k * 1e-3, 0, 1), turn[k].as_quat())))
        if k % 4 == 0:  # turns evenly and moves evenly: between its samples too
            entries.append(
                transform(k, ("map", "base", (0, k * 1e-3, 0), base[k].as_quat()), ("map", "x", *[(0,) * 4] * 2))
            )
    got = read(tmp_path, entries)
    last = 4 * ((N - 1) // 4)
    assert len(got["orientation"]) == last + 1, "no extrapolation beyond the slow link"
    assert any("orientation and position from tf: map -> base -> tool -> ft" in note for note in got.notes)
    for k in range(last + 1):
        expected = base[k] * turn[k] * static
        position = turn[k].apply((0.1, 0.2, 0.3)) + np.array((k * 1e-3, 0, 1))
        position = base[k].apply(position) + np.array((0, k * 1e-3, 0))
        # a float of nanoseconds, and a slerp of small angles
        assert (expected.inv() * Rotation.from_quat(got["orientation"].values[k])).magnitude() < 1e-9
        np.testing.assert_allclose(got["position"].values[k], position, atol=1e-9)
    seen_from_base = read_bag(tmp_path / "bare-mcap" / "bare-mcap.mcap", world_frame="base", sensor_frame="tool")
    np.testing.assert_allclose(seen_from_base["position"].values[:, 0], np.arange(N) * 1e-3, atol=1e-12)
    assert any("says it is in frame ft" in warning for warning in seen_from_base.warnings)
    from_tool = read_bag(tmp_path / "bare-mcap" / "bare-mcap.mcap", world_frame="tool", sensor_frame="base")
    inverse = turn[5].inv()
    np.testing.assert_allclose(from_tool["position"].values[5], -inverse.apply((5e-3, 0, 1)), atol=1e-12)
    for options, listed in (({"world_frame": "mop"}, "did you mean 'map'"), ({"sensor_frame": "q"}, "base, ft, map")):
        with pytest.raises(InputError, match=listed):
            read_bag(tmp_path / "bare-mcap" / "bare-mcap.mcap", **options)


def test_no_link_is_interpolated_across_a_long_gap(tmp_path):
    still = (0, 0, 0, 1)
    entries = basic(lambda k: wrench(k, frame="ft"), lambda k: transform(k, ("a", "ft", (k, 0, 0), still)))
    entries += [transform(k, ("w", "a", (0, k, 0), still)) for k in range(0, N, 2) if not 20 < k < 44]
    got = read(tmp_path, entries)
    kept = [*range(21), *range(44, 59)]
    np.testing.assert_allclose(got["position"].values, [(k, k, 0) for k in kept], atol=1e-9)
    assert "24 of 60 stamps of ft lie where another link of the chain has none" in got.warnings


def test_poses_of_another_frame_go_through_tf_or_warn(tmp_path):
    flip = (0, 1, 0, 0)  # half a turn about y
    odometry = [
        ("/odom", "nav_msgs/Odometry", stamp(k), fields | {"child_frame_id": "flange", "stamp": stamp(k), "frame": "w"})
        for k in range(N)
        for fields in [{"pose.pose.position": POSES[k, :3], "pose.pose.orientation": POSES[k, 3:]}]
    ]
    link = transform(0, ("flange", "sensor", (0, 0, 0.1), flip), topic="/tf_static")
    got = read(tmp_path, [link, *basic(wrench), *odometry])
    rotation = Rotation.from_quat(POSES[:, 3:])
    np.testing.assert_allclose(got["position"].values, POSES[:, :3] + rotation.apply((0, 0, 0.1)), atol=1e-12)
    error = (rotation * Rotation.from_quat(flip)).inv() * Rotation.from_quat(got["orientation"].values)
    assert error.magnitude().max() < 1e-7  # the sine of half the angle is lost near zero
    assert not got.warnings
    unlinked = read(tmp_path, [*basic(wrench), *odometry], "bare-storage.mcap")
    assert (unlinked["position"].values == POSES[:, :3]).all()
    assert "poses of flange of /odom" in unlinked.warnings[0]
    elsewhere = read(tmp_path, basic(wrench, lambda k: pose(k, frame="base")), "ros1.bag")
    assert "taken to be the sensor's own" in elsewhere.warnings[0]


def test_imu_axes_and_lever_arm(tmp_path):
    turned = Rotation.from_euler("x", 90, degrees=True)
    for name, place in (("near", (0.001, 0, 0.003)), ("far", (0, 0.08, 0))):
        (tmp_path / name).mkdir()
        link = transform(0, ("sensor", "imu", place, turned.as_quat()), topic="/tf_static")
        got = read(tmp_path / name, [link, *basic(wrench, pose, lambda k: imu(k, "imu"))])
        np.testing.assert_allclose(got["gyroscope"].values, [[1, -3, 2]] * N, atol=1e-14)
        assert got.has("accelerometer") == (name == "near")
        if name == "near":
            np.testing.assert_allclose(got["accelerometer"].values, [[4, -6, 5]] * N, atol=1e-14)
        else:
            assert got.warnings == ("accelerometer of /imu left out: it is 80 mm from the origin of sensor",)
    alone = read(tmp_path, basic(wrench, pose, lambda k: imu(k, "elsewhere")), "db3")
    assert "nothing links frame 'elsewhere' of /imu" in alone.warnings[0]
    assert (alone["accelerometer"].values == [[4, 5, 6]] * N).all()
    unmeasured = lambda k: imu(k, linear_acceleration_covariance=np.array([-1.0] + 8 * [0]))  # noqa: E731
    assert not read(tmp_path, basic(wrench, pose, unmeasured), "mcap").has("accelerometer")


def test_twist_is_turned_from_the_sensor_s_axes_and_left_out_from_others(tmp_path):
    values = np.arange(6.0)
    world = read(tmp_path, basic(wrench, pose, lambda k: twist(k, "world", values)), "db3")
    assert (world["linear_velocity"].values == values[:3]).all()
    sensor = read(tmp_path, basic(wrench, pose, lambda k: twist(k, "sensor", values)), "mcap")
    expected = Rotation.from_quat(POSES[:, 3:]).apply(values[3:])
    np.testing.assert_allclose(sensor["angular_velocity"].values, expected, atol=1e-9)
    other = read(tmp_path, basic(wrench, pose, lambda k: twist(k, "camera", values)), "ros1.bag")
    assert not other.has("linear_velocity")
    assert "frame 'camera' is not the world's" in other.warnings[0]


def test_joints_go_by_name_and_a_gripper_is_told(tmp_path):
    def arm(k):
        order = ("b", "a") if k % 3 else ("a", "b")
        value = {"a": k * 1.0, "b": -k * 1.0}
        return joints(
            k, order, position=np.array([value[n] for n in order]), velocity=np.array([value[n] for n in order])
        )

    got = read(tmp_path, basic(wrench, arm, lambda k: joints(k, ["finger"], position=np.ones(1))))
    assert got.joint_names == ("a", "b")
    for name in ("joint_positions", "joint_velocities"):
        assert (got[name].values == np.outer(np.arange(N), (1, -1))).all()
    assert "messages of /joint_states with other joints left out: finger" in got.notes
    part = got.slice(0.1)
    assert part.joint_names == ("a", "b")


def test_stamps_are_tidied_and_what_was_done_is_told(tmp_path):
    entries = basic()
    entries += [wrench(5), wrench(6, time=stamp(5))]
    entries[20], entries[22] = entries[22], entries[20]
    entries[-10] = wrench(57, time=0)
    values = dict(wrench(58)[3], **{"wrench.force": (np.nan, 0, 0)})
    entries[-4] = ("/ft/wrench", WRENCH, stamp(58), values)
    got = read(tmp_path, [(e[0], e[1], EPOCH + 1 + i * STEP // 2, e[3]) for i, e in enumerate(entries)])
    assert len(got["wrench"]) == N + 2 - 3
    told = " | ".join(got.warnings + got.notes)
    for line in (
        "1 of 62 messages of /ft/wrench hold values that are not finite",
        "1 of 61 messages of /ft/wrench have no stamp: the times they were logged at",
        "messages of /ft/wrench came out of order",
        "1 repeated messages of /ft/wrench dropped",
        "1 messages of /ft/wrench have the stamp of the message before but other values",
    ):
        assert line in told, line
    plain = [("/w", "geometry_msgs/Wrench", stamp(k), {"force": FORCE[k, :3]}) for k in range(N)]
    unstamped = read(tmp_path, [*plain, *basic(pose)], "db3")
    assert unstamped.warnings[0] == "messages of /w have no stamp: the times they were logged at are used"
    assert (unstamped["wrench"].time == np.arange(N) * STEP / 1e9).all()


def test_types_of_one_s_own_are_read_by_the_definition_in_the_bag(tmp_path):
    definition = "std_msgs/Header header\nfloat32 gain\nstring[] labels\ngeometry_msgs/Wrench load\n"
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(definition, "my_msgs/msg/Load"))
    fields = {"frame": "sensor", "labels": ["a", "bcd"], "load.force": FORCE[3, :3], "load.torque": FORCE[3, 3:]}
    data = bytes(store.serialize_cdr(message(store, "my_msgs/msg/Load", fields), "my_msgs/msg/Load"))
    poses = [mcap_message(2, stamp(k), serialised("geometry_msgs/msg/PoseStamped", pose(k)[3])) for k in range(9)]
    records = lambda text: mcap(  # noqa: E731
        [
            *mcap_topic(1, "/mine", "my_msgs/msg/Load", definition=text),
            *mcap_topic(2, "/pose", "geometry_msgs/msg/PoseStamped"),
            *poses,
            mcap_message(1, stamp(3), data),
        ]
    )
    (tmp_path / "mine.mcap").write_bytes(records(definition))
    with pytest.raises(InputError, match=r"holds no wrench, only /mine \(my_msgs/msg/Load\), /pose"):
        read_bag(tmp_path / "mine.mcap")
    got = read_bag(tmp_path / "mine.mcap", wrench_topic="mine")
    assert (got["wrench"].values == FORCE[3]).all()
    (tmp_path / "lost.mcap").write_bytes(records(""))
    with pytest.raises(InputError, match="no message definition of my_msgs/msg/Load, the type of /mine; record as"):
        read_bag(tmp_path / "lost.mcap", wrench_topic="/mine")
    (tmp_path / "part.mcap").write_bytes(records("my_msgs/Inner inner\n"))
    with pytest.raises(InputError, match="no message definition of my_msgs/msg/Inner"):
        read_bag(tmp_path / "part.mcap", wrench_topic="/mine")


def test_mcap_without_chunks_with_ros_1_messages_and_with_json(tmp_path):
    kinds = {1: ("/w", WRENCH, wrench), 2: ("/p", POSE, pose)}
    for encoding, language in (("ros1", "ros1msg"), ("json", "jsonschema")):
        records = [r for n, (topic, kind, _) in kinds.items() for r in mcap_topic(n, topic, kind, encoding, language)]
        for k in range(5):
            for n, (_, kind, make) in kinds.items():
                data = serialised(kind.replace("/", "/msg/"), make(k)[3], ros1=True) if encoding == "ros1" else b"{}"
                records.append(mcap_message(n, stamp(k), data))
        (tmp_path / f"{encoding}.mcap").write_bytes(mcap(records))
    assert (read_bag(tmp_path / "ros1.mcap")["wrench"].values == FORCE[:5]).all()
    with pytest.raises(InputError, match=r"messages of /w \(geometry_msgs/msg/WrenchStamped, json\) are encoded as"):
        read_bag(tmp_path / "json.mcap")


def bad(what):
    two = basic(wrench, pose, lambda k: wrench(k, "/other/wrench"))
    tf = [transform(k, ("a", "ft", (k, 0, 0), (0, 0, 0, 1))) for k in range(N)]
    return {
        "two wrenches": (two, {}, r"2 topics could be the wrench: /ft/wrench .*, /other/wrench .*--wrench-topic$"),
        "two imus": (
            basic(wrench, pose, imu, lambda k: imu(k, topic="/cam")),
            {},
            "choose one with --imu-topic, or none",
        ),
        "unknown topic": (
            basic(),
            {"wrench_topic": "/ft/wrenhc"},
            r"no topic '/ft/wrenhc' \(did you mean '/ft/wrench'",
        ),
        "wrong type": (basic(), {"wrench_topic": "/pose"}, r"no wrench can be read from topic /pose \(geometry_msgs"),
        "no wrench": (basic(pose), {}, r"holds no wrench, only /pose \(geometry_msgs/msg/PoseStamped\); name its"),
        "no motion": (basic(wrench), {}, "holds no orientation and no joint positions, only /ft/wrench"),
        "no frame": ([*basic(lambda k: wrench(k, frame="")), *tf], {}, "give --sensor-frame one of a, ft"),
        "other frame": (
            [*basic(wrench), *tf],
            {},
            "tf does not hold its frame sensor; give --sensor-frame one of a, ft",
        ),
        "mixed frames": (
            basic(lambda k: wrench(k, frame="a" if k < 7 else "b"), pose),
            {},
            "message 8: .* 'a', then 'b'",
        ),
        "clock": ([*basic(n=50), wrench(51, time=stamp(0) - 10**12)], {}, "message 51: time goes back by 1000.49 s"),
        "no overlap": ([*basic(wrench), *[pose(k + 100, values=POSES[k]) for k in range(N)]], {}, "no time in common"),
        "two parents": (
            [*basic(lambda k: wrench(k, frame="ft")), *tf, transform(1, ("b", "ft", (0, 0, 0), (0, 0, 0, 1)))],
            {},
            "frame ft has two parents, a and b",
        ),
        "a circle": (
            [*basic(lambda k: wrench(k, frame="ft")), *tf, transform(1, ("ft", "a", (0, 0, 0), (0, 0, 0, 1)))],
            {},
            "in a circle",
        ),
        "no quaternion": (
            [*basic(lambda k: wrench(k, frame="ft")), *tf, transform(70, ("a", "ft", (0, 0, 0), (0, 0, 0, 0)))],
            {},
            "message 61: the quaternion has norm 0, not 1",
        ),
    }[what]


@pytest.mark.parametrize(
    "what",
    [
        *("two wrenches", "two imus", "unknown topic", "wrong type", "no wrench", "no motion", "no frame"),
        *("other frame", "mixed frames", "clock", "no overlap", "two parents", "a circle", "no quaternion"),
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
    assert read_bag(path, wrench_topic="other/wrench").notes[0].startswith("wrench from /other/wrench")
    path = write(tmp_path, "db3", bad("two imus")[0])
    assert not read_bag(path, imu_topic="none").has("gyroscope")
    assert read_bag(path, imu_topic="/cam").has("gyroscope")

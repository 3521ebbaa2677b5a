"""Bags as logs: what each role of a topic becomes, in which axes and at which times.
About 2 s."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bag_messages import (
    EPOCH,
    FORCE,
    POSES,
    STEP,
    WRENCH,
    N,
    basic,
    imu,
    joints,
    pose,
    read,
    stamp,
    transform,
    twist,
    wrench,
)
from bags import write
from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.logs.ros import messages, read_bag


def test_imu_axes_and_lever_arm(tmp_path):
    turned = Rotation.from_euler("x", 90, degrees=True)
    for name, place in (("near", (0.001, 0, 0.003)), ("far", (0, 0.08, 0))):
        (tmp_path / name).mkdir()
        link = transform(
            0, ("sensor", "imu", place, turned.as_quat()), topic="/tf_static"
        )
        got = read(
            tmp_path / name, [link, *basic(wrench, pose, lambda k: imu(k, "imu"))]
        )
        np.testing.assert_allclose(
            got["gyroscope"].values, [[1, -3, 2]] * N, atol=1e-14
        )
        assert got.has("accelerometer") == (name == "near")
        if name == "near":
            np.testing.assert_allclose(
                got["accelerometer"].values, [[4, -6, 5]] * N, atol=1e-14
            )
        else:
            assert got.warnings == (
                "accelerometer of /imu left out: it is 80 mm from the origin of sensor",
            )
    alone = read(tmp_path, basic(wrench, pose, lambda k: imu(k, "elsewhere")), "db3")
    assert "nothing links frame 'elsewhere' of /imu" in alone.warnings[0]
    assert (alone["accelerometer"].values == [[4, 5, 6]] * N).all()

    def unmeasured(k):
        return imu(k, linear_acceleration_covariance=np.array([-1.0] + 8 * [0]))

    assert not read(tmp_path, basic(wrench, pose, unmeasured), "mcap").has(
        "accelerometer"
    )


def test_twist_is_turned_from_the_sensor_s_axes_and_left_out_from_others(tmp_path):
    values = np.arange(6.0)
    world = read(
        tmp_path, basic(wrench, pose, lambda k: twist(k, "world", values)), "db3"
    )
    assert (world["linear_velocity"].values == values[:3]).all()
    sensor = read(
        tmp_path, basic(wrench, pose, lambda k: twist(k, "sensor", values)), "mcap"
    )
    expected = Rotation.from_quat(POSES[:, 3:]).apply(values[3:])
    np.testing.assert_allclose(sensor["angular_velocity"].values, expected, atol=1e-9)
    other = read(
        tmp_path, basic(wrench, pose, lambda k: twist(k, "camera", values)), "ros1.bag"
    )
    assert not other.has("linear_velocity")
    assert "frame 'camera' is not the world's" in other.warnings[0]


def test_velocities_of_odometry_are_in_its_child_frame_and_not_turned_across_gaps(
    tmp_path,
):
    """nav_msgs/Odometry: the pose is in the header's frame, the twist in
    child_frame_id."""
    values = np.arange(6.0)
    fields = {
        "child_frame_id": "sensor",
        "twist.twist.linear": values[:3],
        "twist.twist.angular": values[3:],
    }

    def odometry(k):
        return (
            "/odom",
            "nav_msgs/Odometry",
            stamp(k),
            {"stamp": stamp(k), "frame": "world", **fields},
        )

    poses = [pose(k) for k in range(N) if not 20 < k < 44]
    got = read(
        tmp_path,
        [*basic(wrench, odometry), *poses],
        pose_topic="/pose",
        twist_topic="/odom",
    )
    kept = [*range(21), *range(44, N)]
    for name, part in (
        ("linear_velocity", values[:3]),
        ("angular_velocity", values[3:]),
    ):
        np.testing.assert_allclose(
            got[name].values, Rotation.from_quat(POSES[kept, 3:]).apply(part), atol=1e-9
        )
    assert got["linear_velocity"].time.tolist() == got["orientation"].time.tolist()
    fields["child_frame_id"] = "base_link"
    other = read(
        tmp_path,
        basic(wrench, pose, odometry),
        "db3",
        pose_topic="/pose",
        twist_topic="/odom",
    )
    assert (
        "velocities of /odom left out: frame 'base_link' is not the world's"
        in other.warnings
    )


def test_of_a_wrench_that_a_controller_estimates_the_load_is_asked(tmp_path):
    def estimate(k):
        return wrench(k, "/franka_state_controller/F_ext")

    got = read(tmp_path, basic(estimate, pose))
    assert "payload-unknown" in codes(got.warnings)


def test_joints_go_by_name_and_a_gripper_is_told(tmp_path):
    def arm(k):
        order = ("b", "c", "a") if k % 3 else ("a", "b", "c")
        values = np.array(
            [{"a": k * 1.0, "b": -k * 1.0, "c": 0.5}[name] for name in order]
        )
        return joints(
            k, order, position=values, velocity=values if k < 50 else values[:2]
        )

    got = read(
        tmp_path,
        basic(wrench, arm, lambda k: joints(k, ["finger"], position=np.ones(1))),
    )
    expected = np.stack([np.arange(N), -np.arange(N), np.full(N, 0.5)], axis=1)
    assert got.joint_names == ("a", "b", "c"), "as in the first message"
    assert (got["joint_positions"].values == expected).all()
    assert (got["joint_velocities"].values == expected[:50]).all(), (
        "those of another number are left out"
    )
    assert "messages of /joint_states with other joints left out: finger" in got.notes
    part = got.slice(0.1)
    assert part.joint_names == ("a", "b", "c")


def test_stamps_are_tidied_and_what_was_done_is_told(tmp_path):
    entries = basic()
    entries += [wrench(5), wrench(6, time=stamp(5))]
    entries[20], entries[22] = entries[22], entries[20]
    entries[-10] = wrench(57, time=0)
    values = dict(wrench(58)[3], **{"wrench.force": (np.nan, 0, 0)})
    entries[-4] = ("/ft/wrench", WRENCH, stamp(58), values)
    got = read(
        tmp_path,
        [(e[0], e[1], EPOCH + 1 + i * STEP // 2, e[3]) for i, e in enumerate(entries)],
    )
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
    plain = [
        ("/w", "geometry_msgs/Wrench", stamp(k), {"force": FORCE[k, :3]})
        for k in range(N)
    ]
    unstamped = read(tmp_path, [*plain, *basic(pose)], "db3")
    assert (
        unstamped.warnings[0]
        == "messages of /w have no stamp: the times they were logged at are used"
    )
    assert (unstamped["wrench"].time == np.arange(N) * STEP / 1e9).all()


@pytest.mark.parametrize(
    ("kind", "place", "turn"),
    [
        (
            "geometry_msgs/TransformStamped",
            "transform.translation",
            "transform.rotation",
        ),
        (
            "geometry_msgs/PoseWithCovarianceStamped",
            "pose.pose.position",
            "pose.pose.orientation",
        ),
        ("geometry_msgs/QuaternionStamped", None, "quaternion"),
    ],
)
def test_every_type_of_pose_gives_its_numbers(tmp_path, kind, place, turn):
    def entry(k):
        fields = {"stamp": stamp(k), "frame": "world", turn: POSES[k, 3:]}
        return (
            "/pose",
            kind,
            stamp(k),
            fields | ({place: POSES[k, :3]} if place else {}),
        )

    got = read(tmp_path, basic(wrench, entry))
    np.testing.assert_allclose(got["orientation"].values, POSES[:, 3:], atol=5e-16)
    assert got.has("position") == bool(place)
    if place:
        assert (got["position"].values == POSES[:, :3]).all()


def test_messages_count_from_one_also_beyond_a_batch_and_times_from_the_first_of_any_stream(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(messages, "MAX_BATCH", 1000)
    got = read(tmp_path, [*basic(pose), *basic(wrench)[10:]])
    assert got["wrench"].rows.tolist() == [*range(1, N - 9)]
    assert got["orientation"].rows.tolist() == [*range(1, N + 1)]
    assert (got["orientation"].time[0], got["wrench"].time[0]) == (0, 10 * STEP / 1e9)
    assert (got["wrench"].values == FORCE[10:]).all()


def test_messages_stored_out_of_order_are_taken_in_the_order_they_were_logged(tmp_path):
    rng = np.random.default_rng(0)
    got = read(
        tmp_path, [basic(wrench, pose)[i] for i in rng.permutation(2 * N)], "ros1.bag"
    )
    assert (got["wrench"].values == FORCE).all()
    assert not got.warnings


def test_a_link_that_moves_is_not_pinned_by_a_static_one(tmp_path):
    """A driver's tf and a stray static publisher of the same link."""
    moving = lambda k: transform(k, ("world", "sensor", POSES[k, :3], POSES[k, 3:]))  # noqa: E731
    stray = transform(
        3, ("world", "sensor", (0, 0, 0), (0, 0, 0, 1)), topic="/tf_static"
    )
    got = read(tmp_path, [stray, *basic(wrench, moving)])
    assert (got["position"].values == POSES[:, :3]).all()


@pytest.mark.parametrize("earlier", [False, True])
def test_streams_without_a_time_in_common_are_left_out_or_refused(tmp_path, earlier):
    def other(k):
        return imu(k + (-2 * N if earlier else 2 * N))

    got = read(tmp_path, basic(wrench, pose, other))
    assert not got.has("gyroscope")
    assert "gyroscope and wrench have no time in common" in got.warnings[0]
    apart = [
        pose(k, values=POSES[abs(k) % N])
        for k in (range(-2 * N, -N) if earlier else range(2 * N, 3 * N))
    ]
    with pytest.raises(
        InputError,
        match=r"orientation and wrench have no time in common .* stamp both with one clock",
    ):
        read(tmp_path, [*basic(wrench), *apart], "db3")


def test_what_is_in_a_write_ahead_log_is_missed(tmp_path):
    path = write(tmp_path, "bare.db3", basic())
    path.with_name(path.name + "-wal").touch()
    assert (
        f"lacks what is still in {path.name}-wal: read up to"
        in read_bag(path).warnings[0]
    )


def test_a_frame_that_is_asked_for_answers_where_poses_are(tmp_path):
    """PoseStamped names the base's frame alone; the frame of poses that name their own
    is not answered by the sensor's."""
    messages_ = basic(wrench, lambda k: pose(k, frame="base"))
    bag = write(tmp_path, "ros1.bag", messages_)
    assert codes(read_bag(bag).warnings) == {"pose-frame-assumed"}
    assert not read_bag(bag, sensor_frame="sensor").warnings
    odometry = [
        (
            "/odom",
            "nav_msgs/Odometry",
            stamp(k),
            {"child_frame_id": "flange", "stamp": stamp(k), "frame": "w"}
            | {"pose.pose.orientation": POSES[k, 3:]},
        )
        for k in range(N)
    ]
    other = read(tmp_path, [*basic(wrench), *odometry], sensor_frame="sensor")
    assert codes(other.warnings) == {"pose-frame-assumed"}

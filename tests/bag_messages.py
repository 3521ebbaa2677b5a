"""Messages for tests of bags: N of each topic, on one clock, of random numbers."""

import numpy as np
from scipy.spatial.transform import Rotation

from bags import write
from hefting.logs.ros import read_bag

WRENCH, POSE = "geometry_msgs/WrenchStamped", "geometry_msgs/PoseStamped"
EPOCH = 1_700_000_000_123_456_789
STEP = 10_000_000
N = 60
RNG = np.random.default_rng(4)
FORCE = RNG.normal(size=(N, 6))
POSES = np.concatenate(
    [RNG.normal(size=(N, 3)), Rotation.random(N, rng=RNG).as_quat()], axis=1
)


def stamp(k: int) -> int:
    return EPOCH + k * STEP


def wrench(k: int, topic="/ft/wrench", frame="sensor", time=None, kind=WRENCH):
    fields = {"stamp": stamp(k) if time is None else time, "frame": frame}
    return (
        topic,
        kind,
        stamp(k),
        {**fields, "wrench.force": FORCE[k, :3], "wrench.torque": FORCE[k, 3:]},
    )


def pose(k: int, topic="/pose", frame="world", values=None):
    values = POSES[k] if values is None else values
    fields = {
        "stamp": stamp(k),
        "frame": frame,
        "pose.position": values[:3],
        "pose.orientation": values[3:],
    }
    return topic, POSE, stamp(k), fields


def transform(k: int, *links, topic="/tf"):
    """A tf message of links (parent, child, position, quaternion)."""
    fields = [
        {
            "stamp": stamp(k),
            "frame": p,
            "child_frame_id": c,
            "transform.translation": x,
            "transform.rotation": q,
        }
        for p, c, x, q in links
    ]
    return topic, "tf2_msgs/TFMessage", stamp(k), {"transforms": fields}


def joints(k: int, names, topic="/joint_states", **fields):
    return (
        topic,
        "sensor_msgs/JointState",
        stamp(k),
        {"stamp": stamp(k), "name": list(names), **fields},
    )


def imu(
    k: int, frame="sensor", topic="/imu", gyro=(1, 2, 3), accel=(4, 5, 6), **fields
):
    fields = {
        "stamp": stamp(k),
        "frame": frame,
        "angular_velocity": gyro,
        "linear_acceleration": accel,
        **fields,
    }
    return topic, "sensor_msgs/Imu", stamp(k), fields


def twist(k: int, frame: str, values):
    fields = {
        "stamp": stamp(k),
        "frame": frame,
        "twist.linear": values[:3],
        "twist.angular": values[3:],
    }
    return "/twist", "geometry_msgs/TwistStamped", stamp(k), fields


def basic(*makers, n=N):
    makers = makers or (wrench, pose)
    return [make(k) for k in range(n) for make in makers]


def read(folder, entries, form="bare.mcap", **options):
    return read_bag(write(folder, form, entries), **options)

"""Files of a planned motion, for robots and programs that play it: one function per
format, listed in `FORMATS`."""

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError, needing, printable
from hefting.core.files import write_atomically
from hefting.core.spatial import Array
from hefting.planning.result import Plan, reduced_speed_text, speed_text


def write_plan(plan: Plan, path: str | Path) -> None:
    """Write a planned motion atomically, in the format of the suffix.

    Raises `InputError` for an unknown suffix, for a plan that the format cannot hold,
    and for a file that cannot be written; `MissingDependencyError` for a bag without
    rosbags.

    Examples
    --------
    >>> write_plan(plan, "motion.csv")  # doctest: +SKIP
    """
    write_atomically(path, content_of(plan, path))


def content_of(plan: Plan, path: str | Path) -> bytes:
    """A plan in the format of a file's suffix; errors as of `write_plan`."""
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        what = f"'{suffix}' is not a format of a planned motion"
        raise InputError(what, path, f"use {', '.join(FORMATS)}")
    require_joints(suffix, len(plan.joints))
    return FORMATS[suffix](plan)


def require_joints(suffix: str, joints: int) -> None:
    """`InputError` if files of a suffix cannot hold a plan of this number of joints."""
    wanted = JOINTS.get(suffix, joints)
    if wanted != joints:
        what = f"{suffix} is for arms of {wanted} joints, not {joints}"
        raise InputError(what, fix="write .csv, .json or .mcap")


def _csv(plan: Plan) -> bytes:
    """The columns ``time,q1..qn`` of the canonical log: joint positions at 100 Hz, in
    the order of `Plan.joints`."""
    motion = plan.motion
    header = ["time", *(f"q{i + 1}" for i in range(len(plan.joints)))]
    rows = (
        f"{time:.9g}," + ",".join(f"{value:.9f}" for value in q)
        for time, q in zip(motion.time, motion.position, strict=True)
    )
    return "\n".join([",".join(header), *rows, ""]).encode()


def _joint_trajectory(plan: Plan) -> bytes:
    """JSON of a ``trajectory_msgs/msg/JointTrajectory``, for ``ros2 topic pub``,
    rosbridge and the joint trajectory controller."""
    return (json.dumps(_message(plan)) + "\n").encode()


def _message(plan: Plan) -> dict[str, Any]:
    """Positions, velocities and accelerations at 100 Hz, by ROS 2's names of the fields
    (https://docs.ros.org/en/rolling/p/trajectory_msgs/). The stamp of zero means at
    once."""
    motion = plan.motion
    rows = zip(
        motion.time, motion.position, motion.velocity, motion.acceleration, strict=True
    )
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(plan.joints),
        "points": [
            {
                "positions": q.tolist(),
                "velocities": v.tolist(),
                "accelerations": a.tolist(),
                "effort": [],
                "time_from_start": _duration(time),
            }
            for time, q, v, a in rows
        ],
    }


def _duration(time: float) -> dict[str, int]:
    """``builtin_interfaces/msg/Duration`` of seconds."""
    sec, nanosec = divmod(round(time * 1e9), 1_000_000_000)
    return {"sec": sec, "nanosec": nanosec}


TOPIC = "/joint_trajectory_controller/joint_trajectory"
"""Topic of ROS 2's joint trajectory controller, by its usual name."""
KIND = "trajectory_msgs/msg/JointTrajectory"
WHEN = 1_000_000_000
"""Stamp of the message in the bag [ns]: zero would mean no stamp."""


def _ros_bag(plan: Plan) -> bytes:
    """A ROS 2 bag, a bare MCAP file, with the message of the JSON file."""
    with needing("rosbags", "ros"):
        from rosbags import rosbag2
        from rosbags.typesys import Stores, get_typestore
    store = get_typestore(Stores.ROS2_HUMBLE)
    data = store.serialize_cdr(_typed(_message(plan), store.types), KIND)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan"
        writer = rosbag2.Writer(
            path, version=8, storage_plugin=rosbag2.StoragePlugin.MCAP
        )
        with writer:
            connection = writer.add_connection(TOPIC, KIND, typestore=store)
            writer.write(connection, WHEN, data)
        return (path / "plan.mcap").read_bytes()


def _typed(message: dict[str, Any], types: Any) -> Any:
    """The message as an instance of rosbags' classes."""
    time = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    points = []
    for point in message["points"]:
        when = types["builtin_interfaces/msg/Duration"](**point.pop("time_from_start"))
        values = {name: np.array(own, dtype=float) for name, own in point.items()}
        kind = types["trajectory_msgs/msg/JointTrajectoryPoint"]
        points.append(kind(**values, time_from_start=when))
    return types[KIND](
        header=types["std_msgs/msg/Header"](stamp=time, frame_id=""),
        joint_names=message["joint_names"],
        points=points,
    )


STEP = 0.008
"""[s] Time between positions: one cycle of a CB3 controller, four of an e-Series."""
LOOKAHEAD = 0.1
"""[s] Time over which the controller smooths; its default."""
GAIN = 300
"""Gain of the position controller; its default."""
APPROACH = (0.3, 0.25)
"""Acceleration [rad/s²] and speed [rad/s] of the motion to the start."""
END = 1.0
"""[rad/s²] Deceleration of the final stop, where the arm already rests."""


def _urscript(plan: Plan) -> bytes:
    """A program for controllers of Universal Robots that streams positions at 125 Hz,
    after a ``movej`` to the start.

    Source: Universal Robots, *The URScript Programming Language*, ``movej``,
    ``servoj``.
    """
    count = int(np.ceil(plan.duration / STEP - 1e-9))
    positions = plan.at(STEP * np.arange(1, count + 1)).position
    start = plan.at([0.0]).position[0]
    acceleration, speed = APPROACH
    lines = [
        *(f"# {line}" for line in _comments(plan)),
        "def hefting_plan():",
        "  def go(q):",
        f"    servoj(q, 0, 0, {STEP}, {LOOKAHEAD}, {GAIN})",
        "  end",
        f"  movej({_list(start)}, a={acceleration}, v={speed})",
        *(f"  go({_list(q)})" for q in positions),
        f"  stopj({END})",
        "end",
    ]
    return ("\n".join(lines) + "\n").encode()


def _list(q: Array) -> str:
    return "[" + ",".join(f"{value:.7f}" for value in q) + "]"


def _comments(plan: Plan) -> list[str]:
    names = ", ".join(printable(name)[:80] for name in plan.joints)
    source = printable(Path(plan.source).name)[:80]
    speed = speed_text(plan.limits.corner_speed)
    return [
        f"Motion of {plan.duration:.4g} s planned by Hefting for '{printable(plan.tip)[:80]}' of {source}",
        f"Joints: {names}; positions in rad, every {1e3 * STEP:.4g} ms",
        f"As planned it {reduced_speed_text(plan)}: at most {speed} at the object's corners",
        "The way to the start (movej) is not planned: nothing was checked along it",
        "Try it in simulation first (URSim), then at a low speed slider",
    ]


FORMATS: dict[str, Callable[[Plan], bytes]] = {
    ".csv": _csv,
    ".json": _joint_trajectory,
    ".mcap": _ros_bag,
    ".script": _urscript,
}
"""Functions that make the content of a plan's file, by its suffix."""
JOINTS = {".script": 6}
"""Number of joints for formats that need one."""

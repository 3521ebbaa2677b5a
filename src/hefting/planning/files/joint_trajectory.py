"""JSON of a ``trajectory_msgs/msg/JointTrajectory``, field by field as ROS 2 names
them.

Source: https://docs.ros.org/en/rolling/p/trajectory_msgs/. ``ros2 topic pub``,
rosbridge and the joint trajectory controller take it.
"""

import json
from typing import Any

from hefting.planning.files import MotionFile
from hefting.planning.result import Plan


def message_of(plan: Plan) -> dict[str, Any]:
    """The message as plain data. Its stamp is zero, which means at once."""
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
                "time_from_start": duration_of(time),
            }
            for time, q, v, a in rows
        ],
    }


def duration_of(time: float) -> dict[str, int]:
    """``builtin_interfaces/msg/Duration`` of seconds."""
    sec, nanosec = divmod(round(time * 1e9), 1_000_000_000)
    return {"sec": sec, "nanosec": nanosec}


def _content(plan: Plan) -> bytes:
    return (json.dumps(message_of(plan), indent=None) + "\n").encode()


FORMAT = MotionFile(".json", "trajectory_msgs/msg/JointTrajectory as JSON", _content)
"""Positions, velocities and accelerations at 100 Hz."""

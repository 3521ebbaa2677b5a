"""A ROS 2 bag, a bare MCAP file, with one ``trajectory_msgs/msg/JointTrajectory``.
Needs rosbags."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import MissingDependencyError
from hefting.planning.files import MotionFile
from hefting.planning.files.joint_trajectory import message_of
from hefting.planning.result import Plan

TOPIC = "/joint_trajectory_controller/joint_trajectory"
"""Where ROS 2's joint trajectory controller listens, by its usual name."""
KIND = "trajectory_msgs/msg/JointTrajectory"
WHEN = 1_000_000_000
"""Stamp of the message in the bag [ns]: zero would say that there is none."""


def _content(plan: Plan) -> bytes:
    try:
        from rosbags import rosbag2
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingDependencyError("rosbags", "ros") from error
    store = get_typestore(Stores.ROS2_HUMBLE)
    data = store.serialize_cdr(_message(plan, store.types), KIND)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plan"
        writer = rosbag2.Writer(
            path, version=8, storage_plugin=rosbag2.StoragePlugin.MCAP
        )
        with writer:
            connection = writer.add_connection(TOPIC, KIND, typestore=store)
            writer.write(connection, WHEN, data)
        return (path / "plan.mcap").read_bytes()


def _message(plan: Plan, types: Any) -> Any:
    plain = message_of(plan)
    time = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    points = []
    for point in plain["points"]:
        when = types["builtin_interfaces/msg/Duration"](**point.pop("time_from_start"))
        values = {name: np.array(own, dtype=float) for name, own in point.items()}
        kind = types["trajectory_msgs/msg/JointTrajectoryPoint"]
        points.append(kind(**values, time_from_start=when))
    return types[KIND](
        header=types["std_msgs/msg/Header"](stamp=time, frame_id=""),
        joint_names=plain["joint_names"],
        points=points,
    )


FORMAT = MotionFile(".mcap", "ROS 2 bag with a JointTrajectory", _content)
"""The same numbers as in the JSON file."""

"""ROS bags as a log format: which files and folders are bags, and the options for reading
one. What reads and writes them is in `hefting.logs.ros`, imported when it is needed."""

from pathlib import Path
from typing import Any

from hefting.core.recording import Recording
from hefting.logs.registry import Format

BAG_SUFFIXES = (".bag", ".mcap", ".db3")
"""File name endings that are read as bags."""

OPTIONS = {
    "wrench_topic": ("TOPIC|none", "of a bag: wrench"),
    "pose_topic": ("TOPIC|none", "of a bag: pose, odometry or tf"),
    "twist_topic": ("TOPIC|none", "of a bag: velocity"),
    "joint_topic": ("TOPIC|none", "of a bag: joint states"),
    "imu_topic": ("TOPIC|none", "of a bag: IMU"),
    "world_frame": ("NAME", "of a bag: frame of the world in tf"),
    "sensor_frame": ("NAME", "of a bag or a URDF: frame of the force-torque sensor"),
}
"""Keyword options of `hefting.logs.ros.read_bag`: what each takes, and its help."""


def is_bag(path: str | Path) -> bool:
    """Whether `path` is named like a bag or MCAP file, or is a ROS 2 bag's folder."""
    if Path(path).is_dir():
        from hefting.logs.ros.containers import storage_files

        return (Path(path) / "metadata.yaml").is_file() or bool(
            storage_files(Path(path))
        )
    return Path(path).suffix.lower() in BAG_SUFFIXES


def _read(path: str | Path, **options: Any) -> Recording:
    from hefting.logs.ros import read_bag

    return read_bag(path, **options)


def _write(recording: Recording, path: str | Path) -> tuple[str, ...]:
    from hefting.logs.ros.writing import write_bag

    return write_bag(recording, path)


FORMAT = Format(
    name="bag",
    description="ROS 1 bag, ROS 2 bag (sqlite3 or MCAP) or bare MCAP file",
    suffixes=BAG_SUFFIXES,
    help_names=("ROS bag", ".mcap"),
    read=_read,
    options=OPTIONS,
    recognise=is_bag,
    folder="ROS 2 bag",
    written=(".bag", ".mcap", ""),
    write=_write,
)
"""Messages of ROS 1 or ROS 2."""

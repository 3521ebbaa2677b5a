"""ROS bags as a log format; what reads and writes them is in `hefting.logs.ros` and
imported when it is needed."""

from pathlib import Path
from typing import Any

from hefting.core.recording import Recording
from hefting.logs.bag_files import BAG_SUFFIXES, OPTIONS, is_bag
from hefting.logs.registry import Format


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

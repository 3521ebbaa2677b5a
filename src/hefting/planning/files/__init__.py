"""Files of a planned motion, for robots and programs that play it.

Each format is a file of this package that ends with its `FORMAT`; here is their list.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.files import check_replaceable, write_atomically
from hefting.planning.result import Plan


@dataclass(frozen=True)
class MotionFile:
    """One format."""

    suffix: str
    """Of its files, in lower case, with the dot."""
    description: str
    """What it is, in a few words."""
    content: Callable[[Plan], bytes]
    """The file of a plan; `InputError` where it cannot hold it."""
    joints: int | None = None
    """How many joints it is for; None for any number."""

    def require(self, joints: int) -> None:
        """`InputError` where it cannot hold a plan of so many joints."""
        if self.joints not in (None, joints):
            what = f"{self.suffix} is for arms of {self.joints} joints, not {joints}"
            raise InputError(what, fix="write .csv, .json or .mcap")


FILES = ("csv_file", "joint_trajectory", "ros_bag", "urscript")
"""The file of each format, in the order in which they are named."""

FORMATS: dict[str, MotionFile] = {
    each.suffix: each
    for each in (import_module(f"{__name__}.{file}").FORMAT for file in FILES)
}
"""Every format by the suffix of its files."""


def format_of(path: str | Path) -> MotionFile:
    """The format of a file by its suffix; `InputError` for another."""
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        what = f"'{suffix}' is not a format of a planned motion"
        raise InputError(what, path, f"use {', '.join(FORMATS)}")
    return FORMATS[suffix]


def write_plan(plan: Plan, path: str | Path) -> None:
    """Write a planned motion in the format of the suffix, whole or not at all.

    Raises `InputError` for another suffix, for a plan that the format cannot hold, and
    for a file that cannot be written; `MissingDependencyError` for a bag without
    rosbags.

    Examples
    --------
    >>> write_plan(plan, "motion.csv")  # doctest: +SKIP
    """
    check_replaceable(path)
    write_atomically(path, format_of(path).content(plan))

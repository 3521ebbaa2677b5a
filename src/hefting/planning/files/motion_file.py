"""A format of planned motions."""

from collections.abc import Callable
from dataclasses import dataclass

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

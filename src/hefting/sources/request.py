"""What is asked of a source besides its name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hefting.core.recording import Recording


@dataclass(frozen=True)
class Request:
    """Options of a source; each transport takes what concerns it.

    Examples
    --------
    >>> from hefting.sources.request import Request
    >>> Request(topics={"wrench": "/ft_sensor"}).topics["wrench"]
    '/ft_sensor'
    """

    topics: Mapping[str, str] = field(default_factory=dict)
    """By role (wrench, pose, joint, imu): the topic to take, or "none", as in
    `hefting.logs.ros.read_bag`."""
    world_frame: str | None = None
    """Frame the poses are in; by default the root of tf."""
    sensor_frame: str | None = None
    """Frame of the sensor; by default that of the wrench."""
    speed: float = 1.0
    """How fast a log is played; infinity is as fast as it is read."""
    read: "Callable[[str], Recording] | None" = None
    """Reads a log to be played; by default `hefting.read_log`."""

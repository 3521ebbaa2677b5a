"""The registry of sources: what a source is called, and the list of those there are.

A new transport is one module that ends in its ``SOURCE``, a class of a name and a
`Request`, and its line in `SCHEMES`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import SplitResult, urlsplit

from hefting.core.errors import InputError
from hefting.online.samples import Source

if TYPE_CHECKING:
    from hefting.core.recording import Recording


class Address(NamedTuple):
    """Where a source listens."""

    host: str
    port: int
    path: str
    """What follows, without slashes around it."""


def address_of(name: str, port: int | None, example: str) -> Address:
    """Host, port and path of ``scheme://HOST[:PORT][/PATH]``.

    Parameters
    ----------
    name : as the user gave it.
    port : where none is given; None for a transport that has no usual one.
    example : what such a name looks like, for the error.

    Raises
    ------
    InputError
        For a name without a host, or with a port that cannot be.
    """
    parts = _split(name)
    found = None
    if parts is not None:
        try:
            found = parts.port or port
        except ValueError:
            raise InputError("the port is not one", name, f"as in {example}") from None
    if parts is None or not parts.hostname or found is None:
        missing = "host" if parts is None or not parts.hostname else "port"
        raise InputError(f"which {missing}?", name, f"as in {example}")
    return Address(parts.hostname, found, parts.path.strip("/"))


def _split(name: str) -> SplitResult | None:
    """The parts of a name; None where it has none."""
    try:
        return urlsplit(name)
    except ValueError:
        return None


@dataclass(frozen=True)
class Request:
    """Options of a source; each transport takes what concerns it.

    Examples
    --------
    >>> from hefting.sources.registry import Request
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


SCHEMES = {
    "tcp": "hefting.sources.tcp",
    "ws": "hefting.sources.foxglove_websocket",
    "wss": "hefting.sources.foxglove_websocket",
    "zenoh": "hefting.sources.zenoh_router",
    "dds": "hefting.sources.dds",
    "rtde": "hefting.sources.rtde",
}
"""Module of each transport, by what stands before ``://``; what is slow to import
belongs inside their functions."""

STANDARD_INPUT = "hefting.sources.standard_input"
"""Module of the source called ``-``."""

LOG = "hefting.sources.played_log"
"""Module of the source that is the name of a log."""


def source_of(name: str, request: Request | None = None) -> Source:
    """The source of a name: ``-``, ``scheme://...`` or a log to be played.

    Nothing is opened yet.

    Raises
    ------
    InputError
        For an unknown scheme, and for a name that is not one of its transport.

    Examples
    --------
    >>> from hefting.sources.registry import source_of
    >>> source_of("tcp://localhost:9000").name
    'tcp://localhost:9000'
    """
    module = import_module(_module_of(name))
    return module.SOURCE(name, request or Request())


def _module_of(name: str) -> str:
    if name == "-":
        return STANDARD_INPUT
    scheme, mark, _ = name.partition("://")
    if not mark:
        return LOG
    if scheme.lower() not in SCHEMES:
        known = ", ".join(f"{each}://" for each in SCHEMES)
        raise InputError(
            f"'{scheme[:40]}://' is no source",
            name,
            f"use {known}, - for standard input, or a log",
        )
    return SCHEMES[scheme.lower()]

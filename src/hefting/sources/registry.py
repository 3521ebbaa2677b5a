"""What a source is called, what is asked of it, and those there are.

A new transport is one module that ends in its ``SOURCE``, a class of a name and a
`Request`, and its line in `SCHEMES`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

from hefting.core.errors import InputError
from hefting.online.samples import Source

if TYPE_CHECKING:
    from hefting.core.recording import Recording


class Address(NamedTuple):
    """Where a source listens."""

    host: str
    port: int
    path: str
    """without slashes around it"""


def address_of(name: str, port: int | None, example: str) -> Address:
    """Of ``scheme://HOST[:PORT][/PATH]``, as in `example`; `port` is the usual one, if
    any. `InputError` without a host or port, and for a port that cannot be."""
    try:
        parts = urlsplit(name)
    except ValueError:
        parts = urlsplit("")
    try:
        found = parts.port or port
    except ValueError:
        raise InputError("the port is not one", name, f"as in {example}") from None
    if not parts.hostname or found is None:
        missing = "port" if parts.hostname else "host"
        raise InputError(f"which {missing}?", name, f"as in {example}")
    return Address(parts.hostname, found, parts.path.strip("/"))


@dataclass(frozen=True)
class Request:
    """Options; each transport takes what concerns it."""

    topics: Mapping[str, str] = field(default_factory=dict)
    """by role (wrench, pose, joint, imu), or "none", as in
    `hefting.logs.ros.read_bag`"""
    world_frame: str | None = None
    """of the poses; by default the root of tf"""
    sensor_frame: str | None = None
    """by default that of the wrench"""
    speed: float = 1.0
    """of a log that is played; infinity is as fast as it is read"""
    read: "Callable[[str], Recording] | None" = None
    """reads a log to be played; by default `hefting.read_log`"""


SCHEMES = {
    "tcp": "hefting.sources.tcp",
    "ws": "hefting.sources.foxglove_websocket",
    "wss": "hefting.sources.foxglove_websocket",
    "zenoh": "hefting.sources.zenoh_router",
    "dds": "hefting.sources.dds",
    "rtde": "hefting.sources.rtde",
}
"""By what stands before ``://``; what is slow to import belongs inside their
functions."""


def source_of(name: str, request: Request | None = None) -> Source:
    """``-``, ``scheme://...`` or a log to be played; nothing is opened yet.

    Raises `InputError` for an unknown scheme, and for a name that is not one of its
    transport.
    """
    scheme, mark, _ = name.partition("://")
    if name == "-":
        module = "hefting.sources.standard_input"
    elif not mark:
        module = "hefting.sources.played_log"
    elif scheme.lower() in SCHEMES:
        module = SCHEMES[scheme.lower()]
    else:
        known = ", ".join(f"{each}://" for each in SCHEMES)
        what = f"'{scheme[:40]}://' is no source"
        fix = f"use {known}, - for standard input, or a log"
        raise InputError(what, name, fix)
    return import_module(module).SOURCE(name, request or Request())

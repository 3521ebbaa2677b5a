"""The registry of sources: what a source is called, and the list of those there are.

A new transport is one module that ends in its ``SOURCE``, a class of a name and a
`Request`, and its line in `SCHEMES`.
"""

from importlib import import_module

from hefting.core.errors import InputError
from hefting.online.samples import Source
from hefting.sources.request import Request

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

"""Samples of a live stream, and what a source of them must offer."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple, Protocol, runtime_checkable

from hefting.core.errors import HeftingError
from hefting.core.messages import Message
from hefting.core.spatial import Array


class Samples(NamedTuple):
    """Some samples of one stream, in order of arrival.

    Examples
    --------
    >>> import numpy as np
    >>> some = Samples("wrench", np.array([0.0, 0.01]), np.zeros((2, 6)))
    >>> some.stream, some.values.shape
    ('wrench', (2, 6))
    """

    stream: str
    """Name of a stream of `hefting.Recording`, which says the units: ``"wrench"``,
    ``"position"``, ``"orientation"``, ``"joint_positions"``, ``"gyroscope"`` ..."""
    time: Array
    """(n,) [s] Stamps of the source's clock."""
    values: Array
    """(n, d)"""


class SourceLostError(HeftingError):
    """The connection to a source is gone; it may be opened again.

    Examples
    --------
    >>> print(hefting.SourceLostError("tcp://robot:9000: the other end closed"))
    tcp://robot:9000: the other end closed
    """


class EndOfSource(HeftingError):
    """A source that ends, as a file does, has given all it has.

    Examples
    --------
    >>> print(hefting.EndOfSource("log.csv has ended"))
    log.csv has ended
    """


@runtime_checkable
class Source(Protocol):
    """Where the samples of a live stream come from: one file of `hefting.sources` a
    transport.

    A source is used by one thread: ``open``, ``read`` again and again, ``close``; after
    `SourceLostError` ``close`` and ``open`` again.
    """

    name: str
    """As the user named it."""
    chosen: tuple[Message, ...]
    """What was chosen of what is there, such as topics, for the user."""
    skipped: Counter[str]
    """Bad messages, by the reason why they were left out."""

    def open(self) -> None:
        """Connect and choose topics.

        Raises `InputError` in one line: the host refuses, there is no such topic (and
        what is there), the schema is not understood.
        """
        ...

    def read(self, timeout: float) -> list[Samples]:
        """What came, after waiting at most `timeout` [s] for it; [] where nothing did.

        Raises `SourceLostError` when the connection is gone, and `EndOfSource` when a
        source that ends has given all.
        """
        ...

    def close(self) -> None:
        """Disconnect; again does nothing."""
        ...

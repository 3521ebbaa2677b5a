"""``tcp://HOST:PORT``: lines of JSON from a program that listens."""

import socket
from collections import Counter

from hefting.core.errors import InputError
from hefting.core.messages import Message, note
from hefting.online.samples import Samples, SourceLostError
from hefting.sources.json_lines import JsonLines
from hefting.sources.registry import Request, address_of

PATIENCE = 3.0
"""[s] for a connection."""

PIECE = 1 << 16


class TcpSource:
    """Lines of JSON from a socket."""

    def __init__(self, name: str, request: Request):
        self.name = name
        self.chosen: tuple[Message, ...] = ()
        self.skipped: Counter[str] = Counter()
        self._address = address_of(name, None, "tcp://localhost:9000")
        self._socket: socket.socket | None = None
        self._lines = JsonLines(self.skipped)

    def open(self) -> None:
        """`InputError` where the host refuses."""
        self._lines = JsonLines(self.skipped)
        self._socket = connected(self.name, self._address[:2])
        self.chosen = (note("live-source", f"lines of JSON from {self.name}"),)

    def read(self, timeout: float) -> list[Samples]:
        """See `hefting.online.samples.Source`."""
        data = received(self._socket, self.name, timeout)
        return self._lines.feed(data) if data else []

    def close(self) -> None:
        """Disconnect."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def connected(name: str, address: tuple[str, int]) -> socket.socket:
    """`InputError` where the host refuses."""
    try:
        return socket.create_connection(address, PATIENCE)
    except (OSError, UnicodeError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(
            f"cannot be reached ({why})",
            name,
            "check the host and the port, and that the program there runs",
        ) from error


def received(connection: socket.socket | None, name: str, timeout: float) -> bytes:
    """What came, after at most `timeout` [s]; `SourceLostError` when the other end has
    closed."""
    if connection is None:
        raise SourceLostError(f"{name}: is closed")
    connection.settimeout(max(timeout, 1e-3))
    try:
        data = connection.recv(PIECE)
    except TimeoutError:
        return b""
    except OSError as error:
        raise SourceLostError(f"{name}: {error.strerror or error}") from error
    if not data:
        raise SourceLostError(f"{name}: the other end closed the connection")
    return data


SOURCE = TcpSource

"""Host and port of a source, as its name gives them."""

from typing import NamedTuple
from urllib.parse import SplitResult, urlsplit

from hefting.core.errors import InputError


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

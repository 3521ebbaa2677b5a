"""A quiet server of viser that listens at one address only and opens no tunnel; and a
thread that handles the latest request of its browsers. Needs viser."""

import contextlib
import io
import re
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from hefting.core.errors import InputError, needing

if TYPE_CHECKING:
    from viser import ViserServer

HOST = "127.0.0.1"
"""Address that only this machine reaches."""
OWN_NAMES = ("127.0.0.1", "localhost", "[::1]")
"""Names of this machine in addresses of its own pages."""
EVERYWHERE = ("0.0.0.0", "::", "")
"""Addresses that stand for all interfaces of this machine."""
SKY, GROUND = 3.0, (120, 120, 140)
"""Intensity of the light, and the colour of that from below."""
T = TypeVar("T")


@contextmanager
def serving(host: str = HOST, port: int = 0) -> "Iterator[ViserServer]":
    """A context with a server at an address or name of this machine and a port, which is
    released at the end; port 0 is any free one.

    Raises `InputError` if it cannot listen there, `MissingDependencyError` without
    viser.
    """
    with needing("viser", "view"):
        import viser
    _check_free(host, port)
    with contextlib.redirect_stdout(io.StringIO()), _own_pages_only(host):
        server = viser.ViserServer(host, port, verbose=False)
    try:
        if port not in (0, server.get_port()):  # taken since `_check_free`
            raise _in_use(host, port)
        _refuse_tunnels(server)
        _light(server)
        yield server
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


def _light(server: "ViserServer") -> None:
    """Light the scene from all sides, without environment map and shadows, which take many
    seconds without a graphics card."""
    scene = server.scene
    scene.configure_environment_map(hdri=None)
    scene.configure_default_lights(cast_shadow=False)
    scene.add_light_hemisphere("/light", ground_color=GROUND, intensity=SKY)


def address_of(server: "ViserServer") -> str:
    """Address of the server for a browser on this machine."""
    host = server.get_host()
    host = {"0.0.0.0": HOST, "::": "::1", "": HOST}.get(host) or host
    return f"http://{f'[{host}]' if ':' in host else host}:{server.get_port()}"


def _check_free(host: str, port: int) -> None:
    """`InputError` if a server cannot listen there: viser would choose another port by
    itself, or wait for ever."""
    if not 0 <= port < 2**16:
        raise InputError(f"{port} is no port", "--port", "give 1024 to 65535")
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        with socket.create_server((host, port), family=family):
            pass
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise _in_use(host, port, f" ({reason})") from error


def _in_use(host: str, port: int, why: str = "") -> InputError:
    what = f"cannot listen at {host[:80]}, port {port}{why}"
    return InputError(what, "--host, --port", "give others, or leave them out")


@contextmanager
def _own_pages_only(host: str) -> Iterator[None]:
    """A context in which servers that are made refuse pages of other sites, which
    browsers let connect to any port of this machine; viser does not check the origin."""
    from websockets.asyncio import server as websockets

    serve, own = websockets.serve, (re.escape(host), *map(re.escape, OWN_NAMES))
    from_here = re.compile(rf"https?://({'|'.join(own)})(:\d+)?")

    def guarded(*arguments: Any, **options: Any) -> Any:
        return serve(*arguments, origins=[None, from_here], **options)

    if host not in EVERYWHERE:
        websockets.serve = guarded  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.serve = serve  # type: ignore[misc]


def _refuse_tunnels(server: "ViserServer") -> None:
    """Disable viser's requests of pages for a public address on the internet."""
    from viser import _messages

    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(message)


class Follower(Generic[T]):
    """Calls `work` in a thread of its own with the latest request; requests that are
    replaced by another while it works are skipped. After an exception of `work` it calls
    `failed` with it and goes on."""

    def __init__(self, work: Callable[[T], None], failed: Callable[[Exception], None]):
        self._work, self._failed = work, failed
        self._changed = threading.Condition()
        self._wanted: list[T] = []
        self._busy, self._closed = False, False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def want(self, what: T) -> None:
        """Request a call of `work` with this next."""
        with self._changed:
            self._wanted = [what]
            self._changed.notify_all()

    def settle(self) -> bool:
        """Wait until all requests are done, at most a minute; whether they are."""
        with self._changed:
            return self._changed.wait_for(
                lambda: self._closed or not (self._wanted or self._busy), 60.0
            )

    def close(self) -> None:
        """End the thread after its present call."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread is not threading.current_thread():
            self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._closed or self._wanted)
                if self._closed:
                    return
                what, self._busy = self._wanted.pop(), True
            try:
                self._work(what)
            except Exception as error:
                self._failed(error)

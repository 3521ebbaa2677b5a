"""Peers of `benchmarks.peers`, forked from one process that has loaded what they need:
each is a process of its own, but need not begin with half a second of imports."""

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

SERVER = """
import contextlib, os, sys
from benchmarks import fake_controller, fast_dds, peers

ros = peers.Ros()
ros.wrench(0, 0), ros.pose(0, 0)
with contextlib.suppress(ImportError):  # without cyclonedds
    from hefting.sources.dds import struct_for

    struct_for(peers.WRENCH), struct_for(peers.POSE)
if fast_dds.is_installed():
    fast_dds.library()
while line := sys.stdin.readline():
    process = os.fork()
    if not process:
        print(os.getpid(), flush=True)
        sys.argv[1:] = line.split()
        peers.main()
        os._exit(0)
    os.waitpid(process, 0)
    print("ended", flush=True)
"""
"""Runs one peer after another, each asked for by a line."""


class Peer:
    """One that runs; has what is used of `subprocess.Popen`."""

    def __init__(self, server: subprocess.Popen, process: int):
        self._server, self._process = server, process

    def poll(self) -> int | None:
        """None until it has ended."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process, 0)
            return None
        return 0

    def kill(self) -> None:
        """End it."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process, signal.SIGKILL)

    def communicate(self) -> None:
        """Wait for its end."""
        assert self._server.stdout is not None
        while self._server.stdout.readline() not in ("ended\n", ""):
            pass


@contextlib.contextmanager
def forked_peers() -> Iterator[Callable[..., Peer]]:
    """What starts a peer, as `benchmarks.transports.start_peer` does; one at a time."""
    server = subprocess.Popen(
        [sys.executable, "-c", SERVER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    asked, said = server.stdin, server.stdout
    assert asked is not None
    assert said is not None

    def start(name: str, port: int, seconds: float, bad: int = 0) -> Peer:
        print(name, port, seconds, bad, file=asked, flush=True)
        process, state = (said.readline().strip() for _ in range(2))
        if state != "ready":
            raise RuntimeError(f"the peer of {name} did not start")
        return Peer(server, int(process))

    try:
        yield start
    finally:
        asked.close()
        said.close()
        server.wait()

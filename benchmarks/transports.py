"""Samples through each transport, between two processes on this machine: are any lost,
and how long do they take? ``python -m benchmarks.transports [NUMBER [NAME ...]]``."""

import argparse
import os
import socket
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from benchmarks import fast_dds
from benchmarks.peers import count
from hefting.online.samples import Samples
from hefting.sources import source_of
from hefting.sources.live import Pump

ADDRESSES = {
    "tcp": "tcp://127.0.0.1:{}",
    "ws": "ws://127.0.0.1:{}",
    "zenoh": "zenoh://127.0.0.1:{}/0",
    "dds": "dds://{}",
    "fastdds": "dds://{}",
    "rtde": "rtde://127.0.0.1:{}",
}
"""What each transport's source is called; `fastdds` is ``dds`` with another sender."""
NAMES = [name for name in ADDRESSES if name != "fastdds" or fast_dds.is_installed()]
"""Of those whose sender is here."""

DOMAIN = 50 + os.getpid() % 150
"""Of DDS; another one for each run."""


GRACE = 2.0
"""[s] After its peer has ended, what was sent is read."""


@dataclass
class Received:
    """What came of one stream or several, and when."""

    stamps: dict[str, list[float]] = field(default_factory=dict)
    """[s] By stream"""
    first: dict[str, list[float]] = field(default_factory=dict)
    """First number of each sample, by stream"""
    values: dict[str, list[np.ndarray]] = field(default_factory=dict)
    """By stream, as they came"""
    delays: list[float] = field(default_factory=list)
    """From the stamp of a wrench to its delivery [s]; of those sent after the first
    delivery, before which topics were chosen"""
    begin: float | None = None
    """[s] When the first sample was delivered"""

    def add(self, samples: Samples) -> None:
        """Take samples as they are delivered."""
        now = time.time()
        self.begin = now if self.begin is None else self.begin
        self.stamps.setdefault(samples.stream, []).extend(samples.time)
        self.first.setdefault(samples.stream, []).extend(samples.values[:, 0])
        self.values.setdefault(samples.stream, []).append(samples.values)
        if samples.stream == "wrench":
            self.delays.extend(now - samples.time[samples.time > self.begin])

    def missing(self, seconds: float) -> tuple[int, int]:
        """Wrenches and positions that did not come."""
        wrenches, poses = count(seconds)
        return (
            wrenches - len(set(self.first.get("wrench", ()))),
            poses - len(set(self.first.get("position", ()))),
        )


def free_port() -> int:
    """A port that nothing listens on."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def port_for(name: str) -> int:
    """A free port, or the domain."""
    return DOMAIN if ADDRESSES[name].startswith("dds") else free_port()


def start_peer(name: str, port: int, seconds: float, bad: int = 0) -> subprocess.Popen:
    """A peer that is ready."""
    words = (name, str(port), str(seconds), str(bad))
    peer = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.peers", *words],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert peer.stdout is not None
    said = peer.stdout.readline()
    if said.strip() != "ready":
        raise RuntimeError(f"the peer of {name} did not start")
    return peer


def run(name: str, seconds: float, bad: int = 0) -> tuple[Received, Counter[str]]:
    """What comes through a transport, and what was skipped."""
    port = port_for(name)
    peer = start_peer(name, port, seconds, bad)
    received = Received()
    source = source_of(ADDRESSES[name].format(port))
    try:
        with Pump(source, received.add) as pump:
            end = time.monotonic() + seconds + 15
            wrenches, _ = count(seconds)
            while time.monotonic() < end and not pump.wait(0.05):
                if len(received.first.get("wrench", ())) >= wrenches:
                    time.sleep(0.2)
                    break
                if peer.poll() is not None:  # what it sent is still to be read
                    end = min(end, time.monotonic() + GRACE)
            if pump.error is not None:
                raise pump.error
    finally:
        peer.kill()
        peer.communicate()
    return received, source.skipped


def asked(module: str, text: str, what: str, usual: float) -> tuple[float, list[str]]:
    """A number of the command line and the transports to try, by default all that are
    installed, for the benchmark `module` that `text` describes."""
    parser = argparse.ArgumentParser(
        prog=f"python -m benchmarks.{module}", description=text
    )
    parser.add_argument("number", type=float, nargs="?", default=usual, help=what)
    parser.add_argument("name", nargs="*", help=f"of {', '.join(ADDRESSES)}")
    given = parser.parse_args()
    return given.number, given.name or NAMES


def main() -> None:
    """Losses and delays of samples through each transport, as a table."""
    seconds, names = asked("transports", main.__doc__ or "", "seconds of each", 60.0)
    print("transport  wrenches  lost  poses  lost  median  99 %  most [ms]  processor")
    for name in names:
        begin = time.process_time()
        received, skipped = run(name, seconds)
        used = (time.process_time() - begin) / seconds
        lost = received.missing(seconds)
        median, high, most = 1e3 * np.percentile(received.delays, (50, 99, 100))
        wrenches, poses = (
            len(received.first.get(stream, ())) for stream in ("wrench", "position")
        )
        print(
            f"{name:9}  {wrenches:8}  {lost[0]:4}  {poses:5}  {lost[1]:4}  "
            f"{median:6.2f}  {high:4.1f}  {most:9.1f}  {used:8.0%}  "
            f"{dict(skipped) or ''}",
            flush=True,
        )


if __name__ == "__main__":
    main()

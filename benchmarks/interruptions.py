"""A source that is killed and started again ten times, and sends something malformed
after every hundredth wrench: do samples of each life come, and is the rest counted?
``python -m benchmarks.interruptions [NUMBER [NAME ...]]``."""

import time
from collections import Counter

from benchmarks.transports import ADDRESSES, asked, port_for, start_peer
from hefting.core.messages import Message
from hefting.online.samples import Samples
from hefting.sources import source_of
from hefting.sources.live import Pump

LIFE = 1.5
"""How long each peer lives from its first sample on [s]."""

LONGEST = 20.0
"""Longest wait for the first sample of a peer [s]."""


class Lives:
    """Counts the samples of each life of a source."""

    def __init__(self):
        self.wrenches: list[int] = []
        self.said: Counter[str] = Counter()

    def add(self, samples: Samples) -> None:
        """Take samples as they are delivered."""
        if samples.stream != "wrench":
            return
        if self.wrenches:
            self.wrenches[-1] += len(samples.time)

    def tell(self, message: Message) -> None:
        """Take a message on the connection."""
        self.said[message.code] += 1


def run(name: str, lives: int, life: float = LIFE) -> tuple[Lives, Pump]:
    """Samples through a transport whose other end is killed `lives` times."""
    port = port_for(name)
    found = Lives()
    pump = Pump(source_of(ADDRESSES[name].format(port)), found.add, found.tell)
    for k in range(lives):
        peer = start_peer(name, port, 60.0, 100)
        try:
            found.wrenches.append(0)
            if k == 0:
                pump.start()
            _wait_for_samples(found, pump)
            time.sleep(life)
        finally:
            peer.kill()
            peer.communicate()
    pump.close()
    return found, pump


def _wait_for_samples(found: Lives, pump: Pump) -> None:
    """Wait for the first wrench of a life; raises what ended the pump."""
    end = time.monotonic() + LONGEST
    while not found.wrenches[-1] and time.monotonic() < end:
        if pump.wait(0.02) and pump.error is not None:
            raise pump.error


def main() -> None:
    """What comes from sources that are killed and started again, as a table."""
    lives, names = asked("interruptions", main.__doc__ or "", "lives of each", 10)
    print("transport  wrenches of each life: fewest, most  lost  back  skipped")
    for name in names:
        found, pump = run(name, int(lives))
        fewest, most = min(found.wrenches), max(found.wrenches)
        lost, back = (found.said[f"source-{what}"] for what in ("lost", "back"))
        skipped = dict(pump.source.skipped)
        print(
            f"{name:9}  {fewest:28}, {most:4}  {lost:4}  {back:4}  {skipped}",
            flush=True,
        )


if __name__ == "__main__":
    main()

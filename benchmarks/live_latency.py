"""From a sample to an estimate with it: 500 wrenches and 100 poses a second, sent by
another process through each transport. ``python -m benchmarks.live_latency [NUMBER
[NAME ...]]``."""

import gc
import time

import numpy as np

from benchmarks.peers import RATE
from benchmarks.transports import ADDRESSES, asked, port_for, start_peer
from hefting.core.measurements import Noise
from hefting.core.recording import Recording
from hefting.online import LiveIdentifier
from hefting.online.samples import Samples
from hefting.simulation import UR5, hammer, simulate, sinusoids
from hefting.sources import source_of
from hefting.sources.live import Pump

STREAMS = ("wrench", "position", "orientation")
"""What the hammer has; a controller sends joint positions, too."""
PATIENCE = 5.0
"""[s] Longest wait for an estimate once there was one: then the peer has ended."""


def recording_of(seconds: float) -> Recording:
    """A hammer that is wielded: wrenches and poses at 500 Hz."""
    noise = {"noise": Noise(0.1, 0.005), "pose_noise": (1e-4, 3.5e-4), "seed": 3}
    motion = UR5.motion(sinusoids(seconds, RATE, 1.5))
    return simulate(motion, hammer().parameters, **noise)


class Wielded:
    """The samples of a transport with the values of a hammer at their stamps."""

    def __init__(self, seconds: float):
        recording = recording_of(seconds + 1.0)
        self._columns = {
            name: (recording[name].time, recording[name].values.T.copy())
            for name in STREAMS
        }
        self._begin: float | None = None
        """[s] stamp at which the hammer begins to move"""

    def __call__(self, samples: Samples) -> Samples:
        """The same stamps, other values."""
        name, stamps, _ = samples
        if self._begin is None:
            self._begin = float(stamps[0])
        at, (time, columns) = stamps - self._begin, self._columns[name]
        values = [np.interp(at, time, column) for column in columns]
        return Samples(name, stamps, np.column_stack(values))


def delays(name: str, seconds: float) -> list[float]:
    """[s] From the newest sample of each estimate to when that is told."""
    port = port_for(name)
    wielded, found, newest = Wielded(seconds), list[float](), 0.0
    peer = start_peer(name, port, seconds)
    gc.collect()
    gc.freeze()  # as hefting live does
    try:
        with LiveIdentifier() as identifier:

            def deliver(samples: Samples) -> None:
                if samples.stream in STREAMS:
                    identifier.add(wielded(samples))

            source = source_of(ADDRESSES[name].format(port))
            with Pump(source, deliver) as pump:
                while not pump.wait(0.0):
                    told = identifier.wait(PATIENCE)
                    if told is None or peer.poll() is not None:
                        break
                    if told.estimate is not None and told.time > newest:
                        found.append(time.time() - told.time)
                    newest = told.time
    finally:
        peer.kill()
        peer.communicate()
    return found


def main() -> None:
    """How long it takes from a sample to an estimate with it, as a table."""
    seconds, names = asked("live_latency", main.__doc__ or "", "seconds of each", 60.0)
    print("transport  estimates  median  90 %  99 %  most [ms]")
    for name in names:
        found = delays(name, seconds)
        if not found:
            raise SystemExit(f"{name}: there was no estimate: send for longer")
        values = 1e3 * np.percentile(found, (50, 90, 99, 100))
        columns = "  ".join(f"{x:6.1f}" for x in values)
        print(f"{name:9}  {len(found):9}  {columns}", flush=True)


if __name__ == "__main__":
    main()

"""From a sample to an estimate with it, of a stream at its own speed: 500 wrenches and
100 poses a second. ``python -m benchmarks.live_latency [SECONDS]``."""

import sys
import time

import numpy as np

from hefting.core.measurements import Noise
from hefting.core.recording import Recording
from hefting.online import LiveIdentifier
from hefting.simulation import UR5, hammer, simulate, sinusoids
from hefting.sources.played_log import PlayedLog
from hefting.sources.pump import Pump
from hefting.sources.request import Request

RATIO = 5
"""Wrenches to each pose."""


def recording_of(seconds: float) -> Recording:
    """A hammer that is wielded."""
    noise = {"noise": Noise(0.1, 0.005), "pose_noise": (1e-4, 3.5e-4), "seed": 3}
    motion = UR5.motion(sinusoids(seconds, 500.0, 1.5))
    log = simulate(motion, hammer().parameters, **noise)
    poses = {name: log[name][::RATIO] for name in ("position", "orientation")}
    return Recording({"wrench": log["wrench"], **poses})


def main() -> None:
    """Print percentiles."""
    recording = recording_of(float(sys.argv[1]) if len(sys.argv) > 1 else 30.0)
    delays: list[float] = []
    begin: list[float] = []

    with LiveIdentifier() as identifier:

        def deliver(samples):
            begin.append(time.monotonic() - (samples.time[-1] - recording.start))
            identifier.add(samples)

        source = PlayedLog("a simulated log", Request(), recording)
        with Pump(source, deliver) as pump:
            while not pump.wait(0.0):
                found = identifier.wait(0.2)
                if found is not None and found.estimate is not None:
                    # the clock of the log is the least late delivery
                    passed = time.monotonic() - min(begin)
                    delays.append(passed - (found.time - recording.start))
    if not delays:
        raise SystemExit("there was no estimate: play it for longer")
    values = " ".join(f"{x:.1f}" for x in 1e3 * np.percentile(delays, (50, 99, 100)))
    print(f"{len(delays)} estimates, newest sample to estimate [ms]: {values}")


if __name__ == "__main__":
    main()

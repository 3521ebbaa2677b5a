"""A stream of 1 kHz in real time: the memory of the process that samples, and how long
`add` takes."""

import os
import time
from pathlib import Path

RATE = 1000.0
"""[Hz]"""
SETTLED = 60.0
"""[s] after which memory is compared: the history is full by then."""


def run(minutes: int) -> None:
    """Print the figures; on one core, where the system lets one choose."""
    import numpy as np

    from benchmarks.online_streams import faulty
    from hefting.online import LiveIdentifier

    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    log = faulty(1, 60.0).recording
    names = ("wrench", "position", "orientation")
    count = int(60.0 * minutes * RATE)
    took, memory = np.zeros(3 * count, dtype=np.float32), []
    with LiveIdentifier() as live:
        began = time.perf_counter()
        for k in range(count):
            now = k / RATE
            while time.perf_counter() - began < now:
                time.sleep(2e-4)
            for i, name in enumerate(names):
                # there and back, so that the motion has no jump
                phase = (now * 100.0) % (2.0 * (len(log[name]) - 1))
                row = int(min(phase, 2.0 * (len(log[name]) - 1) - phase))
                value = log[name].values[row]
                start = time.perf_counter()
                live.add(name, now, value)
                took[3 * k + i] = time.perf_counter() - start
            if k % int(10.0 * RATE) == 0:
                memory.append((now, resident()))
        late = time.perf_counter() - began - count / RATE
        last = live.latest
    base = next(size for at, size in memory if at >= min(SETTLED, memory[-1][0]))
    first = memory[0][1]
    ends = [1e3 * float(np.quantile(took, q)) for q in (0.5, 0.99, 0.999)]
    said = None if last is None else (last.state, last.counts)
    print(
        f"add: median {ends[0]:.4f} ms, 99 % {ends[1]:.4f} ms, 99.9 % {ends[2]:.3f} ms;"
        f" memory {first:.0f} MiB at first, {base:.0f} after {SETTLED:g} s, "
        f"{memory[-1][1]:.0f} at the end; {1e3 * late:.0f} ms late; {said}"
    )


def resident() -> float:
    """MiB of memory that this process holds."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20

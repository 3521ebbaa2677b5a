"""Memory and throughput of folding, in a process of its own: its peak is not hidden by
that of other work.

`python -m benchmarks.memory SAMPLES` prints a JSON object.
"""

import json
import resource
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.report import Row, Section

BLOCK = 20_000
"""Samples handed over at once."""


@dataclass(frozen=True)
class Folding:
    """What folding many samples took."""

    samples: int
    seconds: float
    growth: int
    """How much the peak of the resident memory rose after the first two blocks
    [bytes]."""


def fold(samples: int) -> Folding:
    """Fold so many samples into the state of PMD, block by block."""
    from hefting import PMD, Shape
    from hefting.core.measurements import Measurements

    pmd = PMD(Shape.from_box(-0.05, 0.05, -0.05, 0.05, 0.0, 0.3))
    rng = np.random.default_rng(0)
    time_in_block, arrays = np.arange(BLOCK) * 1e-3, rng.normal(size=(6, BLOCK, 3))
    state, elapsed, before = pmd.start(), 0.0, 0
    blocks = max(samples // BLOCK, 4)
    for block in range(blocks):
        if block == 2:
            before = peak()
        start = time.perf_counter()
        state = pmd.update(
            state, Measurements(time_in_block + block * BLOCK * 1e-3, *arrays)
        )
        elapsed += time.perf_counter() - start
    return Folding(state.full.samples, elapsed, peak() - before)


def peak() -> int:
    """Peak of the resident memory of this process so far [bytes]; on Linux without that
    of the process which began it, which `getrusage` counts."""
    status = Path("/proc/self/status")
    if status.exists():
        lines = status.read_text().splitlines()
        return next(1024 * int(x.split()[1]) for x in lines if x.startswith("VmHWM:"))
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def folding_memory(samples: int) -> Section:
    """Fold in another process, and report."""
    command = [sys.executable, "-m", "benchmarks.memory", str(samples)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    folding = Folding(**json.loads(done.stdout))
    return Section(
        f"Folding {folding.samples:,} samples, {BLOCK:,} at a time",
        (
            Row(
                "rise of peak memory",
                figure=folding.growth / 2**20,
                unit="MiB",
                at_most=2.0,
            ),
            Row(
                "throughput", figure=folding.samples / folding.seconds, unit="samples/s"
            ),
        ),
    )


if __name__ == "__main__":
    print(json.dumps(asdict(fold(int(sys.argv[1])))))

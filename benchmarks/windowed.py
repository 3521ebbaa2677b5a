"""A recording too large for memory: read in windows, each condensed where it is read,
and identified together by a batch; against the peak memory that its first minute takes alone.

`python -m benchmarks.windowed [--samples N]` prints time, peak memory and what was
found. The log is written block by block to a temporary folder, and removed.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from unittest.mock import patch

import numpy as np

from benchmarks.memory import peak

ROOT = Path(__file__).resolve().parents[1]
RATE = 1000.0
"""[Hz]"""
BLOCK = 50_000
"""Rows that are simulated at a time; no multiple of a window's."""
MINUTE = 60_000
"""Rows of the recording that memory is compared with."""
DRIFT_PERIOD = 3_000.0
"""[s] Of the wrench's bias, which swings by 10 N and 0.5 N m."""


def write(rows: int, path: Path) -> None:
    """Write the log of an arm that wields a hammer without a pause, its joints on sums
    of sinusoids, with noise and a bias that drifts."""
    from pyarrow import parquet

    from hefting.core.measurements import Noise
    from hefting.logs.canonical import table_from_recording
    from hefting.simulation import UR5, hammer, simulate

    noise, body = Noise(force=0.1, torque=0.005), hammer().parameters
    writer = None
    for begin in range(0, rows, BLOCK):
        time_ = np.arange(begin, min(begin + BLOCK, rows)) / RATE
        swing = np.sin(2.0 * np.pi * time_ / DRIFT_PERIOD)[:, None]
        bias = swing * np.repeat((10.0, 0.5), 3) + (5.0, -3.0, 8.0, 0.2, 0.1, -0.3)
        motion = UR5.motion(_joints(time_))
        log = simulate(motion, body, noise=noise, bias=bias, seed=begin)
        table = table_from_recording(log)
        writer = writer or parquet.ParquetWriter(path, table.schema)
        writer.write_table(table)
    assert writer is not None
    writer.close()


def _joints(time_: np.ndarray):
    """Joints on three sinusoids each, the same at the same time."""
    from hefting.simulation import UR5
    from hefting.simulation.arm import JointMotion

    rng = np.random.default_rng(18)
    amplitude = np.radians(rng.uniform(5.0, 15.0, (3, UR5.n)))
    omega = 2.0 * np.pi * rng.uniform(0.05, 0.3, (3, UR5.n))
    phase = rng.uniform(0.0, 2.0 * np.pi, (3, UR5.n))
    angle = omega * time_[:, None, None] + phase
    q = UR5.start + (amplitude * np.sin(angle)).sum(axis=1)
    dq = (amplitude * omega * np.cos(angle)).sum(axis=1)
    ddq = -(amplitude * omega**2 * np.sin(angle)).sum(axis=1)
    return JointMotion(time_, q, dq, ddq)


def whole(path: Path) -> dict:
    """Identify a log as it is."""
    from hefting import identify

    start = time.perf_counter()
    found = identify(path).estimate
    return _told(found, time.perf_counter() - start, parts=1)


def windowed(path: Path) -> dict:
    """Identify a log as `hefting batch` does one that is too large to be read whole."""
    from hefting.batches.one import estimate_of
    from hefting.logs import windows
    from hefting.request.request import request_of

    start = time.perf_counter()
    with patch.object(windows, "LARGEST_WHOLE", 0):
        found = estimate_of(request_of({}), str(path), None)
    parts = len(found.provenance.get("recordings", (path,)))
    return _told(found, time.perf_counter() - start, parts)


def _told(found, seconds: float, parts: int) -> dict:
    from hefting.simulation import hammer

    true = hammer().parameters
    return {
        "seconds": seconds,
        "peak": peak(),
        "parts": parts,
        "samples": found.samples,
        "mass": found.mass,
        "mass_error": found.mass - true.mass,
        "com_error": (found.center_of_mass - true.center_of_mass).tolist(),
        "half_mass": float(np.ptp(found.intervals["mass"]) / 2),
        "half_com": (np.ptp(found.intervals["center_of_mass"], axis=0) / 2).tolist(),
        "verdict": found.verdict.level,
        "codes": [getattr(message, "code", "") for message in found.warnings],
    }


def in_process(step: str, *arguments: object) -> dict:
    """A step in a process of its own: its peak is not hidden by that of other work."""
    command = [sys.executable, "-m", "benchmarks.windowed", "--step", step]
    done = subprocess.run(
        [*command, *map(str, arguments)], cwd=ROOT, check=True, stdout=subprocess.PIPE
    )
    return json.loads(done.stdout)


def compare(samples: int) -> list[str]:
    """Lines that tell what a recording of so many samples took, and its first
    minute."""
    with tempfile.TemporaryDirectory() as folder:
        path, minute = Path(folder, "log.parquet"), Path(folder, "minute.parquet")
        in_process("write", path, samples)
        in_process("write", minute, min(MINUTE, samples))
        alone, all_ = in_process("whole", minute), in_process("windowed", path)
    rise = (all_["peak"] - alone["peak"]) / 2**20
    return [
        f"first minute: {alone['seconds']:.1f} s, {alone['peak'] / 2**20:.0f} MiB",
        f"{all_['samples']:,} samples in {all_['parts']} windows: "
        f"{all_['seconds']:.1f} s",
        f"peak memory {all_['peak'] / 2**20:.0f} MiB, {rise:+.0f} MiB",
        f"mass {all_['mass']:.5f} kg, off by {all_['mass_error']:+.5f} "
        f"± {all_['half_mass']:.5f} kg",
        f"{all_['verdict']}: {', '.join(all_['codes']) or 'no warnings'}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=10_000_000)
    parser.add_argument("--step", choices=("write", "whole", "windowed"))
    parser.add_argument("arguments", nargs="*")
    given = parser.parse_args()
    if given.step is None:
        print("\n".join(compare(given.samples)))
        return
    path = Path(given.arguments[0])
    if given.step == "write":
        write(int(given.arguments[1]), path)
        print("{}")
    else:
        print(json.dumps({"whole": whole, "windowed": windowed}[given.step](path)))


if __name__ == "__main__":
    main()

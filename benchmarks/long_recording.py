"""A long recording at 1 kHz, poses and wrench in a CSV file, read and identified in a
process of its own.

`python -m benchmarks.long_recording ROWS` prints a JSON object.
"""

import json
import subprocess
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.memory import peak
from benchmarks.report import Row, Section

RATE = 1000.0
ROOT = Path(__file__).resolve().parents[1]
COMMAND = (sys.executable, "-m", "benchmarks.long_recording")


@dataclass(frozen=True)
class Identified:
    """What reading and identifying took."""

    rows: int
    reading: float
    """[s]"""
    identifying: float
    """[s]"""
    peak: int
    """resident memory [bytes], libraries included"""
    error: float
    """of the mass [%]"""


def write(rows: int, path: Path) -> None:
    """Write the log of an arm that wields a hammer, with noise and a constant bias."""
    from hefting.core.measurements import Noise
    from hefting.logs import write_log
    from hefting.simulation import UR5, hammer, random_smooth, simulate

    motion = UR5.motion(random_smooth(rows / RATE, RATE, 1.0, seed=1))
    noise = Noise(force=0.1, torque=0.005)
    write_log(
        simulate(
            motion,
            hammer().parameters,
            noise=noise,
            bias=(5.0, -3.0, 8.0, 0.2, 0.1, -0.3),
        ),
        path,
    )


def identify_file(path: Path) -> Identified:
    """Read and identify it."""
    from hefting import identify, read_log
    from hefting.simulation import hammer

    start = time.perf_counter()
    recording = read_log(path)
    read = time.perf_counter()
    found = identify(recording).estimate
    done = time.perf_counter()
    mass = hammer().parameters.mass
    error = 100.0 * abs(found.parameters.mass / mass - 1.0)
    return Identified(
        len(recording["wrench"]), read - start, done - read, peak(), error
    )


def written(rows: int, folder: Path) -> Path:
    """The log in a folder; written in a process of its own unless it is there."""
    path = folder / f"{rows}_rows.csv"
    if not path.exists():
        subprocess.run([*COMMAND, str(rows), str(path)], cwd=ROOT, check=True)
    return path


def long_recording(rows: int, folder: Path) -> Section:
    """Write it in one process, identify it in another, and report."""
    done = subprocess.run(
        [*COMMAND, str(written(rows, folder))],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    found = Identified(**json.loads(done.stdout))
    return Section(
        f"A recording of {found.rows:,} rows, poses and wrench as CSV",
        (
            Row(
                "read and identified",
                figure=found.reading + found.identifying,
                unit="s",
                at_most=15.0,
            ),
            Row("reading alone", figure=found.reading, unit="s"),
            Row("peak memory", figure=found.peak / 2**20, unit="MiB", at_most=1024.0),
            Row("error of the mass", figure=found.error, unit="%", at_most=0.1),
        ),
    )


if __name__ == "__main__":
    if len(sys.argv) == 3:
        write(int(sys.argv[1]), Path(sys.argv[2]))
    else:
        print(json.dumps(asdict(identify_file(Path(sys.argv[1])))))

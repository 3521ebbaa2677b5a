"""`python -m benchmarks.batch [--recordings N] [--kills K] [--folder FOLDER]`: a batch of
simulated recordings, some broken in ten ways.

Printed: whether each whole one is identified and each broken one named; recordings a
second on two cores and on one; shares of the stages; and, with ``--kills``, whether
a run that is killed (SIGKILL) so many times at random moments and resumed gives the same
table.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

BROKEN = 0.05
"""Share of the recordings that are broken."""


def write_all(
    folder: Path, count: int, jobs: int | None
) -> tuple[Path, dict[str, str]]:
    """Write recordings and a manifest that names them; returns the manifest, and the
    options that all share."""
    from benchmarks.batch_recordings import way_of, write_recording, write_shape
    from hefting.jobs import Jobs

    data = folder / "data"
    data.mkdir(parents=True, exist_ok=True)
    names = [f"{number:06d}.csv" for number in range(count)]
    tasks = [
        (str(data / name), number, way_of(number, BROKEN))
        for number, name in enumerate(names)
        if not (data / name).exists()
    ]
    with Jobs(jobs) as workers:
        for _ in workers.run(write_recording, tasks):
            pass
    manifest = data / "manifest.csv"
    manifest.write_text("\n".join(("recording", *names)) + "\n")
    return manifest, write_shape(folder)


def wrong_rows(output: Path, count: int) -> list[str]:
    """What is wrong with a table: a whole recording without an answer near the truth, a
    broken one without a reason, one that is not there once."""
    import pandas as pd

    from benchmarks.batch_recordings import way_of
    from hefting.simulation import hammer

    table = pd.read_parquet(output)
    mass = hammer().parameters.mass
    found = {Path(row.recording).stem: row for row in table.itertuples()}
    wrong = [] if len(table) == len(found) == count else [f"{len(table)} rows"]
    for number in range(count):
        row = found.get(f"{number:06d}")
        if row is None:
            wrong.append(f"{number}: not there")
        elif way_of(number, BROKEN) is not None:
            if row.error != "InputError" or not row.error_text:
                wrong.append(f"{number}: broken, and {row.error}: {row.error_text}")
        elif not pd.isna(row.error) or not abs(row.mass / mass - 1.0) < 0.1:
            wrong.append(f"{number}: {row.error_text or row.mass}")
    return wrong


def same_rows(first: Path, second: Path) -> bool:
    """Whether two tables are equal, row for row, times aside."""
    from pyarrow import parquet

    one, other = (
        parquet.read_table(each).drop(["seconds"]) for each in (first, second)
    )
    return one.equals(other)


def killed_and_resumed(
    manifest: Path, shared: dict[str, str], output: Path, kills: int, lasts: float
) -> int:
    """Run a batch that is killed at random moments within the time that it lasts [s];
    how often that succeeded."""
    moments = random.Random(7)
    done = 0
    for _ in range(kills):
        run = subprocess.Popen(
            _command(manifest, shared, output), start_new_session=True
        )
        time.sleep(moments.uniform(0.5, max(1.0, 2.0 * lasts / kills)))
        if run.poll() is None:
            os.killpg(run.pid, signal.SIGKILL)
            done += 1
        run.wait()
    subprocess.run(_command(manifest, shared, output), check=True)
    return done


@contextmanager
def on_cores(count: int):
    """This process, and those it begins, on so many cores, where that can be said."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, set(sorted(before)[:count]))
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def _command(manifest: Path, shared: dict[str, str], output: Path) -> list[str]:
    options = [f"--{name.replace('_', '-')}={value}" for name, value in shared.items()]
    start = [
        sys.executable,
        "-m",
        "hefting",
        "batch",
        str(manifest),
        "--resume",
        "--json",
    ]
    return [*start, "--output", str(output), *options]


def main() -> None:
    """Print what came of it."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.batch")
    parser.add_argument("--recordings", type=int, default=2000)
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--folder", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as own:
        run(arguments.folder or Path(own), arguments.recordings, arguments.kills)


def run(folder: Path, count: int, kills: int) -> None:
    """All of it, in a folder."""
    from hefting.batches import batch

    manifest, shared = write_all(folder, count, None)
    rates = {}
    for jobs in (2, 1):
        output = Path(tempfile.mkdtemp(dir=folder))
        with on_cores(jobs):
            found = batch(manifest, output, jobs=jobs, **shared)
        rates[jobs] = count / found.seconds
        wrong = wrong_rows(output, count)
        print(f"{count} recordings, {jobs} cores: {rates[jobs]:.1f} a second, "
              f"{found.summary.failed} failed, {len(wrong)} wrong {wrong[:3]}")  # fmt: skip
        if jobs == 2:
            whole, lasts = output, found.seconds
            seconds = found.summary.seconds
            shares = {
                k: f"{100 * v / sum(seconds.values()):.0f} %"
                for k, v in seconds.items()
            }
            print(
                f"time: {shares}; {1e3 * sum(seconds.values()) / count:.0f} ms a recording"
            )
            print(
                "failed:",
                dict(Counter({r.text: r.count for r in found.summary.reasons})),
            )
    print(f"two cores over one: {rates[2] / rates[1]:.2f}")
    if kills:
        output = Path(tempfile.mkdtemp(dir=folder))
        done = killed_and_resumed(manifest, shared, output, kills, lasts)
        print(f"killed {done} times and resumed: the same {same_rows(whole, output)}")


if __name__ == "__main__":
    main()

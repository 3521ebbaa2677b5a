"""`python -m benchmarks.batch_memory [--rows N]`: how much the memory of a batch grows
over its rows, from the first thousand on.

The rows are made without any recording: all else is as in a batch, the manifest, the
parts, the table at the end and the summary, twice, the second time resumed.
"""

import argparse
import json
import sys
import tempfile
import time
from hashlib import md5
from pathlib import Path
from unittest.mock import patch

from benchmarks.memory import peak

FIRST = 1000
"""Rows after which the memory is taken for that of an empty batch."""


def make_row(task):
    """A row as identified, of no recording."""
    import numpy as np

    from hefting.batches.columns import filled
    from hefting.batches.one import start_row
    from hefting.core.estimate import Estimate
    from hefting.core.inertia import InertialParameters
    from hefting.core.messages import warning

    entry, kept = task
    key = md5(entry.recording.encode(), usedforsecurity=False).hexdigest()
    if kept == key:
        return None
    rng = np.random.default_rng(len(entry.recording))
    body = InertialParameters.from_com(1.0, (0.0, 0.0, 0.1), 1e-3 * np.eye(3))
    estimate = Estimate(
        "Bayes",
        body,
        1000,
        10.0,
        rng.normal(size=(10, 10)),
        residual=(0.1, 0.01),
        warnings=tuple(warning("no-shape", f"{k} {'word ' * 20}") for k in range(3)),
        provenance={"log": entry.recording, "notes": ["word " * 20] * 5},
    )
    row = start_row(entry) | {"hash": key, "seconds": None}
    return filled(row, estimate)


def grown(rows: int) -> dict[str, float]:
    """Growth of the peak of the memory [MiB] in a run and in one that resumes it."""
    from importlib import import_module

    batches = import_module("hefting.batches.batch")
    with (
        patch.object(batches, "row_of", make_row),
        tempfile.TemporaryDirectory() as name,
    ):
        manifest = Path(name, "manifest.csv")
        with open(manifest, "w") as stream:
            stream.write("recording,shape,mass\n")
            for number in range(rows):
                stream.write(f"day-{number % 31}/cell-7/recording-{number:08d}.csv,,\n")
        before = 0

        def first(progress):
            nonlocal before
            if progress.done == FIRST:
                before = peak()

        began = time.perf_counter()
        batches.batch(manifest, Path(name, "out"), jobs=1, progress=first)
        after, seconds = peak(), time.perf_counter() - began
        found = batches.batch(manifest, Path(name, "out"), jobs=1, resume=True)
        assert found.summary.total == rows == found.progress.kept
        size = sum(each.stat().st_size for each in Path(name, "out").iterdir())
    mib = 2.0**20
    return {
        "rows": rows,
        "grown": (after - before) / mib,
        "grown resumed": (peak() - before) / mib,
        "seconds": seconds,
        "table": size / mib,
    }


def main() -> None:
    """Print the growth as JSON."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.batch_memory")
    parser.add_argument("--rows", type=int, default=100_000)
    json.dump(grown(parser.parse_args().rows), sys.stdout)
    print()


if __name__ == "__main__":
    main()

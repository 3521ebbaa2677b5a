"""`python -m benchmarks.fuzz [--count N] [--seed S] [--reader NAME]`: mutated files of
every kind, read by the commands.

What may come out is a result, or an error of one line. Everything else is a failure:
another exception, a warning of Python or NumPy, more than 10 s of processor time for a
file, more than 2 GiB of memory, the end of the process. Failures are listed by kind;
each file is kept in `--failures`, named by reader, seed and number, and is made again
by `--reader NAME --seed S --first NUMBER --count 1`. Ends with an error where there are
any. Some 20 to 40 files a second and process; those for `hefting plan` take seconds
each, and are read only where `--reader` names them.
"""

import argparse
import os
import sys
import tempfile
import time
from contextlib import ExitStack, closing
from pathlib import Path

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

KEPT = 3
"""Files that are kept of each kind of failure."""


def main() -> None:
    """Read mutated files and list the failures."""
    import pickle

    from benchmarks.fuzzing.readers import READERS
    from benchmarks.fuzzing.seeds import make_seeds
    from benchmarks.fuzzing.workers import Failure, Fuzzer, Tally

    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.fuzz", description=main.__doc__
    )
    parser.add_argument("--count", type=int, default=10_000, help="files in all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first file")
    parser.add_argument("--reader", choices=READERS, action="append", help="repeatable")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--minutes", type=float, help="stop after so long")
    parser.add_argument("--failures", type=Path, help="folder for files that fail")
    a = parser.parse_args()

    names = a.reader or [name for name in READERS if not READERS[name].slow]
    jobs = [(names[i % len(names)], a.first + i // len(names)) for i in range(a.count)]
    tallies = {name: Tally() for name in names}
    with ExitStack() as stack:
        folder = Path(
            stack.enter_context(tempfile.TemporaryDirectory(prefix="hefting-fuzz-"))
        )
        seeds = make_seeds(folder)
        (folder / "seeds.pickle").write_bytes(pickle.dumps(seeds))
        until = time.monotonic() + 60.0 * (a.minutes or float("inf"))
        outcomes = stack.enter_context(
            closing(Fuzzer(a.seed, folder).outcomes(jobs, a.jobs))
        )
        for (name, index), outcome in outcomes:
            status, kind, details, seconds, memory = outcome
            tally = tallies[name]
            tally.files += 1
            tally.read += not kind and status == 0
            tally.refused += not kind and status > 0
            tally.longest = max(tally.longest, seconds)
            tally.memory = max(tally.memory, memory)
            if kind:
                tally.failures.append(Failure(name, index, kind, details))
                if a.failures and tally.kinds()[kind] <= KEPT:
                    _keep(a.failures, name, seeds[name], a.seed, index, details, folder)
            if time.monotonic() > until:
                break
    _show(tallies)
    sys.exit(any(tally.failures for tally in tallies.values()))


def _keep(
    target: Path,
    name: str,
    seeds: list,
    seed: int,
    index: int,
    details: str,
    folder: Path,
) -> None:
    """Keep the file of a failure, and what came of it."""
    from benchmarks.fuzzing.readers import make_case

    case = make_case(name, seeds, seed, index, folder, folder)
    target.mkdir(parents=True, exist_ok=True)
    stem = f"{name}-{seed}-{index}"
    suffix = Path(case.seed.name).suffix
    (target / f"{stem}{suffix}").write_bytes(case.data)
    (target / f"{stem}.txt").write_text(details)


def _show(tallies: dict) -> None:
    """Print what came of the files, reader by reader, then failures by kind."""
    print(f"{'reader':12}{'files':>8}{'read':>8}{'refused':>9}{'failed':>8}"
          f"{'longest':>10}{'memory':>10}")  # fmt: skip
    for name, tally in tallies.items():
        print(f"{name:12}{tally.files:8}{tally.read:8}{tally.refused:9}{len(tally.failures):8}"
              f"{tally.longest:8.2f} s{tally.memory / 2**20:6.0f} MiB")  # fmt: skip
    for name, tally in tallies.items():
        for kind, count in tally.kinds().most_common():
            first = next(one for one in tally.failures if one.kind == kind)
            print(f"{count:6} {name}: {kind} (first: number {first.index})")


if __name__ == "__main__":
    main()

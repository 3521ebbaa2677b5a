"""Worker processes that read mutated files, with bounded memory and time; one that
hangs or dies is replaced."""

import multiprocessing
import os
import resource
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

MEMORY = 2 * 2**30
"""Most memory of a worker [bytes]."""

FILES_OF_A_PROCESS = 5000
"""Number of files after which a worker is replaced: what libraries in C map and do not
give back adds up, and counts as memory."""

LONGEST = 10.0
"""Most processor time for one file [s]."""

Job = tuple[str, int]
"""A reader, and the number of a file."""


Run = Callable[[str, list, int, int, Path, Path], tuple[int, str, str]]
"""Makes one mutated file and lets commands read it; `run_case` is one."""


@dataclass(frozen=True)
class Failure:
    """One file that was not read as it should be."""

    reader: str
    index: int
    kind: str
    details: str


@dataclass
class Tally:
    """What came of all files of one reader."""

    files: int = 0
    read: int = 0
    refused: int = 0
    longest: float = 0.0
    """[s]"""
    memory: int = 0
    """most memory of the process that read them [bytes]"""
    failures: list[Failure] = field(default_factory=list)

    def kinds(self) -> Counter[str]:
        """How many failures there are of each kind."""
        return Counter(failure.kind for failure in self.failures)


@dataclass
class _Worker:
    process: Any
    connection: Connection
    jobs: list[Job]
    """that are left, the next one last"""
    current: Job | None = None
    since: float = 0.0

    spent: float = 0.0
    """processor time at the start of the current file [s]"""

    def is_late(self, longest: float) -> bool:
        """Whether it has read one file for too long: in processor time, or six times
        longer by the clock, as others may use the machine too."""
        if self.current is None:
            return False
        waited = time.monotonic() - self.since
        if waited <= longest:
            return False
        return waited > 6.0 * longest or self.processor_time() - self.spent > longest

    def processor_time(self) -> float:
        """Of the process so far [s]; 0 where it has ended."""
        try:
            text = Path(f"/proc/{self.process.pid}/stat").read_text()
        except OSError:
            return 0.0
        fields = text.rpartition(")")[2].split()
        return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Fuzzer:
    """How jobs are run: by `run`, each for at most `longest` seconds."""

    seed: int
    folder: Path
    """where what is read beside the files is, and their seeds"""
    run: Run | None = None
    """by default `run_case`"""
    longest: float = LONGEST
    most_files: int = FILES_OF_A_PROCESS

    def outcomes(
        self, jobs: list[Job], count: int = 1
    ) -> Generator[tuple[Job, tuple], None, None]:
        """Outcomes of the jobs as they come, of `count` processes.

        An outcome is the status, the kind of a failure (empty for none), its details,
        the time [s] and the most memory of the process [bytes].
        """
        shares = [jobs[i::count][::-1] for i in range(count)]
        workers = [self._start(share) for share in shares if share]
        try:
            yield from self._watch(workers)
        finally:
            for worker in workers:
                worker.process.kill()
                worker.process.join()

    def _watch(self, workers: list[_Worker]) -> Iterator[tuple[Job, tuple]]:
        """Outcomes of `workers`, which become fewer; one that hangs or dies is
        replaced."""
        while workers:
            ready = wait([worker.connection for worker in workers], timeout=0.5)
            for worker in list(workers):
                late = worker.is_late(self.longest)
                if worker.connection in ready:
                    late, ended = False, not (yield from _receive(worker))
                else:
                    ended = late
                if not ended:
                    continue
                worker.process.kill()
                worker.process.join()
                workers.remove(worker)
                if worker.jobs:
                    workers.append(self._start(worker.jobs))
                if worker.current:
                    kind = "hang" if late else f"crash ({worker.process.exitcode})"
                    yield worker.current, (-1, kind, "", self.longest, 0)

    def _start(self, jobs: list[Job]) -> _Worker:
        mine, theirs = multiprocessing.Pipe()
        context = multiprocessing.get_context("spawn")
        process = context.Process(
            target=_work, args=(theirs, jobs[::-1], self), daemon=True
        )
        process.start()
        theirs.close()
        return _Worker(process, mine, jobs)


def _receive(worker: _Worker) -> Generator[tuple[Job, tuple], None, bool]:
    """Take what a worker says, that it begins a file or what came of it; whether it
    said anything."""
    try:
        said = worker.connection.recv()
    except (EOFError, OSError):
        worker.process.join()
        return False
    if said is None:
        worker.current, worker.since = worker.jobs.pop(), time.monotonic()
        worker.spent = worker.processor_time()
    else:
        assert worker.current is not None
        done, worker.current = worker.current, None
        yield done, said
    return True


def _work(connection: Connection, jobs: list[Job], fuzzer: Fuzzer) -> None:
    """Read the files of some jobs, in a process of its own."""
    import pickle

    from benchmarks.memory import peak

    folder, run = fuzzer.folder, fuzzer.run or run_case
    seeds = pickle.loads((folder / "seeds.pickle").read_bytes())
    if run is run_case:
        _import_all(folder)
    _limit_memory()
    place = Path(tempfile.mkdtemp(dir=folder))
    os.dup2(os.open(place.with_suffix(".err"), os.O_CREAT | os.O_WRONLY), 2)
    for name, index in jobs[: fuzzer.most_files]:
        connection.send(None)
        began = time.monotonic()
        said = os.fstat(2).st_size
        outcome = run(name, seeds[name], fuzzer.seed, index, folder, place)
        if os.fstat(2).st_size > said and not outcome[1]:  # by a library in C
            outcome = (outcome[0], "more on standard error", "")
        connection.send((*outcome, time.monotonic() - began, peak()))
    connection.close()


def _import_all(folder: Path) -> None:
    """Import all that is large, before the memory is limited."""
    from benchmarks.fuzzing.outcome import run_command

    for words in (
        ["identify", "static.csv", "--shape", "box.stl"],
        ["inspect", "log.parquet"],
        ["inspect", "log.mcap"],
    ):
        run_command([str(folder / word) if "." in word else word for word in words])


def run_case(
    name: str, seeds: list, seed: int, index: int, folder: Path, place: Path
) -> tuple[int, str, str]:
    """Make one mutated file in `place`, which is emptied, and let commands read it:
    status of the first, kind of a failure (empty for none), and its details."""
    from benchmarks.fuzzing.outcome import run_command
    from benchmarks.fuzzing.readers import make_case

    case = make_case(name, seeds, seed, index, folder, place)
    shutil.rmtree(place, ignore_errors=True)
    for file, data in {**case.seed.beside, case.seed.name: case.data}.items():
        (place / file).parent.mkdir(parents=True, exist_ok=True)
        (place / file).write_bytes(data)
    first = None
    for words in case.commands:
        outcome = run_command(words)
        first = outcome if first is None else first
        if outcome.failure:
            shown = " ".join(words)[:500]
            return outcome.status, outcome.failure, f"{shown}\n{outcome.details}"
        if outcome.status:
            break
    assert first is not None
    return first.status, "", ""


def _limit_memory() -> None:
    """Let this process grow to `MEMORY`: what is mapped and not used does not count."""
    mapped, resident = (
        int(number) * resource.getpagesize()
        for number in Path("/proc/self/statm").read_text().split()[:2]
    )
    limit = mapped - resident + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

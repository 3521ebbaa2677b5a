"""Processes that run tests of a copy of the sources, each forked from one that has
imported everything but the library itself."""

import importlib
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

ROOT = Path(__file__).resolve().parents[2]

IMPORTED = (
    "coverage",
    "hypothesis",
    "numpy.testing",
    "pytest",
    "scipy.interpolate",
    "scipy.linalg",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.signal",
    "scipy.sparse.linalg",
    "scipy.spatial.transform",
    "scipy.special",
    "scipy.stats",
    "trimesh",
)
"""Imported once: what takes long, and starts no thread."""

PYTEST = (
    *("-p", "no:cacheprovider"),
    *("-p", "no:xdist"),
    *("-W", "ignore::pytest.PytestAssertRewriteWarning"),
)
"""Options of pytest in these processes; it runs several times in one."""

MEMORY = 8 * 2**30
"""Most memory of a process [bytes]."""

ASLEEP = 20.0
"""Times the longest processor time after which a process that does nothing is ended."""

Task = TypeVar("Task")
Run = Callable[[Task, "Slot"], Any]


@dataclass
class Slot:
    """A place for one process at a time, with its own copy of the sources."""

    folder: Path
    niceness: int
    started: float = 0.0
    running: Any = None
    restore: dict[Path, tuple[bytes, float]] = field(default_factory=dict)

    @property
    def sources(self) -> Path:
        """The copy."""
        return self.folder / "src"

    @property
    def report(self) -> Path:
        """What the process gives, as JSON."""
        return self.folder / "report.json"

    def write(self, file: str, text: bytes) -> None:
        """Change a file of the copy until the process has ended."""
        path = self.sources / file
        self.restore[path] = path.read_bytes(), path.stat().st_mtime
        path.write_bytes(text)

    def tidy(self) -> None:
        """Undo all changes, and end what the process left running."""
        for path, (text, written) in self.restore.items():
            path.write_bytes(text)
            os.utime(path, (written, written))
            for compiled in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):
                compiled.unlink()
        self.restore.clear()
        shutil.rmtree(self.folder / "tmp", ignore_errors=True)


def forked(
    tasks: Iterable[Task],
    prepare: Callable[[Task, Slot], None],
    run: Run,
    jobs: int,
    longest: float,
) -> Iterator[tuple[Task, Any, float]]:
    """Run each task in a process of its own, `jobs` at a time: task, what it gave (None
    where the process died or took more than `longest` s) and processor time [s]."""
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"
    for recordings in ("HEFTING_DATA", "HEFTING_TORQUES"):
        os.environ.pop(recordings, None)  # what not everybody has
    for name in IMPORTED:
        importlib.import_module(name)
    with tempfile.TemporaryDirectory(prefix="hefting-mutants-") as place:
        free = [_slot(Path(place) / str(n), 10 if n else 0) for n in range(jobs)]
        busy: dict[int, tuple[Task, Slot]] = {}
        waiting = iter(tasks)
        try:
            while True:
                while free and (task := next(waiting, None)) is not None:
                    slot = free.pop()
                    prepare(task, slot)
                    busy[_fork(task, slot, run, longest)] = (task, slot)
                if not busy:
                    return
                process, seconds = _wait(busy, longest)
                task, slot = busy.pop(process)
                given = None
                if slot.report.exists():
                    given = json.loads(slot.report.read_bytes())
                    if "error" in given:
                        raise RuntimeError(given["error"])
                slot.tidy()
                free.append(slot)
                yield task, given, seconds
        finally:
            for process in busy:
                _end_group(process)


def _slot(folder: Path, niceness: int) -> Slot:
    shutil.copytree(
        ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__")
    )
    return Slot(folder, niceness)


def _fork(task: Task, slot: Slot, run: Run, longest: float) -> int:
    """Start a task; the number of its process."""
    slot.report.unlink(missing_ok=True)
    slot.started = time.monotonic()
    sys.stdout.flush()
    if process := os.fork():
        return process
    try:
        os.setpgid(0, 0)
        os.nice(slot.niceness)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (int(longest), int(longest)))
        log = os.open(slot.folder / "log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for stream in (1, 2):
            os.dup2(log, stream)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.chdir(ROOT)
        os.environ["PYTHONPATH"] = str(slot.sources)
        sys.path[:0] = [str(slot.sources), str(ROOT)]
        (slot.folder / "tmp").mkdir(exist_ok=True)
        tempfile.tempdir = os.environ["TMPDIR"] = str(slot.folder / "tmp")
        given = run(task, slot)
        partial = slot.report.with_suffix(".partial")
        partial.write_text(json.dumps(given))
        partial.rename(slot.report)
    except Exception:
        slot.report.write_text(json.dumps({"error": traceback.format_exc()}))
    finally:
        os._exit(0)


def _wait(busy: dict[int, tuple[Any, Slot]], longest: float) -> tuple[int, float]:
    """Wait for a process to end, or end one that takes too long."""
    while True:
        for process, (_, slot) in busy.items():
            late = time.monotonic() - slot.started > ASLEEP * longest
            if late:
                os.kill(process, signal.SIGKILL)
            ended, _, usage = os.wait4(process, 0 if late else os.WNOHANG)
            if ended:
                _end_group(process)
                return process, usage.ru_utime + usage.ru_stime
        time.sleep(0.01)


def _end_group(process: int) -> None:
    """End a process and those it started."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process, signal.SIGKILL)

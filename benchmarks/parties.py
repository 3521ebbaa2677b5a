"""Who is compared: this code, the code before it, and the naive script; each in
processes of its own."""

import io
import json
import os
import subprocess
import sys
import tarfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
HERE = ROOT / "benchmarks"
COMMIT = "c8b1b2c20255b1b24b2557da561748419832eb72"
"""What came before."""
ONE_THREAD = {
    f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "RAYON")
}


class MissingError(Exception):
    """Somebody to compare with is not here; the message says why."""


@dataclass(frozen=True)
class Took:
    """What one process took."""

    cpu: float
    """user and system time of the process [s]"""
    wall: float
    """[s]"""
    peak: int
    """resident memory [bytes]"""
    said: str
    """its output"""


@dataclass(frozen=True)
class Party:
    """Code to run."""

    name: str
    source: Path | None = None
    """folder of the package; None for code that needs none"""

    def run(self, *arguments: str) -> Took:
        """Run ``python ARGUMENTS`` in an empty folder, on one thread; `RuntimeError`
        with what it said if it fails."""
        environment = {
            k: v
            for k, v in os.environ.items()
            if k not in ("PYTHONPATH", "PYTHONDONTWRITEBYTECODE")
        }
        if self.source is not None:
            environment["PYTHONPATH"] = str(self.source)
        with TemporaryDirectory() as folder:
            output = Path(folder) / "output"
            launcher = [
                sys.executable,
                "-I",
                "-S",
                str(HERE / "launched.py"),
                str(output),
            ]
            done = subprocess.run(
                [*launcher, sys.executable, *arguments],
                cwd=folder,
                env=environment | ONE_THREAD,
                capture_output=True,
                text=True,
                check=True,
            )
            took: dict[str, Any] = json.loads(done.stdout)
            said = output.read_text(errors="replace")
        if took.pop("code") != 0:
            raise RuntimeError(f"{self.name}: python {' '.join(arguments)}\n{said}")
        return Took(said=said, **took)

    def warm_up(self) -> None:
        """Have its code compiled; `RuntimeError` unless it is that of `source` that
        runs."""
        if self.source is None:
            return
        subprocess.run(
            [sys.executable, "-m", "compileall", "-q", str(self.source)], check=True
        )
        found = self.run("-c", "import hefting; print(hefting.__file__)").said.strip()
        if not Path(found).resolve().is_relative_to(self.source.resolve()):
            raise RuntimeError(f"{self.name} is {found}, not {self.source}")


NOW = Party("now", ROOT / "src")
NAIVE = Party("naive")


def before(folder: Path, given: Path | None = None) -> Party:
    """The code before: that of `COMMIT` in the history, put in `folder`, or a checkout
    that is given.

    Raises `MissingError` where the history does not have it.
    """
    if given is not None:
        if not (given / "src" / "hefting").is_dir():
            raise MissingError(f"{given} holds no src/hefting")
        return Party("before", given / "src")
    command = ["git", "-C", str(ROOT), "archive", "--format=tar", COMMIT, "src"]
    try:
        done = subprocess.run(command, capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        why = f"commit {COMMIT[:7]} is not in this clone's history (a shallow clone?): nothing beside the code before"
        raise MissingError(why) from None
    folder.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
        archive.extractall(folder, filter="data")
    return Party("before", folder / "src")


def naive() -> Party:
    """The naive script; `MissingError` without what it needs."""
    for module in ("pandas", "pinocchio"):
        if find_spec(module) is None:
            raise MissingError(
                f"{module} is not installed: nothing beside the naive script"
            )
    return NAIVE

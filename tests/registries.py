"""A copy of the package to which something is added as a contributor would: one file,
and at most one line."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import hefting

PACKAGE = Path(hefting.__file__).parent


class Copy:
    """A copy of the package in a folder; the package itself is left alone.

    Parameters
    ----------
    folder : existing, for a test of its own; the copy is in ``folder/hefting``.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        shutil.copytree(
            PACKAGE, folder / "hefting", ignore=shutil.ignore_patterns("__pycache__")
        )

    def add(self, file: str, text: str) -> None:
        """A new file of the package."""
        path = self.folder / "hefting" / file
        assert not path.exists()
        path.write_text(text)

    def add_line(self, file: str, after: str, line: str) -> None:
        """A line in a file, after the only one that is `after`."""
        path = self.folder / "hefting" / file
        lines = path.read_text().splitlines()
        (place,) = (k for k, found in enumerate(lines) if found == after)
        path.write_text(
            "\n".join([*lines[: place + 1], line, *lines[place + 1 :]]) + "\n"
        )

    def python(self, *words: object) -> str:
        """What Python prints with the copy first on its path."""
        path = os.pathsep.join((str(self.folder), os.environ.get("PYTHONPATH", "")))
        command = [sys.executable, *map(str, words)]
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=os.environ | {"PYTHONPATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def hefting(self, *words: object) -> str:
        """What a command of the copy prints."""
        return self.python("-m", "hefting", *words)

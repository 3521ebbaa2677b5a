"""A copy of the package to which something is added as a contributor would: one file,
and at most one line."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import hefting

PACKAGE = Path(hefting.__file__).parent
EACH = """
import contextlib, io, json, sys

from hefting.cli import main

said = []
for words in json.loads(sys.argv[1]):
    sys.argv, out = ["hefting", *words], io.StringIO()
    with contextlib.redirect_stdout(out):
        try:
            main()
        except SystemExit as stop:
            if stop.code:
                raise
    said.append(out.getvalue())
print(json.dumps(said))
"""


class Copy:
    """A copy of the package in a folder; the package itself is left alone.

    What is compiled is copied as well, and kept, so that not every process does it.

    Parameters
    ----------
    folder : existing, for a test of its own; the copy is in ``folder/hefting``.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        shutil.copytree(PACKAGE, folder / "hefting")

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
        environment = os.environ | {"PYTHONPATH": path}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        command = [sys.executable, *map(str, words)]
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def hefting(self, *words: object) -> str:
        """What a command of the copy prints."""
        return self.python("-m", "hefting", *words)

    def hefting_each(self, *commands: tuple[object, ...]) -> list[str]:
        """What several commands of the copy print, one after the other in one
        process."""
        given = json.dumps([list(map(str, words)) for words in commands])
        return json.loads(self.python("-c", EACH, given))

"""Clean environments: a wheel, and of what is installed here only what it asks for."""

import os
import subprocess
import venv
import zipfile
from email.message import Message
from email.parser import Parser
from functools import cache
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
RUNNER = Path(str(distribution("pip").locate_file("pip/__pip-runner__.py")))


def metadata_of(wheel: Path) -> Message:
    """What a wheel says of itself."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith("dist-info/METADATA"))
        return Parser().parsestr(archive.read(name).decode())


def needed(requires: list[str], extra: str = "") -> set[str]:
    """Names of the distributions that are asked for, and those that they ask for."""
    found: set[str] = set()
    waiting = [(text, frozenset((extra,))) for text in requires]
    while waiting:
        text, extras = waiting.pop()
        asked = Requirement(text)
        wanted = [{"extra": each} for each in (*extras, "")]
        if asked.marker is not None and not any(map(asked.marker.evaluate, wanted)):
            continue
        name = canonicalize_name(asked.name)
        if name not in found or asked.extras:
            found.add(name)
            own = distribution(name).requires or ()
            waiting += [(each, frozenset(asked.extras)) for each in own]
    return found


@cache
def unpacked(wheel: Path) -> Path:
    """A folder beside a wheel of Python alone with what it installs, for all environments
    to link to."""
    folder = wheel.parent / "unpacked"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


class Environment:
    """An environment in a folder with links to what a wheel installs, and to what it
    needs with an extra."""

    def __init__(self, folder: Path, wheel: Path, extra: str = ""):
        venv.create(folder, symlinks=True)
        self.python = folder / "bin" / "python"
        (packages,) = folder.glob("lib/python*/site-packages")
        requires = metadata_of(wheel).get_all("Requires-Dist", [])
        for name in needed(requires, extra):
            for entry in entries(name):
                link = packages / entry.name
                if not link.exists():
                    link.symlink_to(entry)
        for entry in unpacked(wheel).iterdir():
            (packages / entry.name).symlink_to(entry)

    def check(self) -> str:
        """What ``pip --python ... check`` says, by the script which that starts there."""
        command = [str(self.python), str(RUNNER), "check"]
        return subprocess.run(command, capture_output=True, text=True).stdout

    def run(self, *words: object, cwd: Path) -> "subprocess.CompletedProcess[str]":
        """Python with these words, and nothing from outside the environment."""
        kept = ("PATH", "HOME", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
        own = {name: os.environ[name] for name in kept if name in os.environ}
        command = [str(self.python), "-I", *map(str, words)]
        return subprocess.run(
            command, cwd=cwd, env=own, capture_output=True, text=True, timeout=100
        )


@cache
def entries(name: str) -> set[Path]:
    """The files and folders of a distribution at the top of where packages are, which
    thousands of lines of its record tell."""
    own = distribution(name)
    place = Path(str(own.locate_file("")))
    tops = {file.parts[0] for file in own.files or ()} - {"..", "__pycache__"}
    return {place / top for top in tops}

"""Install locked requirements by two processes at once: most of the time goes into unpacking, on one processor."""

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

PROCESSES = 2
PIP = [
    *(sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"),
    *("--require-hashes", "--no-deps"),
    "--no-compile",  # what is imported is compiled then: of many packages most is not
]


def requirements(path: Path) -> list[str]:
    """Each requirement of a file, with the lines that go on with its hashes."""
    found: list[str] = []
    for line in path.read_text().splitlines(keepends=True):
        if line[0].isspace():
            found[-1] += line
        else:
            found.append(line)
    return found


def install(path: Path) -> int:
    """Exit status of the first process that failed; 0 where none did."""
    every = requirements(path)
    with TemporaryDirectory() as folder:
        started = []
        for i in range(PROCESSES):
            part = Path(folder, f"{i}.txt")
            part.write_text("".join(every[i::PROCESSES]))
            started.append(subprocess.Popen([*PIP, "-r", part]))
        return next(filter(None, [process.wait() for process in started]), 0)


if __name__ == "__main__":
    sys.exit(install(Path(sys.argv[1])))

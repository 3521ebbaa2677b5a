"""Resolve pyproject.toml to exact versions with hashes, for every platform: run.txt (demo) and dev.txt (the rest)."""

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
COMPILE = [
    "pip",
    "compile",
    "--universal",
    "--generate-hashes",
    "--python-version",
    "3.11",
    "--no-header",
    "--quiet",
]


def lock(name: str, *arguments: str) -> None:
    """Write requirements/`name`."""
    uv = Path(sys.executable).with_name("uv")
    command = [
        uv,
        *COMPILE,
        "--no-emit-index-url",
        "--no-annotate",
        "--upgrade",
        *arguments,
        "-o",
        HERE / name,
    ]
    subprocess.run(command, check=True, cwd=HERE.parent)


if __name__ == "__main__":
    lock("run.txt", "pyproject.toml", "requirements/build.in", "--extra", "plot")
    extras = [
        word
        for extra in ("plot", "ros", "sim", "view", "live", "batch", "docs")
        for word in ("--extra", extra)
    ]
    sources = ["pyproject.toml", "requirements/build.in", "--group", "dev"]
    # of example-robot-data only files are read: what it asks for builds C++, and is LGPL
    without = ("--no-emit-package", "jrl-cmakemodules")
    lock("dev.txt", *sources, *extras, *without, "-c", "requirements/run.txt")

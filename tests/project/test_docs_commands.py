"""The commands of the docs' pages are run as written, page by page, where the files are
that they name."""

import re
import shlex
from pathlib import Path
from shutil import copy, copytree

import pytest

from documented_files import make
from hasty_pictures import draw_hastily
from jobs_here import understand_here
from plans import search_briefly

pytestmark = pytest.mark.usefixtures("same_commands")

FOLDER = Path(__file__).parents[2] / "docs"
ELSEWHERE = {"batch", "extending", "tutorial"}
"""Pages with tests of their own that run their commands."""
PAGES = sorted(
    path
    for part in (".", "howto", "concepts")
    for path in FOLDER.glob(f"{part}/*.md")
    if path.stem not in ELSEWHERE and "```sh\n" in path.read_text()
)
SERVERS = re.compile(
    r"hefting (live (rtde|ws)://|view (?!.*--save)|reproduce (?!--list))"
)
"""Commands that wait for a robot or a reader, or take minutes: other tests run them."""
NOT_TO_BE_USED = {"hefting identify log.csv --sensor-accuracy UR5e"}
"""Of half a kilogram such a sensor tells nothing: exit status 3."""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("documented")
    make(folder)
    return folder


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_commands_run_as_written(page, files, tmp_path, monkeypatch, run):
    folder = tmp_path / "files"
    copytree(files, folder)
    monkeypatch.chdir(folder)
    draw_hastily(monkeypatch)
    understand_here(monkeypatch)
    search_briefly(monkeypatch)
    text = page.read_text()
    for language, block in re.findall(r"```(sh|toml)\n(.*?)```", text, flags=re.DOTALL):
        if language == "toml":
            Path("map.toml").write_text(block)
            continue
        source = "log.csv"
        if "--map" in block:
            source = "franka.csv"
        elif "log.csv --urdf" in block:
            source = "joints.csv"
        elif "--bias tare" in block:
            source = "picked-up.csv"
        copy(files / source, "log.csv")
        if "--sensor-pose-in-log" in block:
            for name in ("empty.csv", "held.csv"):
                copy(files / f"marker-{name}", name)
        for line in block.splitlines():
            if SERVERS.match(line):
                continue
            words = shlex.split(line)[1:]
            if words[0] == "plan":
                words += ["--quick"]  # a brief search shows that it works
                words += [] if "--until" in words else ["--duration", "4"]
            status, _, err = run(*words)
            assert status == (3 if line in NOT_TO_BE_USED else 0), (line, err)

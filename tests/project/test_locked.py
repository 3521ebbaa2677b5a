"""Locked requirements: installed by several processes, of which none may fail unseen."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
INSTALL = runpy.run_path(str(ROOT / "requirements" / "install.py"))


@pytest.mark.parametrize("name", ["run.txt", "dev.txt"])
def test_each_requirement_keeps_its_hashes(name):
    path = ROOT / "requirements" / name
    found = INSTALL["requirements"](path)
    assert "".join(found) == path.read_text()
    assert all("==" in each.splitlines()[0] for each in found)
    assert all("--hash=sha256:" in each for each in found)


@pytest.mark.parametrize("wrong", [0, 1])
def test_what_cannot_be_installed_by_one_of_them_is_a_failure(wrong, tmp_path, capfd):
    """Without a hash pip asks nobody for it."""
    path = tmp_path / "wrong.txt"
    lines = ["# nothing\n"] * 2
    lines[wrong] = "hefting==1\n"
    path.write_text("".join(lines))
    assert INSTALL["install"](path) != 0
    assert "hefting==1" in capfd.readouterr().err

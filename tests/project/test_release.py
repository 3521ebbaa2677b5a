"""What a release rests on: one version everywhere, and a changelog that is kept."""

import subprocess
import sys

import pytest

import hefting
from project.environments import ROOT

GATE = ROOT / ".github" / "changelog.py"


def run(*words, cwd=ROOT):
    command = [sys.executable, *map(str, words)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True)


def test_the_citation_has_the_version_of_the_package():
    assert f"\nversion: {hefting.__version__}\n" in (ROOT / "CITATION.cff").read_text()


@pytest.fixture
def project(tmp_path):
    """A repository of one commit, with the gate."""
    files = {
        ".github/changelog.py": GATE.read_text(),
        "src/hefting/__init__.py": '__version__ = "1.2.0"\n',
        "CITATION.cff": "version: 1.2.0\n",
        "CHANGELOG.md": "## Unreleased\n\n## 1.2.0 (2026-01-02)\n",
    }
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    for words in (["init", "-q"], ["add", "-A"]):
        subprocess.run(["git", *words], cwd=tmp_path, check=True)
    commit(tmp_path)
    return tmp_path


def commit(folder):
    who = ["-c", "user.name=a", "-c", "user.email=a@b.c"]
    words = ["git", *who, "commit", "-qam", "change"]
    subprocess.run(words, cwd=folder, check=True)


@pytest.mark.parametrize(
    ("changed", "passes"),
    [
        (["src/hefting/__init__.py"], False),
        (["src/hefting/__init__.py", "CHANGELOG.md"], True),
        (["CITATION.cff"], True),
    ],
)
def test_a_change_of_the_package_is_told(project, changed, passes):
    for name in changed:
        with (project / name).open("a") as file:
            file.write("# more\n")
    commit(project)
    done = run(project / ".github/changelog.py", "HEAD~1", cwd=project)
    assert (done.returncode == 0) == passes
    assert passes or "CHANGELOG.md did not" in done.stderr


@pytest.mark.parametrize(
    "name", ["CITATION.cff", "CHANGELOG.md", "src/hefting/__init__.py"]
)
def test_a_release_has_one_version(project, name):
    gate = project / ".github/changelog.py"
    assert run(gate, "--version", "1.2.0").returncode == 0
    path = project / name
    path.write_text(path.read_text().replace("1.2.0", "1.1.0"))
    done = run(gate, "--version", "1.2.0")
    assert done.returncode == 1
    assert f"{name} says version 1.1.0, not 1.2.0" in done.stderr

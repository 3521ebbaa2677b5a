"""The changelog's gate: ``changelog.py BASE`` fails where the package changed since the
commit BASE and CHANGELOG.md did not; ``changelog.py --version X`` fails unless X is the
version of the package, of CITATION.cff, and of the newest section with a date."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def main(words: list[str]) -> str | None:
    """What is wrong, if anything is."""
    if words[:1] == ["--version"]:
        return _wrong_version(words[1])
    command = ["git", "diff", "--name-only", f"{words[0]}...HEAD"]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    changed = done.stdout.split()
    told = "CHANGELOG.md" in changed
    if told or not any(name.startswith("src/") for name in changed):
        return None
    return "src/ changed and CHANGELOG.md did not: say under Unreleased what users see"


def _wrong_version(version: str) -> str | None:
    """Where another version is said."""
    patterns = {
        "src/hefting/__init__.py": r'^__version__ = "(.+)"$',
        "CITATION.cff": r"^version: (.+)$",
        "CHANGELOG.md": r"^## (\d\S*)",
    }
    for name, pattern in patterns.items():
        found = re.search(pattern, (ROOT / name).read_text(encoding="utf-8"), re.M)
        said = found and found.group(1)
        if said != version:
            return f"{name} says version {said}, not {version}"
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

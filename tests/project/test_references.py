"""Names of modules, classes and functions in docstrings, comments and pages lead to
what they name."""

import importlib
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
FILES = sorted(
    [
        *(
            path
            for folder in ("src", "benchmarks")
            for path in (ROOT / folder).rglob("*.py")
        ),
        *(
            path
            for part in (".", "howto", "concepts")
            for path in (ROOT / "docs").glob(f"{part}/*.md")
        ),
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
    ]
)
REFERENCE = re.compile(r"`+((?:hefting|benchmarks)(?:\.\w+)+)`+")
"""A dotted name in backquotes."""


def resolves(dotted: str) -> bool:
    """Whether a dotted name is a module, or an attribute of one, or of a class in
    one."""
    parts = dotted.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:cut]))
        except ImportError:
            continue
        for name in parts[cut:]:
            if name in getattr(found, "__dataclass_fields__", ()):
                return True
            if not hasattr(found, name):
                return False
            found = getattr(found, name)
        return True
    return False


def test_references_lead_somewhere():
    named = {
        (str(path.relative_to(ROOT)), name)
        for path in FILES
        for name in REFERENCE.findall(path.read_text())
    }
    led = {name: resolves(name) for name in {name for _, name in named}}
    wrong = sorted((path, name) for path, name in named if not led[name])
    assert len(FILES) > 500
    assert wrong == []


def test_a_wrong_reference_is_seen():
    assert resolves("hefting.core.spatial.Array")
    assert resolves("hefting.Estimate.load")
    assert not resolves("hefting.nowhere")
    assert not resolves("hefting.core.spatial.nothing")

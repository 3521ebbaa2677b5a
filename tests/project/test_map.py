"""The map in CONTRIBUTING is complete and says what the packages say of themselves; its
ten changes name real files."""

import ast
import re
from pathlib import Path

from test_conventions import LAYERS, part

import hefting

ROOT = Path(__file__).parents[2]
SOURCE = Path(hefting.__file__).parent
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text()
MOST_FILES = 4
"""Files that a change may touch, besides its tests and the changelog."""


def rows(heading: str) -> list[list[str]]:
    """Cells of the first table under a heading, without its head."""
    section = CONTRIBUTING.split(f"## {heading}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def summary(package: Path) -> str:
    """First sentence of a package's docstring, without its name."""
    text = ast.get_docstring(ast.parse((package / "__init__.py").read_text())) or ""
    line = " ".join(text.split("\n\n")[0].split())
    return line.removesuffix(".").partition(": ")[2]


def test_the_map_is_complete_and_in_the_order_of_the_flow():
    parts = {part(path) for path in SOURCE.rglob("*.py")} - {"", "__main__"}
    expected = [
        [f"`{name}/`", summary(SOURCE / name)]
        for layer in LAYERS
        for name in layer
        if name in parts
    ]
    table = rows("Where things are")
    assert sorted(table) == sorted(expected), "\n".join(
        f"| {' | '.join(row)} |" for row in expected
    )
    heights = {name: height for height, layer in enumerate(LAYERS) for name in layer}
    order = [heights[row[0].strip("`/")] for row in table]
    assert order == sorted(order)


def test_the_changes_name_files_that_exist_and_few_of_them():
    changes = rows("Where a change goes")
    assert len(changes) >= 10
    for what, files in changes:
        named = re.findall(r"`([^`]+)`", files)
        assert named, what
        assert len(named) <= MOST_FILES, what
        for name in named:
            pattern = re.sub(r"<\w+>", "*", name)
            assert list(ROOT.glob(pattern)) or list(SOURCE.glob(pattern)), (
                f"{what}: {name}"
            )

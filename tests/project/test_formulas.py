"""docs/formulas.md: a row for every numbered equation of the paper, whose code and test
exist."""

import ast
import re
from pathlib import Path

import pytest
from test_references import resolves

ROOT = Path(__file__).parents[2]
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in (ROOT / "docs" / "formulas.md").read_text().splitlines()
    if line.startswith("|") and "::" in line
]
EQUATIONS = 19
"""Numbered equations of the paper: twelve, and seven of its appendix."""


def test_every_equation_has_a_row():
    numbers = [int(row[0]) for row in ROWS if row[0].isdigit()]
    assert numbers == list(range(1, EQUATIONS + 1))


@pytest.mark.parametrize("row", ROWS, ids=lambda row: " ".join(row[:-2]))
def test_code_and_test_exist(row):
    code, test = (re.findall(r"`([^`]+)`", cell) for cell in row[-2:])
    assert code
    assert all(resolves(name) for name in code)
    (place,) = test
    file, name = place.split("::")
    tree = ast.parse((ROOT / file).read_text())
    assert name in {
        node.name for node in tree.body if isinstance(node, ast.FunctionDef)
    }

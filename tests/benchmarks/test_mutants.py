"""Mutation tests, themselves tested on a package of a few lines."""

import ast
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from benchmarks.mutants import candidates, draw
from benchmarks.mutation.choice import PACKAGES
from benchmarks.mutation.forks import IMPORTED
from benchmarks.mutation.mutate import find_mutants
from benchmarks.mutation.operators import BOUNDARY, OPPOSITE
from benchmarks.mutation.page import still_there

ROOT = Path(__file__).resolve().parents[2]

SOURCE = '''
"""Double, and 3 + 4."""
from typing import TYPE_CHECKING

__all__ = ["double"]
CHUNK = 100
LIMIT = 5.0

if TYPE_CHECKING:
    ONE = 1 + 1


def double(numbers: list[int]) -> "int | None":
    """Twice the sum: 2 * 3."""
    if len(numbers) > 3:
        raise ValueError("more than" + str(3 + 1))
    total = 0
    for start in range(0, len(numbers), CHUNK):
        total += sum(numbers[start : start + CHUNK])
    if total < 0:
        return f"{total + 1}"
    return 2 * total
'''


@pytest.fixture
def sources(tmp_path):
    package = tmp_path / "small" / "part"
    package.mkdir(parents=True)
    (package / "one.py").write_text(SOURCE)
    return tmp_path


def test_what_is_mutated_and_what_is_not(sources):
    found = {m.change: m for m in find_mutants(sources, "small/part/one.py")}
    assert {
        "len(numbers) > 3 -> len(numbers) >= 3",
        "len(numbers) > 3 -> len(numbers) <= 3",
        "len(numbers) > 3 -> True",
        "len(numbers) > 3 -> len(numbers) > 4",
        "raise ValueError('more than' + str(3 + 1)) -> pass",
        "total += sum(numbers[start:start + CHUNK]) -> pass",
        "total += sum(numbers[start:start + CHUNK]) -> total -= "
        "sum(numbers[start:start + CHUNK])",
        "2 * total -> 2 / total",
        "5.0 -> 10.0",
    } <= set(found)
    for text in ("100", "ONE", "__all__", "1 + 1", "'more than' -", "4 ->", "f'"):
        assert not any(change.startswith(text) for change in found), text
    assert found["5.0 -> 10.0"].names == ("LIMIT",)


@pytest.mark.parametrize(
    "file", ["core/spatial.py", "estimators/timescales.py", "ingest/fit.py"]
)
def test_every_mutant_is_one_change_that_can_be_read(file):
    """Of a sample: the syntax tree differs, and nothing outside of the span."""
    drawn = draw(candidates([*PACKAGES], [file], None), 60, seed=3)
    assert len({mutant.key for mutant in drawn}) == len(drawn)
    source = (ROOT / "src" / drawn[0].file).read_bytes()
    tree = ast.dump(ast.parse(source))
    for mutant in drawn:
        changed = mutant.apply(source)
        assert ast.dump(ast.parse(changed)) != tree, mutant.key
        start, end = mutant.span
        assert changed[:start] == source[:start]
        assert changed[len(changed) - len(source) + end :] == source[end:]


def test_comparisons_become_others_and_back():
    for table in (OPPOSITE, BOUNDARY):
        assert all(
            table[table[kind]] is kind and kind is not table[kind] for kind in table
        )


def test_samples_are_the_same_for_the_same_seed():
    found = candidates(["core"], ["core/quantity.py"], None)
    assert draw(found, 5, 1) == draw(found, 5, 1) != draw(found, 5, 2)


SCRIPT = """
import sys
from pathlib import Path
from benchmarks.mutants import candidates
from benchmarks.mutation import choice, forks
from benchmarks.mutation.choice import TestMap
from benchmarks.mutation.run import failing_without, run_mutants

choice.PACKAGES = ("core",)
forks.IMPORTED = ("coverage", "pytest", "numpy.testing")  # no more is used
tests = TestMap(Path(sys.argv[1]), ["tests/core/test_rounding.py"], 1)
found = candidates(["core"], ["core/quantity.py"], "half")
found = [mutant for mutant in found if "1.0" in mutant.change]
outcomes = list(run_mutants(found, tests, 1, 20.0, {}))
assert not failing_without({o.test for o in outcomes if o.test}, 1)
for outcome in outcomes:
    print(outcome.killed, outcome.mutant.change)
"""


def test_mutants_are_killed_by_the_tests_that_execute_them(tmp_path):
    """In a process of its own, as it forks before the library is imported. What stands
    in for half-widths that are not known is not used; the one before it is noticed, so
    each is run on sources that have no other."""
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path / "map")],
        cwd=ROOT, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    file, *lines = done.stdout.splitlines()
    assert file.startswith("tests/core/test_rounding.py: 18 tests")
    assert lines == [
        "True half > 0.0 -> half > 1.0",
        "False np.where(known, half, 1.0) -> np.where(known, half, 2.0)",
        "True np.where(known, half, 1.0) -> np.where(known, half, -1.0)",
    ]


def test_reasons_of_mutants_that_are_gone_are_dropped(tmp_path):
    (tmp_path / "double.py").write_text(SOURCE)
    kept = find_mutants(tmp_path, "double.py")[-1].key
    reasons = {
        kept: ["open", ""],
        f"{kept} ": ["open", ""],
        "gone.py f: a -> b": ["open", ""],
    }
    assert list(still_there(reasons, tmp_path)) == [kept]


def test_what_is_imported_before_processes_part_can_be():
    assert all(find_spec(name) for name in IMPORTED)

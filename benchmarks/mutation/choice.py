"""Which tests may notice a mutant: those that execute its line, from a map that is made
once and kept."""

import ast
import hashlib
import itertools
import json
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.mutation.forks import ROOT, Slot, forked
from benchmarks.mutation.mutate import Mutant
from benchmarks.mutation.trace import trace_file

PACKAGES = ("core", "estimators", "ingest")
"""Folders of the library that are mutated."""

FOLDERS = (
    "core",
    "estimators",
    "ingest",
    "reference",
    "identification",
    "motion",
    "inspection",
    "prediction",
    "torques",
    "export",
    "shapes",
    "logs",
    "robots",
    "scene",
    "online",
    "planning",
    "simulation",
    "page",
    "cli",
)
"""Folders of tests that may notice mutants; others run whole programs, browsers or
published experiments."""

LEFT_OUT = (
    "page/test_report_browser.py",
    "page/test_batch_browser.py",
    "online/test_process.py",
    "online/test_pipeline.py",
    "planning/test_plan.py",
    "cli/test_live_command.py",
    "cli/test_view.py",
    "cli/test_pictures.py",
    "cli/test_cli_start.py",
    "cli/test_completion.py",
    "cli/test_streams.py",
)
"""Files of these folders that start programs or take long."""

LONGEST = 900.0
"""Longest that a test file may take [s]."""


Test = tuple[str, int]
"""A test file, and the number of a test in its map."""


@dataclass(frozen=True)
class Chosen:
    """Tests that run for a mutant, in order."""

    seconds: dict[str, float]
    """processor time of each, with what only it asks for [s]"""
    complete: bool
    """whether no test that executes the line was left out for want of time"""


class TestMap:
    """Tests by the lines that they execute."""

    __test__ = False

    def __init__(self, folder: Path, files: list[str], jobs: int):
        self.files = _measured(folder, files, jobs)
        self.uses = _uses()
        self.named = {
            f"{file}::{node.name}": {name for name, _ in _names(node)}
            for file in self.files
            for node in ast.parse((ROOT / file).read_bytes()).body
            if isinstance(node, ast.FunctionDef)
        }

    def tests_of(self, mutant: Mutant) -> tuple[set[Test], set[Test]]:
        """Tests that execute the mutant's line or, where it is executed on import, a
        line that uses its name; and tests that use the name themselves. Those that
        execute anything of its file, where none of these is known."""
        names, places = set(mutant.names), set()
        if not names:
            places = {(mutant.file, line) for line in mutant.lines}
        for name in mutant.names:
            names |= self.uses.users[name]
        for name in names:
            places |= self.uses.places[name]
        executing = self._executing(places)
        naming = {
            (file, number)
            for file, found in self.files.items()
            for number, test in enumerate(found["tests"] if names else ())
            if names & self.named.get(test.partition("[")[0], set())
        }
        if not executing and not naming:
            lines = {
                (mutant.file, int(line))
                for found in self.files.values()
                for line in found["lines"].get(mutant.file, {})
            }
            executing = self._executing(lines)
        return executing, naming

    def _executing(self, places: set[tuple[str, int]]) -> set[Test]:
        return {
            (file, number)
            for file, found in self.files.items()
            for source, line in places
            for number in _of_line(found, source, line)
        }

    def choose(self, mutant: Mutant, limit: float, first: str = "") -> Chosen:
        """The quickest of these tests, no more than `limit` s of them.

        All cases of the test `first`, which noticed it before, come first. Those that name a constant come
        before those that only use it, and the quickest case of each test before the
        other cases of any.
        """
        executing, naming = self.tests_of(mutant)
        costs = []
        for file, number in executing | naming:
            found = self.files[file]
            needs = {name: found["seconds"][name] for name in found["needs"][number]}
            apart = (file, number) not in naming
            costs.append((sum(needs.values()), found["tests"][number], apart, needs))
        costs.sort(key=lambda cost: cost[:2])
        cases: Counter[str] = Counter()
        order = []
        for cost, test, apart, needs in costs:
            function = test.partition("[")[0]
            other = function != first.partition("[")[0]
            order.append((other, apart, cases[function] > 0, cost, test, needs))
            cases[function] += 1
        chosen: dict[str, float] = {}
        spent: set[str] = set()
        total = 0.0
        for *_, test, needs in sorted(order, key=lambda each: each[:5]):
            new = sum(s for name, s in needs.items() if name not in spent)
            if chosen and total + new > limit:
                continue
            total += new
            spent.update(needs)
            chosen[test] = new
        return Chosen(chosen, len(chosen) == len(costs))


def _of_line(found: dict[str, Any], source: str, line: int) -> Iterable[int]:
    group = found["lines"].get(source, {}).get(str(line))
    return () if group is None else found["groups"][group]


def test_files() -> list[str]:
    """Test files that may notice mutants, relative to the repository."""
    return [
        str(path.relative_to(ROOT))
        for folder in FOLDERS
        for path in sorted((ROOT / "tests" / folder).glob("test_*.py"))
        if str(path.relative_to(ROOT / "tests")) not in LEFT_OUT
    ]


def _measured(folder: Path, files: list[str], jobs: int) -> dict[str, Any]:
    """What each test file executes: as kept in a folder, or measured where it, a file of
    its folder that it may use, or the sources have changed."""
    folder.mkdir(exist_ok=True)
    sources = hashlib.sha256()
    for path in sorted((ROOT / "src").rglob("*.py")):
        sources.update(path.read_bytes())
    kept, missing = {}, []
    for file in files:
        digest = sources.copy()
        for used in (ROOT / file, *_helpers((ROOT / file).parent)):
            digest.update(used.read_bytes())
        path = folder / f"{Path(file).stem}.json"
        found = json.loads(path.read_bytes()) if path.exists() else {}
        if found.get("digest") == digest.hexdigest():
            kept[file] = found
        else:
            missing.append((file, path, digest.hexdigest()))
    for (file, path, digest), found, seconds in forked(
        missing, lambda task, slot: None, _trace, jobs, LONGEST
    ):
        if found is None:
            print(f"{file}: left out, as it could not be measured", flush=True)
            continue
        print(f"{file}: {len(found['tests'])} tests, {seconds:.0f} s", flush=True)
        text = json.dumps({**found, "digest": digest})
        path.write_text(text)
        kept[file] = json.loads(text)
    return kept


def _helpers(folder: Path) -> list[Path]:
    """Files of a folder of tests that are no tests themselves."""
    return [p for p in sorted(folder.glob("*.py")) if not p.name.startswith("test_")]


def _trace(task: tuple[str, Path, str], slot: Slot) -> dict[str, Any]:
    return trace_file(task[0], slot.sources, list(PACKAGES))


@dataclass(frozen=True)
class _Uses:
    """Where names of the library are used."""

    places: dict[str, set[tuple[str, int]]]
    """file and line within functions"""
    users: dict[str, set[str]]
    """names that are made from a name on import, directly or through others"""


def _uses() -> _Uses:
    places: dict[str, set[tuple[str, int]]] = defaultdict(set)
    users: dict[str, set[str]] = defaultdict(set)
    for package in PACKAGES:
        for path in sorted((ROOT / "src/hefting" / package).rglob("*.py")):
            file = str(path.relative_to(ROOT / "src"))
            tree = ast.parse(path.read_bytes())
            for node in ast.walk(tree):
                if isinstance(node, ast.FunctionDef):
                    for part in node.body:
                        for name, line in _names(part):
                            places[name].add((file, line))
                    for name, _ in _names(node.args):  # defaults
                        places[name].add((file, node.body[-1].lineno))
            classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
            for node in itertools.chain(tree.body, *(each.body for each in classes)):
                if isinstance(node, ast.Assign | ast.AnnAssign) and node.value:
                    targets = getattr(node, "targets", None) or [node.target]
                    for target in targets:
                        if isinstance(target, ast.Name):
                            for name, _ in _names(node.value):
                                users[name].add(target.id)
    for name in list(users):
        left = list(users[name])
        while left:
            new = users.get(left.pop(), set()) - users[name]
            users[name] |= new
            left += new
    return _Uses(places, users)


def _names(node: ast.AST) -> Iterable[tuple[str, int]]:
    for inner in ast.walk(node):
        if isinstance(inner, ast.Name):
            yield inner.id, inner.lineno
        elif isinstance(inner, ast.Attribute):
            yield inner.attr, inner.lineno

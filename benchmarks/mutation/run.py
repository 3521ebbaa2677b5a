"""Whether tests notice a mutant: they run in a process of their own, on a copy of the
sources that has it, until the first one fails."""

import json
import signal
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from benchmarks.mutation.choice import Chosen, TestMap
from benchmarks.mutation.forks import PYTEST, Slot, forked
from benchmarks.mutation.mutate import Mutant

SLOWER = 10.0
"""A test that takes so many times as long as without the mutant is an endless loop."""

LEAST_TIME = 5.0
"""Processor time that every test may take [s]."""

FIRST = 4
"""Tests that run before the files of the others are even imported."""

MORE = 30
"""Tests that run before those of the files that are left are imported."""

LONGEST = 300.0
"""Longest that all tests of a mutant may take [s]."""


@dataclass(frozen=True)
class Outcome:
    """What came of a mutant."""

    mutant: Mutant
    killed: bool
    test: str
    """that noticed it; empty without"""
    how: str
    """failed, could not be imported, took too long; or that all passed, or none ran"""
    complete: bool
    """whether every test of the map that executes the line was tried"""
    tests: int
    seconds: float
    """processor time"""

    def as_json(self) -> dict[str, Any]:
        """All of it, as plain values."""
        return {
            "key": self.mutant.key,
            "package": self.mutant.package,
            "operator": self.mutant.operator,
            **{name: value for name, value in vars(self).items() if name != "mutant"},
        }


class Watch:
    """A pytest plugin: runs the given tests in the given order, each within a bound of
    processor time, and tells which fails."""

    def __init__(self, tests: dict[str, float], report: Path):
        self.tests, self.report = tests, report
        self.failed: list[str] = []

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items):
        """Keep the given tests."""
        order = {test: place for place, test in enumerate(self.tests)}
        items[:] = [item for item in items if item.nodeid in order]
        items.sort(key=lambda item: order[item.nodeid])

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item, nextitem):
        """Bound a test, and say that it is running, should it end the process."""
        running = {"test": item.nodeid, "how": "took too long, or ended the process"}
        self.report.write_text(json.dumps(running))
        longest = LEAST_TIME + SLOWER * self.tests[item.nodeid]
        signal.setitimer(signal.ITIMER_PROF, longest)
        try:
            return (yield)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)

    def pytest_runtest_logreport(self, report):
        """Note what fails."""
        if report.failed:
            self.failed.append(report.nodeid)


def run_mutants(
    mutants: list[Mutant],
    tests: TestMap,
    jobs: int,
    limit: float,
    known: dict[str, str],
) -> Iterator[Outcome]:
    """Run each mutant's tests, no more than `limit` s of them; `known` names, by key,
    tests that noticed mutants before, which come first."""
    tasks = []
    for mutant in mutants:
        chosen = tests.choose(mutant, limit, known.get(mutant.key, ""))
        if chosen.seconds:
            tasks.append((mutant, chosen))
        else:
            yield Outcome(mutant, False, "", "no test executes it", True, 0, 0.0)
    for (mutant, chosen), given, seconds in forked(tasks, _write, _run, jobs, LONGEST):
        given = given or {"test": "", "how": "ended the process"}
        yield Outcome(
            mutant=mutant,
            killed=given["how"] != "all passed",
            test=given["test"],
            how=given["how"],
            complete=chosen.complete,
            tests=len(chosen.seconds),
            seconds=round(seconds, 2),
        )


def failing_without(tests: set[str], jobs: int) -> set[str]:
    """Those of the tests that fail without any mutant: what they notice is nothing."""
    files = defaultdict(dict)
    for test in sorted(tests):
        files[test.split("::")[0]][test] = LONGEST
    failing: set[str] = set()
    for (_, chosen), given, _ in forked(
        [(None, chosen) for chosen in files.values()], _write, _run_all, jobs, LONGEST
    ):
        failing |= set(chosen) if given is None else set(given["failed"])
    return failing


def _write(task: tuple[Mutant | None, Any], slot: Slot) -> None:
    mutant = task[0]
    if mutant is not None:
        source = (slot.sources / mutant.file).read_bytes()
        slot.write(mutant.file, mutant.apply(source))


def _run(task: tuple[Mutant, Chosen], slot: Slot) -> dict[str, str]:
    seconds = task[1].seconds
    order = list(seconds)
    for part in (order[:FIRST], order[FIRST:MORE], order[MORE:]):
        if not part:
            break
        watch = Watch({test: seconds[test] for test in part}, slot.report)
        files = list(dict.fromkeys(test.split("::")[0] for test in part))
        status = pytest.main([*files, *PYTEST, "-x"], [watch])
        if watch.failed:
            return {"test": watch.failed[0], "how": "failed"}
        if status not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
            return {"test": part[0], "how": "could not be imported"}
    return {"test": "", "how": "all passed"}


def _run_all(task: tuple[None, dict[str, float]], slot: Slot) -> dict[str, list[str]]:
    watch = Watch(task[1], slot.report)
    files = list(dict.fromkeys(test.split("::")[0] for test in task[1]))
    pytest.main([*files, *PYTEST], [watch])
    return {"failed": watch.failed}

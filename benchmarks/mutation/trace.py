"""Which tests execute which lines: a pytest plugin, and the map that it makes of one
test file.

What a fixture of a file or a cached function did once counts for every test that uses
it.
"""

import functools
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from coverage import Coverage

from benchmarks.mutation.forks import PYTEST, ROOT

NEGLIGIBLE = 0.005
"""Processor time that is not kept [s]."""


class Trace:
    """A pytest plugin that gives each test, each wide fixture and each cached call its
    own coverage context."""

    def __init__(self, source: Path, packages: list[str]):
        self.source = source
        patterns = [f"{source}/hefting/{package}/*" for package in packages]
        self.coverage = Coverage(data_file=None, config_file=False, include=patterns)
        self.stack: list[str] = []
        self.uses: dict[str, set[str]] = defaultdict(set)
        self.seconds: dict[str, float] = defaultdict(float)
        self.passed: set[str] = set()
        self.last = time.process_time()

    @contextmanager
    def context(self, name: str) -> Iterator[None]:
        """What is executed and spent inside belongs to `name`, and whatever is under
        way depends on it."""
        if self.stack:
            self.uses[self.stack[-1]].add(name)
        self._switch(name, [*self.stack, name])
        try:
            yield
        finally:
            stack = self.stack[:-1]
            self._switch(stack[-1] if stack else "outside", stack)

    def _switch(self, name: str, stack: list[str]) -> None:
        now = time.process_time()
        if self.stack:
            self.seconds[self.stack[-1]] += now - self.last
        self.coverage.switch_context(name)
        self.stack = stack
        self.last = time.process_time()

    def remembering(self, original: Callable) -> Callable:
        """`functools.cache` or `lru_cache` for functions of the tests and of the
        library: each call is a context of its own."""
        own = (f"{ROOT}/tests/", f"{self.source}/")

        def decorate(function: Any = None, *options: Any, **named: Any) -> Any:
            if not callable(function):
                later = original(**named) if named else original(function)
                return lambda function: follow(function, later(function))
            return follow(function, original(function, *options, **named))

        def follow(function: Any, cached: Any) -> Any:
            code = getattr(function, "__code__", None)
            if code is None or not code.co_filename.startswith(own):
                return cached

            @functools.wraps(function)
            def call(*given: Any, **named: Any) -> Any:
                key = hash((given, tuple(sorted(named.items()))))
                with self.context(f"cache {function.__qualname__} {key}"):
                    return cached(*given, **named)

            for name in ("cache_clear", "cache_info"):
                setattr(call, name, getattr(cached, name))
            return call

        return decorate

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector):
        """What the import of a test file does."""
        with self.context(f"import {collector.nodeid}"):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef, request):
        """What a fixture of more than one test does."""
        if fixturedef.scope == "function":
            return (yield)
        with self.context(f"fixture {request.node.nodeid} {fixturedef.argname}"):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item, nextitem):
        """What a test does, and which fixtures it depends on."""
        for parent in item.listchain()[:-1]:
            self.uses[item.nodeid].add(f"import {parent.nodeid}")
            for name in item.fixturenames:
                self.uses[item.nodeid].add(f"fixture {parent.nodeid} {name}")
        with self.context(item.nodeid):
            return (yield)

    def pytest_runtest_logreport(self, report):
        """Keep the tests that pass."""
        if report.when == "call" and report.passed:
            self.passed.add(report.nodeid)

    def map(self) -> dict[str, Any]:
        """Tests that passed, processor time of what they depend on, and numbers of the
        tests by file of the source and line."""
        tests = sorted(self.passed)
        needs = [sorted(self._closure(test)) for test in tests]
        users = defaultdict(list)
        for number, names in enumerate(needs):
            for name in names:
                users[name].append(number)
        spent = {name: s for name, s in self.seconds.items() if s > NEGLIGIBLE}
        groups: dict[tuple[int, ...], int] = {}
        lines = {}
        data = self.coverage.get_data()
        for file in data.measured_files():
            lines[str(Path(file).relative_to(self.source))] = {
                line: groups.setdefault(
                    tuple(sorted({n for name in names for n in users.get(name, ())})),
                    len(groups),
                )
                for line, names in data.contexts_by_lineno(file).items()
            }
        return {
            "tests": tests,
            "needs": [[name for name in names if name in spent] for names in needs],
            "seconds": spent,
            "groups": list(groups),
            "lines": lines,
        }

    def _closure(self, name: str) -> set[str]:
        """Contexts that a context depends on, itself among them."""
        found, left = set(), [name]
        while left:
            name = left.pop()
            if name not in found:
                found.add(name)
                left += self.uses.get(name, ())
        return found


def trace_file(file: str, source: Path, packages: list[str]) -> dict[str, Any]:
    """Run one test file, in this process, which has not imported the package yet."""
    trace = Trace(source, packages)
    functools.cache = trace.remembering(functools.cache)
    functools.lru_cache = trace.remembering(functools.lru_cache)
    trace.coverage.start()
    pytest.main([file, *PYTEST], [trace])
    trace.coverage.stop()
    return trace.map()

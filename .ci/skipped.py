"""The tests that were skipped, by pytest's JUnit report: ``skipped.py REPORT``."""

import sys
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[1]


def skipped(report: str) -> list[str]:
    """Functions, as ``tests/a.py::test_b`` with all their cases, and whole files, as
    pytest takes them; each once.

    Raises `SystemExit` for a report without tests, and for a class name that is that of
    no file.
    """
    cases = list(ElementTree.parse(report).iter("testcase"))
    if not cases:
        raise SystemExit(f"{report} has no tests")
    found: dict[str, None] = {}
    for case in cases:
        if case.find("skipped") is None:
            continue
        name = case.get("name", "").partition("[")[0]
        words = case.get("classname", "").split(".")
        if words == [""]:  # a whole file that was skipped while it was collected
            words, name = name.split("."), ""
        path = "/".join(words) + ".py"
        if not (ROOT / path).is_file():
            raise SystemExit(f"no file holds the tests of '{'.'.join(words)}'")
        found[f"{path}::{name}" if name else path] = None
    return list(found)


if __name__ == "__main__":
    print(" ".join(skipped(sys.argv[1])))

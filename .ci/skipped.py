"""The files of tests of which some were skipped, by pytest's JUnit report: ``skipped.py
REPORT``."""

import sys
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[1]


def files(report: str) -> list[str]:
    """Paths of the files, each once.

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
        words = case.get("classname", "").split(".") or [""]
        if words == [""]:  # a whole file that was skipped while it was collected
            words = case.get("name", "").split(".")
        path = "/".join(words) + ".py"
        if not (ROOT / path).is_file():
            raise SystemExit(f"no file holds the tests of '{'.'.join(words)}'")
        found[path] = None
    return list(found)


if __name__ == "__main__":
    print(" ".join(files(sys.argv[1])))

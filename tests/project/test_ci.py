"""What CI rests on: no test is left out because it was skipped in a newcomer's clone."""

import subprocess
import sys

import pytest

from project.environments import ROOT

CASES = {
    "ran": '<testcase classname="tests.core.test_files" name="test_a"/>',
    "skipped": '<testcase classname="tests.viewer.test_pages" name="test_b[a b]">'
    '<skipped message="no browser"/></testcase>',
    "whole file": '<testcase classname="" name="tests.notebook.test_notebook">'
    "<skipped/></testcase>",
    "unknown": '<testcase classname="tests.nowhere" name="test_c"><skipped/></testcase>',
}


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (["ran"], ""),
        (
            ["ran", "skipped", "whole file", "skipped"],
            "tests/viewer/test_pages.py::test_b tests/notebook/test_notebook.py",
        ),
        (["unknown"], None),
        ([], None),
    ],
)
def test_what_was_skipped_is_named(tmp_path, kinds, said):
    """Nothing is passed over in silence: an error where a report has no tests, or a test
    no file."""
    report = tmp_path / "tests.xml"
    cases = "".join(CASES[kind] for kind in kinds)
    report.write_text(f"<testsuites><testsuite>{cases}</testsuite></testsuites>")
    command = [sys.executable, ROOT / ".ci" / "skipped.py", report]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode == 0) == (said is not None), done.stderr
    if said is not None:
        assert done.stdout.strip() == said

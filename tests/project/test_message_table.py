"""docs/messages.md lists every message that the source can give."""

import re
from pathlib import Path

from message_table import messages, table

PAGE = Path(__file__).parents[2] / "docs" / "messages.md"


def test_the_page_has_the_table():
    shown = PAGE.read_text()
    assert shown[shown.index("| code") :] == table(), (
        "write it anew: python tests/project/message_table.py"
    )


def test_codes_are_short_names():
    for code, _, _, text in messages():
        assert code.replace("-", "").replace("…", "").isalnum(), code
        assert text


def test_codes_that_other_pages_name_are_in_the_table():
    codes = {code for code, *_ in messages()}
    mistakes = (PAGE.parent / "mistakes.md").read_text()
    cells = re.findall(r"^\| (`[a-z-]+`(?:, `[a-z-]+`)*) \|", mistakes, re.MULTILINE)
    seen = re.findall(r"Code `([a-z-]+)`", (PAGE.parent / "fails.md").read_text())
    named = {code for cell in cells for code in re.findall(r"[a-z-]+", cell)} | {*seen}
    assert len(named) > 30
    assert named <= codes

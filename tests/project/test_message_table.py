"""docs/messages.md lists every message that the source can give."""

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

"""The documentation's tables of peers are those of the figures that are kept."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from benchmarks.against import page, versions
from benchmarks.against.ours import BARE

METHODS = (" PMD", " GEO", " LMI", " OLS", " Bayes")


def test_the_documentation_shows_what_is_kept():
    text = page.PAGE.read_text()
    kept = page.kept()
    assert page.with_tables(text, kept) == text
    assert not kept["quick"]
    assert [each["samples"] for each in kept["sets"]].count(150) >= 1
    missed = [goal for goal in kept["goals"] if not goal["met"]]
    assert text.count("**missed**") == len(missed)


def test_every_party_and_version_that_is_kept_is_described():
    text = page.PAGE.read_text().partition(page.BEGIN)[0]
    kept = page.kept()
    assert set(kept["versions"]) == set(versions.PEERS)
    for each in kept["sets"]:
        for party in each["parties"]:
            program = party["party"].removesuffix(BARE)
            for method in METHODS:
                program = program.partition(method)[0]
            assert f"| {program}" in text, party["party"]

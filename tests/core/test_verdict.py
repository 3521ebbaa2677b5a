"""The verdict: whether to trust an estimate."""

import re
from pathlib import Path

import pytest

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import NO_DOUBT, error, note, verdict_of, warning
from hefting.export import TARGETS, export

TURNED = error("axes-turned", "the axes are turned: give `sensor_turned`='z:5'")
DOUBT = warning("sign-uncertain", "the sign is uncertain")


def test_errors_outweigh_doubts_and_notes_are_none():
    assert verdict_of([]).level == "good"
    assert verdict_of([note("clock-offset", "late")]).level == "good"
    assert verdict_of([warning("no-shape", "none")]).level == "good"
    assert verdict_of([DOUBT]).level == "usable with care"
    found = verdict_of([DOUBT, TURNED])
    assert (found.level, found.reasons) == ("do not use", (TURNED, DOUBT))
    assert not found.usable


def test_the_other_messages_are_those_that_are_no_reasons():
    late = note("clock-offset", "late")
    assert verdict_of([DOUBT, late, TURNED]).others((late, DOUBT, TURNED)) == [late]


def test_a_warning_without_a_code_gives_doubt():
    found = verdict_of(["something is odd"])
    assert found.level == "usable with care"
    assert [(str(r), r.code) for r in found.reasons] == [
        ("something is odd", "unknown")
    ]


def test_codes_without_doubt_are_codes_of_the_source():
    """A code that no longer exists would hide nothing, and is not listed. The page holds
    the codes of the source: see `project/test_message_table.py`."""
    page = (Path(__file__).parents[2] / "docs" / "messages.md").read_text()
    codes = set(re.findall(r"^\| `([^`]+)` \|", page, re.MULTILINE))
    assert codes >= NO_DOUBT


@pytest.fixture
def doubtful():
    body = InertialParameters.from_points(
        [[0, 0, 0.1], [0.1, 0, 0], [0, 0.1, 0]], [1] * 3
    )
    return Estimate("OLS", body, 100, warnings=(TURNED, DOUBT))


def test_it_survives_a_file(doubtful, tmp_path):
    doubtful.save(tmp_path / "e.json")
    assert Estimate.load(tmp_path / "e.json").verdict == doubtful.verdict
    data = doubtful.to_dict()
    assert (data["verdict"], data["reasons"]) == ("do not use", [TURNED, DOUBT])


@pytest.mark.parametrize("target", sorted(set(TARGETS) - {"json"}))
def test_what_is_not_to_be_used_is_not_exported(doubtful, target):
    with pytest.raises(InputError, match="not to be used: the axes are turned"):
        export(doubtful, target)
    accepted = export(doubtful, target, accept=True).text
    # columns of a table are fixed, and so are the keys that a Franka reads
    assert "do not use" in accepted or target in ("csv", "franka-desk")


def test_json_holds_it_anyway(doubtful):
    assert '"verdict": "do not use"' in export(doubtful, "json").text

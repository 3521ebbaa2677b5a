"""Reference values of recordings with all kinds of faults: see `reference.kept`."""

import pytest

from reference import kept
from reference.ingest_cases import CASES, SMALLEST
from reference.kept import check

pytestmark = pytest.mark.usefixtures("same_recordings")


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("ingest", CASES, name, SMALLEST.get(name, kept.SMALLEST))

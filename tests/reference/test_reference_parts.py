"""Reference values of more parts of ingest: see `reference.kept`."""

import pytest

from reference.kept import check
from reference.part_cases import CASES


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("parts", CASES, name)

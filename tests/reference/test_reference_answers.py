"""Reference values of answers as they are told: see
`reference.kept`."""

import pytest

from reference.answer_cases import CASES
from reference.kept import check


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("answers", CASES, name)

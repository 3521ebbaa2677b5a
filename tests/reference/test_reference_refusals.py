"""Reference values of what is refused: see `reference.kept`."""

import pytest

from reference.kept import check
from reference.refusal_cases import CASES

pytestmark = pytest.mark.usefixtures("same_recordings")


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("refusals", CASES, name)

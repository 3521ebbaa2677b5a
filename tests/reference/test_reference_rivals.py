"""Reference values of mistakes and their explanations: see `reference.kept`."""

import pytest

from reference.kept import check
from reference.rival_cases import CASES

pytestmark = pytest.mark.usefixtures("same_poses")


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("rivals", CASES, name)

"""Reference values of recordings in which the object changes: see `reference.kept`."""

import pytest

from reference.change_cases import CASES
from reference.kept import check

pytestmark = pytest.mark.usefixtures("same_poses")


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("changes", CASES, name)

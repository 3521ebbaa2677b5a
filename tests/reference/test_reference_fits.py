"""Reference values of the parts of ingest: see `reference.kept`."""

import pytest

from reference.fit_cases import CASES
from reference.kept import check

pytestmark = pytest.mark.usefixtures("same_poses")


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("fits", CASES, name)

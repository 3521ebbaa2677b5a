"""Reference values of bodies, regressors, moments, sensors and scales: see `reference.kept`."""

import pytest

from reference.core_cases import CASES
from reference.kept import check


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("core", CASES, name)

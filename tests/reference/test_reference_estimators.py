"""Reference values of every method but Bayes: see `reference.kept`."""

import pytest

from reference.estimator_cases import CASES
from reference.kept import check


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("estimators", CASES, name)

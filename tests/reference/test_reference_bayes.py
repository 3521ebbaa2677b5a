"""Reference values of Bayes, its priors and its noise: see `reference.kept`."""

import pytest

from reference.bayes_cases import CASES
from reference.kept import check


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("bayes", CASES, name)

"""Reference values of Bayes, its priors and its noise: see `reference.kept`."""

import pytest

from hefting.estimators.bayes.bounds import BOUNDS_MEMBERS, REACH_MEMBERS
from hefting.estimators.bayes.densities import MEMBERS
from reference.bayes_cases import CASES
from reference.kept import check


@pytest.mark.parametrize("name", CASES)
def test_results_are_the_reference_values(name: str):
    check("bayes", CASES, name)


def test_tables_of_members_are_those_that_were_fitted():
    """Each number of each."""
    tables = {"each": MEMBERS, "bounds": BOUNDS_MEMBERS, "reach": REACH_MEMBERS}
    rows = {name: list(table) for name, table in tables.items()}
    check("bayes", {"members": lambda: rows}, "members")

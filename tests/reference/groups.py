"""All groups of cases, by the names of their files."""

from collections.abc import Mapping

from reference import (
    bayes_cases,
    core_cases,
    estimator_cases,
    ingest_cases,
    rival_cases,
)
from reference.kept import Cases

GROUPS: Mapping[str, Cases] = {
    "core": core_cases.CASES,
    "estimators": estimator_cases.CASES,
    "bayes": bayes_cases.CASES,
    "ingest": ingest_cases.CASES,
    "rivals": rival_cases.CASES,
}
"""By name."""

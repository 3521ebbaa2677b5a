"""All groups of cases, by the names of their files."""

from collections.abc import Mapping

from reference import (
    answer_cases,
    bayes_cases,
    change_cases,
    core_cases,
    estimator_cases,
    fit_cases,
    ingest_cases,
    part_cases,
    refusal_cases,
    rival_cases,
)
from reference.kept import Cases

GROUPS: Mapping[str, Cases] = {
    "answers": answer_cases.CASES,
    "changes": change_cases.CASES,
    "core": core_cases.CASES,
    "estimators": estimator_cases.CASES,
    "bayes": bayes_cases.CASES,
    "fits": fit_cases.CASES,
    "ingest": ingest_cases.CASES,
    "parts": part_cases.CASES,
    "refusals": refusal_cases.CASES,
    "rivals": rival_cases.CASES,
}
"""By name."""

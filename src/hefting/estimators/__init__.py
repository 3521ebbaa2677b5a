"""Estimators: one file a method, one small contract (`hefting.estimators.base`)."""

from hefting.estimators.base import Estimator
from hefting.estimators.ols import OLS
from hefting.estimators.pmd import PMD

METHODS: dict[str, type[Estimator]] = {"PMD": PMD, "OLS": OLS}
"""Every method by its name."""

__all__ = ["METHODS", "OLS", "PMD", "Estimator"]

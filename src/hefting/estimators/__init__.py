"""Estimators: one file a method, one small contract (`hefting.estimators.base`)."""

from hefting.estimators.base import Estimator
from hefting.estimators.geo import GEO
from hefting.estimators.hps import HPS
from hefting.estimators.lmi import LMI
from hefting.estimators.ols import OLS
from hefting.estimators.pmd import PMD
from hefting.estimators.rtls import RTLS

METHODS: dict[str, type[Estimator]] = {"PMD": PMD, "GEO": GEO, "HPS": HPS, "LMI": LMI, "OLS": OLS, "RTLS": RTLS}
"""Every method by its name."""

__all__ = ["GEO", "HPS", "LMI", "METHODS", "OLS", "PMD", "RTLS", "Estimator"]

"""Every method, a line each; nothing else may be here.

What a method is called, where it stands among the others, its variants and options: its
class says so (`hefting.estimators.base`).
"""

from hefting.estimators.bayes import Bayes as Bayes
from hefting.estimators.geo import GEO as GEO
from hefting.estimators.hps import HPS as HPS
from hefting.estimators.lmi import LMI as LMI
from hefting.estimators.ols import OLS as OLS
from hefting.estimators.pmd import PMD as PMD
from hefting.estimators.rtls import RTLS as RTLS

"""Identification: from what a recording was understood to be to an estimate, by one
method or by several."""

from hefting.identification.compare import Comparison
from hefting.identification.front import identify
from hefting.identification.identify import Identification, calibrate

__all__ = ["Comparison", "Identification", "calibrate", "identify"]

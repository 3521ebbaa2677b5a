"""Identification: from what a recording was understood to be to an estimate, by one
method or by several."""

from hefting.identification.identify import Identification, calibrate, identify

__all__ = ["Identification", "calibrate", "identify"]

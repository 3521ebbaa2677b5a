"""Conditioning of real recordings: clocks, bias, sign, gravity, noise and bad samples, before identification."""

from hefting.conditioning.drift import Drift
from hefting.conditioning.procedure import condition
from hefting.conditioning.report import NO_BIAS
from hefting.conditioning.result import Conditioned

__all__ = ["NO_BIAS", "Conditioned", "Drift", "condition"]

"""Conditioning of real recordings: clocks, bias, sign, gravity, noise and bad samples, before identification."""

from hefting.conditioning.drift import Drift
from hefting.conditioning.procedure import condition
from hefting.conditioning.result import Conditioned

__all__ = ["Conditioned", "Drift", "condition"]

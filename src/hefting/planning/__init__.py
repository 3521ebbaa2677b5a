"""Planning: the joint motion to make next, which leaves the least of what is still
uncertain, within limits."""

from hefting.planning.limits import Limits
from hefting.planning.plan import plan
from hefting.planning.result import Forecast, Plan

__all__ = ["Forecast", "Limits", "Plan", "plan"]

"""Planning: the joint motion within limits after which the least uncertainty is left."""

from hefting.planning.limits import Limits
from hefting.planning.plan import plan
from hefting.planning.result import Forecast, Plan

__all__ = ["Forecast", "Limits", "Plan", "plan"]

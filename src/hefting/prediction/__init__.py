"""Prediction: the wrench that an identified object needs along a motion, with its
uncertainty."""

from hefting.prediction.predict import predict
from hefting.prediction.result import Agreement, Peak, Prediction

__all__ = ["Agreement", "Peak", "Prediction", "predict"]

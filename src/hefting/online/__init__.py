"""One live pipeline for any source: raw samples in, an estimate at any time."""

from hefting.online.identifier import LiveIdentifier
from hefting.online.live_estimate import LiveEstimate

__all__ = ["LiveEstimate", "LiveIdentifier"]

"""Hefting and its peers on the same recordings: ``python -m benchmarks.against``."""

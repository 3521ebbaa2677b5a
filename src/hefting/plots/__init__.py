"""Plots: one file a picture, one palette (`hefting.plots.style`). Need matplotlib."""

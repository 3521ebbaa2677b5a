"""Colours of what the viewer shows, from the palette of the pictures."""

import numpy as np

from hefting.core.spatial import Array
from hefting.plots.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION

Colour = tuple[int, int, int]

GREY, PALE = "#8A8A8A", "#B9C4CF"
AXES = {"x": BLUE, "y": VERMILION, "z": GREEN}
COM, INERTIA, SURFACE, TRUTH = VERMILION, PURPLE, PALE, GREY
ARROWS = {
    "force, measured": ORANGE,
    "force, predicted": "#A65200",
    "torque, measured": SKY,
    "torque, predicted": BLUE,
}
"""Of each arrow of the wrench; what is predicted is the darker one of each pair."""
MASSES = ("#7B5EA7", "#3B8BC2", "#2BA58D", "#8CC63F", "#F2B705")
"""Scale of masses from none to the largest, seen on white and on black."""


def rgb(colour: str) -> Colour:
    """Red, green and blue (0 to 255) of ``"#RRGGBB"``."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


def colours_of(masses: Array) -> np.ndarray:
    """Colours (n, 3), 0 to 255, of masses (n,) [kg] on the scale `MASSES`."""
    scale = np.array([rgb(colour) for colour in MASSES], dtype=float)
    share = masses / (float(masses.max(initial=0.0)) or 1.0)
    at = np.clip(share, 0.0, 1.0) * (len(scale) - 1)
    columns = [np.interp(at, np.arange(len(scale)), column) for column in scale.T]
    return np.column_stack(columns).round().astype(np.uint8)

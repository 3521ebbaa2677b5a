"""The case that rival explanations are judged by, of what a user gives."""

import numpy as np
from benchmarks.given import Given

from hefting.core.spatial import STANDARD_GRAVITY
from hefting.ingest.path import path_of
from hefting.ingest.rivals.case import Case


def case_of(given: Given, offset: float = 0.0) -> Case:
    """The case of what a user gave, on a recording whose clocks agree."""
    path = path_of(given.recording)
    assert path is not None
    gravity = np.array(given.options.get("gravity", STANDARD_GRAVITY), dtype=float)
    biased = "bias" not in given.options
    return Case.of(given.recording, path, gravity, offset, biased=biased)

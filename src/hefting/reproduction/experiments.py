"""Every experiment of the paper, one file each."""

from collections.abc import Sequence
from importlib import import_module

from hefting.reproduction.experiment import Experiment

FILES = (
    "objects",
    "gravity",
    "condition",
    "density",
    "c1",
    "noise",
    "observations",
    "stop_and_go",
    "robot",
    "prediction",
)
"""In the order of the page; each ends with its `EXPERIMENT`."""


def _by_name(files: Sequence[str]) -> dict[str, Experiment]:
    experiments = [
        import_module(f"hefting.reproduction.{file}").EXPERIMENT for file in files
    ]
    return {experiment.name: experiment for experiment in experiments}


EXPERIMENTS: dict[str, Experiment] = _by_name(FILES)
"""By name, in the order of the page."""

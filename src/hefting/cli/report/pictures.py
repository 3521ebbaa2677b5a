"""Pictures that hefting identify writes beside its other outputs."""

from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli import render
from hefting.cli.progress import progress

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hefting.core.estimate import Estimate
    from hefting.core.inertia import InertialParameters
    from hefting.core.measurements import Measurements
    from hefting.shapes import Shape


def is_picture(path: str) -> bool:
    """Whether a file of this name is a picture."""
    from hefting.plots.style import FORMATS

    return Path(path).suffix.lower() in FORMATS


def draw_pictures(
    paths: "Iterable[str]",
    measurements: "Measurements",
    estimate: "Estimate",
    shape: "Shape | None",
    truth: "InertialParameters | None",
) -> dict[str, bytes]:
    """The contents of those of the paths that are pictures; nothing is written."""
    wanted = [path for path in paths if is_picture(path)]
    if not wanted:
        return {}
    from hefting.plots import picture_of, plot_identification

    with progress("drawing"):
        figure = plot_identification(measurements, estimate, shape, truth, render)
        return {path: picture_of(figure, Path(path).suffix.lower()) for path in wanted}


def write_pictures(pictures: dict[str, bytes]) -> None:
    """Write each, whole or not at all."""
    from hefting.core.files import write_atomically

    for path, content in pictures.items():
        write_atomically(path, content)

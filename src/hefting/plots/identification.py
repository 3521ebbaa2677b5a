"""Picture of an identification: the object found, beside the wrench that it explains.
Needs matplotlib."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.plots.style import WIDTH, headed, lines_of, subfigures_of
from hefting.plots.views import draw_scene, height_of
from hefting.plots.wrench import HEIGHT, draw_wrench
from hefting.scene import headline_of, scene_of
from hefting.shapes import Shape

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_identification(
    measurements: Measurements,
    estimate: Estimate,
    shape: Shape | None = None,
    truth: InertialParameters | None = None,
    say: Callable[[str], str] = str,
) -> "Figure":
    """The object as `plot_object` draws it, and the wrench as `plot_wrench` does, side
    by side under one headline.

    Parameters and errors as for those two.
    """
    known = {} if truth is None else {"truth": truth}
    scene = scene_of({"estimate": estimate}, shape, known)
    headline = headline_of(estimate)
    lines = lines_of(headline, 2.0 * WIDTH, say)
    height = max(height_of(scene), HEIGHT)
    with headed(height, lines, headline.usable, 2.0 * WIDTH) as (figure, below):
        left, right = subfigures_of(below, 2)
        draw_scene(left, scene)
        draw_wrench(right, measurements, estimate)
    return figure

"""Picture of a shape as it is posed, before anything is identified, to check the pose
by eye. Needs matplotlib."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from hefting.core.estimate import Estimate
from hefting.plots.style import headed
from hefting.plots.views import draw_scene, height_of
from hefting.scene import headline_of, place_of, scene_of
from hefting.shapes import Shape

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_shape(
    shape: Shape,
    estimates: Mapping[str, Estimate] | None = None,
    gravity: ArrayLike | None = None,
) -> "Figure":
    """The shape in three views, in sensor axes, with the COM that it has if its density
    is uniform.

    Parameters
    ----------
    shape : Shape
        As posed in the sensor frame.
    estimates : mapping of str to Estimate, optional
        What was found of the object, by the name that it is to have: its COM belongs
        inside the shape. The COM of least squares knows nothing of the pose.
    gravity : array_like, optional
        (K, 3) gravity in sensor axes during a log [m/s²], drawn from the sensor.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    MissingDependencyError
        Without matplotlib.
    """
    uniform = {"uniform shape": shape.homogeneous}
    found = dict(estimates or {})
    scene = scene_of(found, shape, uniform, gravity).with_centers_only()
    lines = ["the shape as posed, in sensor axes", *place_of(shape)]
    for name, estimate in found.items():
        verdict, numbers = estimate.verdict, headline_of(estimate).numbers
        lines += [f"{name} ({verdict}; ± 95 %)", numbers[1]]
    with headed(height_of(scene), lines) as (figure, below):
        draw_scene(below, scene)
    return figure

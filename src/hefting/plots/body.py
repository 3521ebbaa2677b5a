"""Pictures of an object in three views: an estimate with its uncertainty, alone or beside
its wrench; and a shape in its pose, to check the pose by eye. Needs matplotlib."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.plots.style import WIDTH, headed, lines_of, subfigures_of
from hefting.plots.views import draw_scene, height_of
from hefting.plots.wrench import HEIGHT, draw_wrench
from hefting.scene import headline_of, place_of, scene_of
from hefting.shapes import Shape

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_object(
    estimate: Estimate,
    shape: Shape | None = None,
    truth: InertialParameters | None = None,
    masses: bool = False,
    say: Callable[[str], str] = str,
) -> "Figure":
    """The object in three views, in sensor axes: COM with its 95 % region, and the
    uniform ellipsoid of equal inertia.

    Open parts are not drawn: no ellipsoid if the inertia is too uncertain
    (`hefting.scene.LARGEST_DOUBT`), no COM along an axis on which it is open.

    Parameters
    ----------
    estimate : Estimate
        Its verdict and numbers are the headline.
    shape : Shape, optional
        Drawn by its surface, or its points without one; a box that only holds the object
        by its outline.
    truth : InertialParameters, optional
        Drawn too.
    masses : bool
        Whether ``estimate.point_masses`` are drawn. They are one of many sets with the
        same ten parameters.
    say : callable
        Turns names of arguments in backquotes into the reader's.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    MissingDependencyError
        Without matplotlib.
    """
    scene = scene_of({"estimate": estimate}, shape, {"truth": truth}, masses=masses)
    headline = headline_of(estimate)
    lines = lines_of(headline, say=say)
    with headed(height_of(scene), lines, headline.usable) as (figure, below):
        draw_scene(below, scene)
    return figure


def plot_identification(
    measurements: Measurements,
    estimate: Estimate,
    shape: Shape | None = None,
    truth: InertialParameters | None = None,
    say: Callable[[str], str] = str,
    start: float | None = None,
) -> "Figure":
    """The object as `plot_object` draws it, and the wrench as `plot_wrench` does, side
    by side under one headline.

    Parameters and errors as for those two.
    """
    scene = scene_of({"estimate": estimate}, shape, {"truth": truth})
    headline = headline_of(estimate)
    lines = lines_of(headline, 2.0 * WIDTH, say)
    height = max(height_of(scene), HEIGHT)
    with headed(height, lines, headline.usable, 2.0 * WIDTH) as (figure, below):
        left, right = subfigures_of(below, 2)
        draw_scene(left, scene)
        draw_wrench(right, measurements, estimate, start)
    return figure


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
        Estimates of the object by name, whose COM is inside a correctly posed shape. That
        of least squares does not depend on the pose.
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
    known = dict(estimates or {})
    scene = scene_of(known, shape, uniform, gravity).with_centers_only()
    lines = ["the shape as posed, in sensor axes", *place_of(shape)]
    for name, estimate in known.items():
        verdict, numbers = estimate.verdict, headline_of(estimate).numbers
        lines += [f"{name} ({verdict}; ± 95 %)", numbers[1]]
    with headed(height_of(scene), lines) as (figure, below):
        draw_scene(below, scene)
    return figure

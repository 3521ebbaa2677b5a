"""Picture of the object found, in three views: COM and ellipsoids with their
uncertainty. Needs matplotlib."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.plots.style import headed, lines_of
from hefting.plots.views import draw_scene, height_of
from hefting.scene import headline_of, scene_of
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

    What the recording leaves open is not drawn: no ellipsoid where a moment's interval
    is wider than the moment, no COM along an axis on which it is open.

    Parameters
    ----------
    estimate : Estimate
        Its verdict and numbers stand over the views.
    shape : Shape, optional
        Its surface is drawn, or its points where it has none; a box that only holds the
        object as an outline.
    truth : InertialParameters, optional
        Drawn beside the estimate.
    masses : bool
        Whether ``estimate.point_masses`` are drawn. They are one of many sets with the
        same ten parameters, no finding.
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
    known = {} if truth is None else {"truth": truth}
    scene = scene_of({"estimate": estimate}, shape, known, masses=masses)
    headline = headline_of(estimate)
    lines = lines_of(headline, say=say)
    with headed(height_of(scene), lines, headline.usable) as (figure, below):
        draw_scene(below, scene)
    return figure

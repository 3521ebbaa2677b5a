"""Scene: what is to be drawn of an object, as plain data for any renderer.

    scene = scene_of(estimates={"estimate": found.estimate}, shape=shape)
    headline_of(found.estimate).lines

All lengths are in metres, in sensor axes about the sensor origin. Nothing here draws.
"""

from hefting.scene.curves import WrenchCurves, gaps_between, thinned, wrench_curves
from hefting.scene.headline import (
    Headline,
    depth_of,
    headline_of,
    place_of,
    plus_minus,
    power_of_thousand,
    vector_text,
)
from hefting.scene.scene import Body, PointSet, Scene, scene_of
from hefting.scene.surface import (
    Ellipsoid,
    Surface,
    com_reach,
    com_region,
    reach,
    surface_of,
    uniform_ellipsoid,
)

__all__ = [
    "Body",
    "Ellipsoid",
    "Headline",
    "PointSet",
    "Scene",
    "Surface",
    "WrenchCurves",
    "com_reach",
    "com_region",
    "depth_of",
    "gaps_between",
    "headline_of",
    "place_of",
    "plus_minus",
    "power_of_thousand",
    "reach",
    "scene_of",
    "surface_of",
    "thinned",
    "uniform_ellipsoid",
    "vector_text",
    "wrench_curves",
]

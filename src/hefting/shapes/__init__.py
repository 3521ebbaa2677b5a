"""Shapes: mesh, convex hull, point cloud, labelled parts or box -> `Shape` in the
sensor frame."""

from hefting.shapes.loading import as_shape, load_shape, parse_pose
from hefting.shapes.shape import Shape

__all__ = ["Shape", "as_shape", "load_shape", "parse_pose"]

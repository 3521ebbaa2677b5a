"""Shapes: mesh, convex hull, point cloud, labelled parts or box -> `PointMasses` in the sensor frame."""

from hefting.shapes.loading import load_shape, parse_pose
from hefting.shapes.point_masses import PointMasses

__all__ = ["PointMasses", "load_shape", "parse_pose"]

"""A scene in Foxglove's own messages. Needs foxglove-sdk."""

from collections.abc import Sequence

import numpy as np
from foxglove.messages import (
    ArrowPrimitive,
    Color,
    CubePrimitive,
    KeyValuePair,
    PackedElementField,
    PackedElementFieldNumericType,
    Point3,
    PointCloud,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    SpherePrimitive,
    Timestamp,
    TriangleListPrimitive,
    Vector3,
)

from hefting.core.spatial import Array, quaternion_of
from hefting.plots.style import BLUE, PURPLE, SHADOW, VERMILION
from hefting.scene import Ellipsoid, Scene, Surface

SOLID, GLASS = 1.0, 0.35
"""Opacity of marks, and of parts that others must be visible through."""
PALE = 0.15
"""Opacity of a box that only holds the object."""
MARK = 0.02
"""Diameter of the mark of a COM over the size of the scene."""
ARROW = 0.75
"""Length of the longest force over the size of the scene."""
COLOURS = {"measured": BLUE, "predicted": VERMILION}


class Entities:
    """Makes messages of the parts of a scene, in the moving frame of the sensor.

    Parameters
    ----------
    scene : Scene
        The object, with one body.
    frame : str
        Name of the sensor's frame.
    facts : Sequence of pairs of str
        Names and values shown with each part.
    """

    def __init__(self, scene: Scene, frame: str, facts: Sequence[tuple[str, str]]):
        self.scene, self.frame = scene, frame
        self.size = float(np.ptp(scene.corners, axis=0).max()) or 0.1
        self.facts = [KeyValuePair(key=key, value=value) for key, value in facts]

    def shape(self, stamp: int) -> SceneUpdate | None:
        """The surface, or the box that holds the object; None if unknown."""
        surface = self.scene.surface
        if surface is None:
            return None
        parts = (
            {"triangles": [_triangles(surface)]}
            if surface.is_object
            else {"cubes": [_box(surface)]}
        )
        return self._update(stamp, ("shape", parts))

    def points(self, stamp: int) -> PointCloud | None:
        """The points of a shape without a surface."""
        points = self.scene.points
        if points is None:
            return None
        number = PackedElementFieldNumericType.Float32
        return PointCloud(
            timestamp=timestamp(stamp),
            frame_id=self.frame,
            pose=_pose(np.zeros(3), np.eye(3)),
            point_stride=12,
            fields=[
                PackedElementField(name=axis, offset=4 * i, type=number)
                for i, axis in enumerate("xyz")
            ],
            data=points.positions.astype("<f4").tobytes(),
        )

    def center(self, stamp: int) -> SceneUpdate | None:
        """The COM as a small sphere, and its 95 % region; None if it is open."""
        (body,) = self.scene.bodies
        if np.isnan(body.center).any():
            return None
        mark = Ellipsoid(body.center, 0.5 * MARK * self.size * np.eye(3))
        parts = [("COM", {"spheres": [_sphere(mark, VERMILION, SOLID)]})]
        if body.region is not None:
            region = {"spheres": [_sphere(body.region, VERMILION, GLASS)]}
            parts.append(("95 % region of the COM", region))
        return self._update(stamp, *parts)

    def inertia(self, stamp: int) -> SceneUpdate | None:
        """The uniform ellipsoid of equal inertia, if there is one."""
        (body,) = self.scene.bodies
        if body.ellipsoid is None:
            return None
        parts = {"spheres": [_sphere(body.ellipsoid, PURPLE, GLASS)]}
        return self._update(stamp, ("uniform ellipsoid of equal inertia", parts))

    def force(self, stamp: int, name: str, force: Array, largest: float) -> SceneUpdate:
        """A force (3,) [N] on the object as an arrow from the sensor; the `largest` [N] has
        the length `ARROW` times the size of the scene."""
        length = ARROW * self.size * float(np.linalg.norm(force)) / (largest or 1.0)
        width = 0.02 * self.size
        arrow = ArrowPrimitive(
            pose=Pose(
                position=vector3(np.zeros(3)), orientation=quaternion(_turn_to(force))
            ),
            shaft_length=0.8 * length,
            shaft_diameter=width,
            head_length=0.2 * length,
            head_diameter=2.0 * width,
            color=_colour(COLOURS[name], SOLID),
        )
        return self._update(stamp, (f"{name} force", {"arrows": [arrow]}))

    def _update(self, stamp: int, *parts: tuple[str, dict]) -> SceneUpdate:
        return SceneUpdate(
            entities=[
                SceneEntity(
                    timestamp=timestamp(stamp),
                    frame_id=self.frame,
                    frame_locked=True,
                    id=name,
                    metadata=self.facts,
                    **primitives,
                )
                for name, primitives in parts
            ]
        )


def timestamp(stamp: int) -> Timestamp:
    """Foxglove's form of a time [ns]."""
    return Timestamp(*divmod(int(stamp), 1_000_000_000))


def vector3(values: Array) -> Vector3:
    """Foxglove's form of a vector (3,)."""
    x, y, z = values.tolist()
    return Vector3(x=x, y=y, z=z)


def quaternion(values: Array) -> Quaternion:
    """Foxglove's form of a quaternion (4,), w last."""
    x, y, z, w = values.tolist()
    return Quaternion(x=x, y=y, z=z, w=w)


def _colour(text: str, opacity: float) -> Color:
    """From ``"#RRGGBB"``."""
    r, g, b = (int(text[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return Color(r=r, g=g, b=b, a=opacity)


def _pose(position: Array, rotation: Array) -> Pose:
    turned = quaternion(quaternion_of(rotation))
    return Pose(position=vector3(position), orientation=turned)


def _sphere(ellipsoid: Ellipsoid, colour: str, opacity: float) -> SpherePrimitive:
    lengths, rotation = ellipsoid.principal
    return SpherePrimitive(
        pose=_pose(ellipsoid.center, rotation),
        size=vector3(2.0 * lengths),
        color=_colour(colour, opacity),
    )


def _triangles(surface: Surface) -> TriangleListPrimitive:
    return TriangleListPrimitive(
        pose=_pose(np.zeros(3), np.eye(3)),
        points=[Point3(x=x, y=y, z=z) for x, y, z in surface.vertices.tolist()],
        indices=surface.faces.ravel().tolist(),
        color=_colour(SHADOW, GLASS),
    )


def _box(surface: Surface) -> CubePrimitive:
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return CubePrimitive(
        pose=_pose(0.5 * (low + high), np.eye(3)),
        size=vector3(high - low),
        color=_colour(SHADOW, PALE),
    )


def _turn_to(direction: Array) -> Array:
    """Quaternion (4,), w last, of the smallest turn from the x axis to a direction (3,)
    of any length."""
    size = float(np.linalg.norm(direction))
    x, y, z = direction / size if size > 0.0 else np.array((1.0, 0.0, 0.0))
    turn = np.array((0.0, -z, y, 1.0 + x))
    length = float(np.linalg.norm(turn))
    return turn / length if length > 1e-9 else np.array((0.0, 0.0, 1.0, 0.0))

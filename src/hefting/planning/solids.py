"""The links of a robot and the object it holds, as convex solids that move with the
joints."""

from collections.abc import Sequence
from itertools import product

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Indices, frozen, rotation_matrices
from hefting.robots.arm import (
    MOST_LINKS,
    Geometry,
    links_in_order,
    read_geometries,
    robot_of,
)
from hefting.robots.robot import Robot
from hefting.robots.urdf import Tree
from hefting.scene.surface import LinkSurfaces
from hefting.shapes.clouds import convex_hull
from hefting.shapes.solid import corners_between

MOST_SOLIDS = 12
"""Solids of one link at most: where its URDF has more, one hull holds them all."""
THIN = 1e-3
"""[m] Least thickness of a solid."""
OBJECT = "the object"
"""Name of the solid that is held."""


@immutable
class Solid:
    """The convex hull of points that are fixed to a link."""

    name: str
    """``link 'x'`` or `OBJECT`"""
    link: int
    """Index of the link that it moves with"""
    vertices: Array
    """(V, 3) [m] in the link's frame"""
    faces: np.ndarray
    """Triangles (F, 3), indices of `vertices`; none of a single point"""
    center: Array
    """(3,) [m] of a sphere that holds it"""
    radius: float
    """[m] of that sphere"""


@immutable
class MovingLink:
    """A link, and the joints on the way to the tip that move it."""

    name: str
    robot: Robot
    columns: tuple[int, ...]
    """Place of each of its robot's joints in the joint positions of the tip; -1 of one
    that does not move the tip"""
    group: int
    """Links of one group do not move against each other while the tip moves"""
    neighbour: int | None
    """group that bears this one; None of the root's"""

    def pose(self, q: Array) -> tuple[Array, Array]:
        """Position (K, 3) [m] and rotation (K, 3, 3) in the root frame, at positions
        (K, n) of the tip's joints. Joints that do not move the tip are at zero, or at
        the limit next to it."""
        own = np.empty((len(q), len(self.columns)))
        for i, column in enumerate(self.columns):
            low, high = self.robot.limits[i] or (0.0, 0.0)
            own[:, i] = np.clip(0.0, low, high) if column < 0 else q[:, column]
        position, orientation = self.robot.poses(own)
        return position, rotation_matrices(orientation)


def read_links(tree: Tree, tip: Robot) -> list[MovingLink]:
    """The links of a robot that have a pose at given positions of the tip's joints,
    those that bear others first; at most `MOST_LINKS`."""
    group = {tree.root: 0}
    bearer: dict[int, int | None] = {0: None}
    moved = {tree.root: 0}
    links = []
    for name, parent in links_in_order(tree)[:MOST_LINKS]:
        if (robot := robot_of(tree, name)) is None:
            continue
        columns = tuple(
            tip.joints.index(moving) if moving in tip.joints else -1
            for moving in robot.joints
        )
        moved[name] = sum(columns[screw.column] >= 0 for screw in robot.screws)
        if parent is not None:
            own = group[parent]
            if moved[name] > moved[parent]:
                own, bearer[len(bearer)] = len(bearer), own
            group[name] = own
        links.append(MovingLink(name, robot, columns, group[name], bearer[group[name]]))
    return links


def solids_of_links(path: str, links: Sequence[MovingLink]) -> list[Solid]:
    """What the links are for collisions: their collision geometry, else what they look
    like. Links without either, or whose meshes cannot be read, have none."""
    surfaces, every = LinkSurfaces(), read_geometries(path)
    found = []
    for i, link in enumerate(links):
        own = [geometry for geometry in every if geometry.link == link.name]
        for part in ("collision", "visual"):
            chosen = [geometry for geometry in own if geometry.part == part]
            clouds = _clouds(chosen, surfaces)
            if clouds:
                name = f"link '{link.name}'"
                found += [solid_of(name, i, cloud) for cloud in clouds]
                break
    return found


def solid_of(name: str, link: int, points: Array) -> Solid:
    """The convex hull of points (N, 3) [m] in a link's frame; of a single point that,
    of points in a plane the box around them, `THIN` at least."""
    points, faces = _hull(points)
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = float(np.linalg.norm(points - center, axis=1).max())
    return Solid(name, link, frozen(points), faces, frozen(center), radius)


def _clouds(geometries: Sequence[Geometry], surfaces: LinkSurfaces) -> list[Array]:
    """Points (N, 3) whose convex hulls hold the geometries that can be read."""
    clouds = []
    for geometry in geometries:
        surface = surfaces.read(geometry)
        if surface is not None and geometry.kind == "mesh":
            clouds += convex_parts(*surface)
        elif surface is not None:
            clouds.append(_around(geometry, surface[0]))
    return clouds if len(clouds) <= MOST_SOLIDS else [np.concatenate(clouds)]


def _around(geometry: Geometry, vertices: Array) -> Array:
    """The vertices of a geometry; of a round one moved outwards, so that their hull
    holds it."""
    if geometry.kind not in ("cylinder", "sphere"):
        return vertices
    turn = rotation_matrices(geometry.orientation)
    own = (vertices - geometry.position) @ turn
    planes = ConvexHull(own).equations
    lateral = (
        planes[np.abs(planes[:, 2]) < 0.99] if geometry.kind != "sphere" else planes
    )
    grown = geometry.size[0] / -lateral[:, 3].max()
    along = 1.0 if geometry.kind == "cylinder" else grown
    return own * (grown, grown, along) @ turn.T + geometry.position


def _hull(points: Array) -> tuple[Array, np.ndarray]:
    """Vertices and triangles of the convex hull of points, none of a single one."""
    if len(points) == 1:
        return points, np.empty((0, 3), dtype=np.intp)
    try:
        points, faces = convex_hull(points)
    except InputError:  # in a plane, or fewer than four: the box around them
        low, high = points.min(axis=0), points.max(axis=0)
        middle, half = 0.5 * (low + high), 0.5 * np.maximum(high - low, THIN)
        points, faces = convex_hull(corners_between(middle - half, middle + half))
    corners, index = np.unique(faces, return_inverse=True)
    return points[corners], index.reshape(faces.shape)


SMALLER = 0.9
"""Share of the hull's volume that the hulls of two parts may have together for a
surface to be cut in two."""
DEEPEST = 2
"""How often a part is cut, so that there are four at most. Base and upper
arm of a UR5 then touch in 7 % of random configurations, uncut in 33 %, and their
meshes in 5 %."""
MOST_TRIANGLES = 50_000
"""Triangles of a surface that is cut at most; collision meshes have some thousands."""
PLACES = (0.2, 0.4, 0.6, 0.8)
"""Where it is cut, as shares of its extent."""


def _directions(count: int) -> Array:
    """Unit vectors (count, 3), evenly over the sphere by the golden angle."""
    i = np.arange(count)
    z = (2.0 * i + 1.0) / count - 1.0
    turn = i * np.pi * (3.0 - np.sqrt(5.0))
    ring = np.sqrt(1.0 - z**2)
    return np.column_stack((ring * np.cos(turn), ring * np.sin(turn), z))


DIRECTIONS = _directions(100)
"""In which the farthest points of a large surface stand for all: volumes are a few
hundredths too small, of the whole as of the parts, and take a fifth of the time."""


def convex_parts(
    vertices: Array, faces: Indices, deepest: int = DEEPEST
) -> list[Array]:
    """Points (N, 3) of each part of a surface of vertices (V, 3) and triangles (F, 3).

    The surface is cut across the axis, and at the place, where the hulls of both parts
    are smallest together, while that pays. The hulls cover the surface. One of more
    than `MOST_TRIANGLES` stays whole.
    """
    if not deepest or len(faces) > MOST_TRIANGLES:
        return [vertices]
    edges = np.unique(
        np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0
    )
    planes = [_plane(vertices, *where) for where in product(range(3), PLACES)]
    volumes = [_volume_cut(vertices, edges, *plane) for plane in planes]
    best = int(np.argmin(volumes))
    if volumes[best] > SMALLER * _volume(vertices):
        return [vertices]
    halves = _cut(vertices, faces, *planes[best])
    return [part for half in halves for part in convex_parts(*half, deepest - 1)]


def _plane(vertices: Array, axis: int, place: float) -> tuple[int, float]:
    """An axis, and where on it a share of the vertices' extent is [m]."""
    low, high = vertices[:, axis].min(), vertices[:, axis].max()
    return axis, float(low + place * (high - low))


def _volume_cut(vertices: Array, edges: Indices, axis: int, at: float) -> float:
    """Volume [m³] of the hulls of both parts together."""
    height = vertices[:, axis] - at
    first, second = edges.T
    crossed = height[first] * height[second] < 0.0
    a, b = first[crossed], second[crossed]
    share = (height[a] / (height[a] - height[b]))[:, None]
    between = vertices[a] + share * (vertices[b] - vertices[a])
    sides = vertices[height <= 0.0], vertices[height >= 0.0]
    return sum(_volume(np.concatenate((side, between))) for side in sides)


def _cut(
    vertices: Array, faces: Indices, axis: int, at: float
) -> list[tuple[Array, Indices]]:
    from trimesh.intersections import slice_faces_plane

    normal = np.eye(3)[axis]
    halves = (
        slice_faces_plane(vertices, faces, sign * normal, at * normal)
        for sign in (1.0, -1.0)
    )
    return [
        (np.asarray(half[0]), np.asarray(half[1])) for half in halves if len(half[1])
    ]


def _volume(points: Array) -> float:
    """Volume [m³] of the hull of points, of those that are farthest in `DIRECTIONS`;
    zero where they are in a plane."""
    if len(points) > len(DIRECTIONS):
        points = points[np.unique((DIRECTIONS @ points.T).argmax(axis=1))]
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0

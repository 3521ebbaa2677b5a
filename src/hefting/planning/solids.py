"""A robot's links and its object, as convex solids that move with the joints; distances
between pairs of them, by coal (extra ``robot``), and the pairs that an SRDF disables."""

from collections.abc import Collection, Sequence
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from hefting.core.errors import InputError, needing
from hefting.core.files import check_no_xacro, parse_xml, read_xml
from hefting.core.spatial import Array, Indices, frozen, immutable, rotation_matrices
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
"""Most solids of one link: if its URDF has more, their common hull replaces them."""
THIN = 1e-3
"""[m] Least thickness of a solid."""
OBJECT = "the object"
"""Name of the held solid."""


@immutable
class Solid:
    """The convex hull of points that are fixed to a link."""

    name: str
    """``link 'x'`` or `OBJECT`"""
    link: int
    """index of its link"""
    vertices: Array
    """(V, 3) [m] in the link's frame"""
    faces: np.ndarray
    """Triangles (F, 3), indices of `vertices`; none of a single point"""
    center: Array
    """(3,) [m] of a sphere around it"""
    radius: float
    """[m] of that sphere"""


@immutable
class MovingLink:
    """A link, and the joints that move it."""

    name: str
    robot: Robot
    """joints from the root to the link"""
    columns: tuple[int, ...]
    """of each joint of `robot` in the joint positions of the tip; -1 if it does not move
    the tip"""
    group: int
    """links of one group do not move relative to each other while the tip moves"""
    neighbour: int | None
    """parent group; None for the root's"""

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
    """The links whose pose follows from the positions of the tip's joints, parents first,
    at most `MOST_LINKS`."""
    group = {tree.root: 0}
    parents: dict[int, int | None] = {0: None}
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
                own, parents[len(parents)] = len(parents), own
            group[name] = own
        neighbour = parents[group[name]]
        links.append(MovingLink(name, robot, columns, group[name], neighbour))
    return links


def solids_of_links(path: str, links: Sequence[MovingLink]) -> list[Solid]:
    """Solids of the links by their collision geometry, or else by their visual one; none
    for links without geometry that can be read."""
    surfaces, every = LinkSurfaces(), read_geometries(path)
    solids = []
    for i, link in enumerate(links):
        own = [geometry for geometry in every if geometry.link == link.name]
        for part in ("collision", "visual"):
            chosen = [geometry for geometry in own if geometry.part == part]
            clouds = _clouds(chosen, surfaces)
            if clouds:
                name = f"link '{link.name}'"
                solids += [solid_of(name, i, cloud) for cloud in clouds]
                break
    return solids


def solid_of(name: str, link: int, points: Array) -> Solid:
    """The convex hull of points (N, 3) [m] in a link's frame; a single point as it is;
    for points in a plane their bounding box, at least `THIN` in thickness."""
    points, faces = _hull(points)
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = float(np.linalg.norm(points - center, axis=1).max())
    return Solid(name, link, frozen(points), faces, frozen(center), radius)


def _clouds(geometries: Sequence[Geometry], surfaces: LinkSurfaces) -> list[Array]:
    """Points (N, 3) whose convex hulls contain the geometries that can be read."""
    clouds = []
    for geometry in geometries:
        surface = surfaces.read(geometry)
        if surface is not None and geometry.kind == "mesh":
            clouds += convex_parts(*surface)
        elif surface is not None:
            clouds.append(_around(geometry, surface[0]))
    return clouds if len(clouds) <= MOST_SOLIDS else [np.concatenate(clouds)]


def _around(geometry: Geometry, vertices: Array) -> Array:
    """The vertices of a geometry, moved outwards for cylinders and spheres, so that their
    hull contains it."""
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
    """Vertices and triangles of the convex hull of points; no triangles of one point."""
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
"""Largest volume of the hulls of both parts, over that of the whole hull, for which a
surface is cut in two."""
DEEPEST = 2
"""Depth of cutting, for at most four parts. Base and upper arm of a UR5 then touch in 7 %
of random configurations; uncut in 33 %, and their meshes in 5 %."""
MOST_TRIANGLES = 50_000
"""Most triangles of a surface that is cut; collision meshes have some thousands."""
PLACES = (0.2, 0.4, 0.6, 0.8)
"""Places of possible cuts, as shares of the extent along an axis."""


def _directions(count: int) -> Array:
    """Unit vectors (count, 3), evenly distributed by the golden angle."""
    i = np.arange(count)
    z = (2.0 * i + 1.0) / count - 1.0
    turn = i * np.pi * (3.0 - np.sqrt(5.0))
    ring = np.sqrt(1.0 - z**2)
    return np.column_stack((ring * np.cos(turn), ring * np.sin(turn), z))


DIRECTIONS = _directions(100)
"""The farthest points of a large surface in these directions replace all: volumes are a
few hundredths too small, of whole and parts alike, and take a fifth of the time."""


def convex_parts(
    vertices: Array, faces: Indices, deepest: int = DEEPEST
) -> list[Array]:
    """Points (N, 3) of each part of a surface of vertices (V, 3) and triangles (F, 3).

    The surface is cut at the axis and place for which the hulls of both parts are
    smallest, as long as they are smaller by `SMALLER`. The hulls cover the surface. One
    of more than `MOST_TRIANGLES` is not cut.
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
    """An axis, and the coordinate [m] at a share of the vertices' extent along it."""
    low, high = vertices[:, axis].min(), vertices[:, axis].max()
    return axis, float(low + place * (high - low))


def _volume_cut(vertices: Array, edges: Indices, axis: int, at: float) -> float:
    """Volume [m³] of the hulls of both parts of a cut."""
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
    """Volume [m³] of the hull of points, or of those farthest in `DIRECTIONS` if there
    are more; zero if they are in a plane."""
    if len(points) > len(DIRECTIONS):
        points = points[np.unique((DIRECTIONS @ points.T).argmax(axis=1))]
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0


class Contacts:
    """Pairs of solids, and the distances between them.

    Raises `MissingDependencyError` without coal.
    """

    def __init__(self, solids: Sequence[Solid], pairs: Indices):
        with needing("coal", "robot"):
            coal: Any = import_module("coal")
        self._coal = coal
        self.solids, self.pairs = tuple(solids), np.asarray(pairs).reshape(-1, 2)
        self._shapes = [_convex(coal, solid) for solid in solids]
        self._request = coal.DistanceRequest()
        self._result = coal.DistanceResult()
        self._centers = np.array([solid.center for solid in solids])
        self._radii = np.array([solid.radius for solid in solids])

    def nearest(
        self, position: Array, rotation: Array, below: Array
    ) -> tuple[Array, Indices]:
        """Smallest distance (K,) [m] of any pair, negative where two solids overlap, and
        the index (K,) of that pair.

        `position` (K, S, 3) [m] and `rotation` (K, S, 3, 3) are those of the solids'
        links. Where no pair is nearer than `below` (K,) [m], this is the distance, and
        the index is -1.
        """
        bounds = self._bounds(position, rotation)
        distance, which = below.copy(), np.full(len(position), -1)
        for k in np.flatnonzero((bounds < below[:, None]).any(axis=1)):
            poses: dict[int, Any] = {}
            for p in np.argsort(bounds[k]):
                if bounds[k, p] >= distance[k]:
                    break
                own = self._distance(self.pairs[p], position[k], rotation[k], poses)
                if own < distance[k]:
                    distance[k], which[k] = own, p
        return distance, which

    def touching(self, position: Array, rotation: Array) -> Array:
        """Whether (K, P) each pair overlaps."""
        bounds = self._bounds(position, rotation)
        touch = np.zeros(bounds.shape, dtype=bool)
        for k, p in zip(*np.nonzero(bounds < 0.0), strict=True):
            pair = self.pairs[p]
            touch[k, p] = self._distance(pair, position[k], rotation[k], {}) <= 0.0
        return touch

    def _bounds(self, position: Array, rotation: Array) -> Array:
        """Lower bounds (K, P) [m] of the distances, by spheres around the solids."""
        center = np.einsum("ksij,sj->ksi", rotation, self._centers) + position
        first, second = self.pairs.T
        apart = np.linalg.norm(center[:, first] - center[:, second], axis=2)
        return apart - self._radii[first] - self._radii[second]

    def _distance(
        self, pair: Indices, position: Array, rotation: Array, poses: dict[int, Any]
    ) -> float:
        """Distance [m] of a pair in one configuration; `poses` caches those of solids."""
        for s in pair:
            if s not in poses:
                poses[s] = self._coal.Transform3s(rotation[s], position[s])
        i, j = pair
        self._result.clear()
        shapes = self._shapes
        return float(
            self._coal.distance(
                shapes[i], poses[i], shapes[j], poses[j], self._request, self._result
            )
        )


def _convex(coal: Any, solid: Solid) -> Any:
    """A solid as coal's convex shape."""
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(np.asarray(solid.vertices)))
    faces.extend([coal.Triangle(*map(int, face)) for face in solid.faces])
    return coal.Convex(points, faces)


MOST = 200_000
"""Most elements that are read: a humanoid with hands has some 5,000 pairs."""


def read_disabled_pairs(
    path: str | Path, links: Collection[str]
) -> frozenset[frozenset[str]]:
    """Pairs of `links` whose collisions an SRDF disables.

    Raises `InputError` if the file cannot be read, is not XML or xacro, its root is not
    ``<robot>``, it disables no pair of these links, or has more than `MOST` elements.
    """
    pairs: set[frozenset[str]] = set()
    roots: list[str] = []

    def start(tag: str, attributes: dict[str, str], *_: object):
        roots.append(tag)
        check_no_xacro(tag, path, "SRDF")
        if roots[0] != "robot":
            what = f"is not SRDF: its root is <{tag[:40]}>, not <robot>"
            raise InputError(what, where=path)
        if tag == "disable_collisions":
            pair = {attributes.get("link1", ""), attributes.get("link2", "")}
            if pair <= set(links):
                pairs.add(frozenset(pair))
        if len(roots) > MOST:
            raise InputError(f"has more than {MOST:,} elements", where=path)

    parse_xml(read_xml(path), path, start)
    if not pairs:
        what = "has no <disable_collisions> between links of the robot"
        raise InputError(what, where=path, fix="is it of this robot?")
    return frozenset(pairs)

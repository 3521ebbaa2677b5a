"""Distances between pairs of convex solids, by coal (extra ``robot``), and the pairs
that an SRDF disables."""

from collections.abc import Collection, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError, needing
from hefting.core.files import check_no_xacro, parse_xml, read_xml
from hefting.core.spatial import Array, Indices
from hefting.planning.solids import Solid


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

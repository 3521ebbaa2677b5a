"""Solids: a closed surface mesh, or a box, with its exact volume and moments."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array, frozen

LARGEST_DISTANCE = 1e3
"""[m] Largest coordinate of a box."""
BOX_FACES = (
    *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
    *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
)
"""Triangles of a box whose corner 4 i + 2 j + k is at its i-th x, j-th y and k-th z."""
MERGE_TOLERANCE = 1e-6
"""Distance over the diagonal up to about which vertices are merged."""
MOST_AROUND = 64
"""Number of the largest parts of a surface that may contain others."""
MAX_BOUNDARY = 500_000
"""Most boundary edges of the holes that are closed."""


@dataclass(frozen=True)
class Solid:
    """Closed, oriented surface: every edge is used as often in one direction as in the
    other.

    The winding number of a point is then the same integer for any direction.
    """

    vertices: Array
    """Vertices (V, 3) [m] in the axes of the shape's file."""
    faces: np.ndarray
    """Vertex indices (F, 3), counter-clockwise from outside; the last are the caps."""
    volume: float
    """Volume [m³], by the divergence theorem."""
    centroid: Array
    """Centre of volume (3,) [m]."""
    second_moment: Array
    """Second moment of volume (3, 3) [m²] about the centroid, divided by the volume."""
    cap_fraction: float
    """Share of the surface's area added to close holes; 0 for a watertight mesh."""

    @property
    def lower(self) -> Array:
        """Lower corner (3,) [m] of the bounding box along the axes of the file."""
        return self.vertices.min(axis=0)

    @property
    def extents(self) -> Array:
        """Sides (3,) [m] of the bounding box along the axes of the file."""
        return np.ptp(self.vertices, axis=0)


def solid_from_mesh(
    vertices: ArrayLike, faces: ArrayLike, where: object = None
) -> Solid:
    """Solid bounded by a triangle mesh, whose holes are closed: vertices (V, 3) [m] and
    faces (F, 3), in either orientation.

    Faces are oriented consistently, closed parts outward; then each boundary loop is
    closed by a fan to its centre.
    Raises `InputError`, with the shape's name `where`, for an empty mesh, coordinates
    that are not finite, and a surface that encloses no volume.
    """
    v, f = np.asarray(vertices, dtype=float), np.asarray(faces)
    if v.ndim != 2 or v.shape[1] != 3 or f.ndim != 2 or f.shape[1] != 3 or len(f) == 0:
        fix = "is the file whole? give a mesh with faces, or a point cloud as .xyz"
        raise InputError("the mesh has no triangles", where, fix)
    f = f.astype(np.int64)
    if f.min() < 0 or f.max() >= len(v):
        what = "a face of the mesh names a vertex that is not there"
        raise InputError(what, where, "export the mesh again")
    v, f = _merge(v, f, where)
    if len(f) == 0:
        raise InputError(
            "every triangle of the mesh is degenerate", where, "export the mesh again"
        )
    f = _orient(_without_copies(f), v)
    closed_v, caps = _caps(v, f, where)
    f_all = np.vstack((f, caps))
    volume, centroid, second = _moments(closed_v[f_all])
    if volume < 0:
        f_all, volume = f_all[:, ::-1], -volume
    if not volume > 1e-10 * float(np.linalg.norm(np.ptp(v, axis=0))) ** 3:
        fix = "give a closed mesh, or take its convex hull (`hull`)"
        what = (
            "the mesh encloses no volume (it is flat, or a surface without thickness)"
        )
        raise InputError(what, where, fix)
    if not np.linalg.eigvalsh(second)[0] > 0:
        what = "the mesh's surface is too tangled to tell inside from outside"
        raise InputError(what, where, "repair the mesh")
    area, cap_area = _area(closed_v[f]), _area(closed_v[caps])
    return Solid(
        frozen(closed_v),
        f_all,
        volume,
        frozen(centroid),
        frozen(second),
        cap_area / (area + cap_area),
    )


def _merge(v: Array, f: np.ndarray, where: object) -> tuple[Array, np.ndarray]:
    """The used vertices with near-duplicates merged, and the faces that still have three
    distinct corners."""
    used, _, index = _unique(f.ravel())
    v, f = v[used], index.reshape(-1, 3)
    if not np.isfinite(v).all() or np.abs(v).max() > 1e9:
        what = "the mesh has coordinates that are not finite, or beyond 1e9 m"
        raise InputError(what, where, "export the mesh again")
    origin, diagonal = v.min(axis=0), float(np.linalg.norm(np.ptp(v, axis=0)))
    if diagonal == 0:
        raise InputError(
            "all vertices of the mesh coincide", where, "export the mesh again"
        )
    # each below 2**20
    cell = np.round((v - origin) / (MERGE_TOLERANCE * diagonal)).astype(np.int64)
    keys = (cell[:, 0] << 40) + (cell[:, 1] << 20) + cell[:, 2]
    _, first, index = _unique(keys)
    v, f = v[first], index[f]
    distinct = (f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 2] != f[:, 0])
    return v, f[distinct]


def _unique(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`numpy.unique` of keys (N,) with first index and inverse, without its import of
    `numpy.ma`, which takes as long as reading a small mesh."""
    order = np.argsort(keys, kind="stable")
    new = np.r_[True, keys[order[1:]] != keys[order[:-1]]]
    first = order[new]
    index = np.empty(len(keys), dtype=np.int64)
    index[order] = np.cumsum(new) - 1
    return keys[first], first, index


def _without_copies(f: np.ndarray) -> np.ndarray:
    """Each face once; if nearly all faces occur in both orientations, in one of them."""
    lowest = np.argmin(f, axis=1)[:, None]
    f = f[_groups(np.take_along_axis(f, (lowest + np.arange(3)) % 3, axis=1))[0]]
    first, number = _groups(np.sort(f, axis=1))
    return f[first] if (number == 2).mean() > 0.9 else f


def _groups(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Index of one of each group of equal rows, and the sizes of the groups."""
    order = np.lexsort(rows.T)
    start = np.flatnonzero(
        np.r_[True, (rows[order[1:]] != rows[order[:-1]]).any(axis=1)]
    )
    return order[start], np.diff(np.r_[start, len(rows)])


def _edges(f: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Keys of the 3 F undirected edges, and their directions (+1 from the lower to the
    higher vertex)."""
    start, end = f.ravel(), np.roll(f, -1, axis=1).ravel()
    return np.minimum(start, end) * count + np.maximum(start, end), np.where(
        start < end, 1, -1
    )


def _orient(f: np.ndarray, v: Array) -> np.ndarray:
    """Faces with the orientation of their neighbours, outward on closed parts; on others
    that of most of the area.

    Two copies of every face, one in each orientation, form two separate components where
    the surface is orientable; each part of the surface takes the copy that agrees with
    more area of the given mesh.
    """
    keys, direction = _edges(f, len(v))
    order = np.argsort(keys, kind="stable")
    keys, direction, face = keys[order], direction[order], order // 3
    first = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
    pair = first[np.diff(np.r_[first, len(keys)]) == 2]
    flip = direction[pair] == direction[pair + 1]
    n, a, b = len(f), face[pair], face[pair + 1]
    label = _components(2 * n, np.r_[a, a + n], np.r_[b + n * flip, b + n * ~flip])
    area = np.linalg.norm(normals_of(v[f]), axis=1)
    kept = np.bincount(label[:n], weights=area, minlength=2 * n)
    here, there = label[:n], label[n:]
    turn = (kept[here] < kept[there]) | ((kept[here] == kept[there]) & (here > there))
    f = np.where(turn[:, None], f[:, ::-1], f)
    part = _unique(np.minimum(here, there))[2]
    inward = _inward(v, f, part)
    return np.where(inward[part][:, None], f[:, ::-1], f)


def _components(n: int, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(n,) the lowest node of the component of each node, in a graph with edges from `one`
    (e,) to `other`: roots of trees are joined, and trees flattened.

    SciPy's sparse graphs give the same; their import takes as long as the rest of an
    identification.
    """
    label = np.arange(n)
    while ((a := label[one]) != (b := label[other])).any():
        np.minimum.at(label, np.maximum(a, b), np.minimum(a, b))
        while ((root := label[label]) != label).any():
            label = root
    return label


def _inward(v: Array, f: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Which parts of a surface, given the part (F,) of each face, are closed with inward
    normals, as of mirrored instances in CAD. A part in the bounding box of another is a
    cavity or a solid in it, and has the result of that one."""
    corners = v[f]
    moment = np.einsum("fi,fi->f", corners[:, 0] - v[f[0, 0]], normals_of(corners))
    volume = np.bincount(part, moment)
    if not (volume < 0.0).any():
        return volume < 0.0
    keys, direction = _edges(f, len(v))
    edge = _unique(_unique(keys)[2] * len(volume) + np.repeat(part, 3))[2]
    is_open = np.bincount(edge, weights=direction)[edge] != 0
    volume[np.repeat(part, 3)[is_open]] = 0.0
    low, high = np.full((2, len(volume), 3), np.inf)
    np.minimum.at(low, part, corners.min(axis=1))
    np.minimum.at(high, part, -corners.max(axis=1))
    around = np.arange(len(volume))
    tolerance = MERGE_TOLERANCE * np.ptp(v, axis=0).max()
    for k in np.argsort(-(low + high).sum(axis=1))[-MOST_AROUND:]:
        inside = (low > low[k] - tolerance) & (high > high[k] - tolerance)
        around[inside.all(axis=1)] = k
    return volume[around] < 0.0


def _caps(v: Array, f: np.ndarray, where: object) -> tuple[Array, np.ndarray]:
    """The vertices with an apex added for each hole, and the triangles that close it,
    from its edges to the apex."""
    keys, direction = _edges(f, len(v))
    unique, _, index = _unique(keys)
    net = np.bincount(index, weights=direction).astype(int)
    count = np.abs(net)
    if not count.any():
        return v, np.empty((0, 3), dtype=np.int64)
    if count.sum() > MAX_BOUNDARY:
        raise InputError(
            "the mesh is mostly holes", where, "use its convex hull (Shape.from_hull)"
        )
    low, high = np.divmod(np.repeat(unique, count), len(v))
    forward = np.repeat(net > 0, count)
    loops = _loops(np.where(forward, high, low), np.where(forward, low, high))
    apexes, triangles = [], []
    for loop in loops:
        start, end = loop, np.roll(loop, -1)
        length = np.linalg.norm(v[end] - v[start], axis=1)
        apexes.append(
            (length[:, None] * (v[start] + v[end])).sum(axis=0) / (2 * length.sum())
        )
        triangles.append(
            np.column_stack((start, end, np.full(len(loop), len(v) + len(apexes) - 1)))
        )
    return np.vstack((v, apexes)), np.vstack(triangles)


def _loops(start: np.ndarray, end: np.ndarray) -> list[np.ndarray]:
    """Vertices, in order, of simple closed loops that use each of the directed edges (E,)
    once; each vertex has as many incoming as outgoing ones.

    Of a walk along unused edges the part between two visits of a vertex is cut off as a
    loop. The enclosed volume does not depend on which: along a seam whose two sides have
    separate vertices, the caps of a loop and of its reverse cancel.
    """
    unused_ends: dict[int, list[int]] = {}
    for a, b in zip(start.tolist(), end.tolist(), strict=True):
        unused_ends.setdefault(a, []).append(b)
    loops = []
    for origin in list(unused_ends):
        walk, index_in_walk = [origin], {origin: 0}
        while unused_ends[walk[-1]]:
            vertex = unused_ends[walk[-1]].pop()
            if vertex not in index_in_walk:
                index_in_walk[vertex] = len(walk)
                walk.append(vertex)
                continue
            first = index_in_walk[vertex]
            loops.append(np.array(walk[first:]))
            for removed in walk[first + 1 :]:
                del index_in_walk[removed]
            del walk[first + 1 :]
    return loops


def _area(triangles: Array) -> float:
    return 0.5 * float(np.linalg.norm(normals_of(triangles), axis=1).sum())


def _moments(triangles: Array) -> tuple[float, Array, Array]:
    """Volume, centroid and second moment per volume about it, of a closed surface: a
    sum of tetrahedra.

    Each triangle spans a tetrahedron with the mean vertex; the second moment of a
    tetrahedron with corners p1..p4 is V/20 (sum p_i p_i' + s s'), s = sum p_i (Tonon
    2004).
    """
    origin = triangles.mean(axis=(0, 1))
    t = triangles - origin
    share = np.einsum("fi,fi->f", t[:, 0], np.cross(t[:, 1], t[:, 2])) / 6
    volume = float(share.sum())
    if volume == 0:
        return 0.0, origin, np.zeros((3, 3))
    s = t.sum(axis=1)
    centroid = share @ s / (4 * volume)
    weighted = (share[:, None, None] * t).reshape(-1, 3)
    second = weighted.T @ t.reshape(-1, 3) + (share[:, None] * s).T @ s
    second = 0.5 * (second + second.T)
    return (
        volume,
        origin + centroid,
        second / (20 * volume) - np.outer(centroid, centroid),
    )


def box_solid(lower: ArrayLike, upper: ArrayLike) -> Solid:
    """The box between two corners (3,) [m], its sides along the axes of their frame.

    Raises `InputError` for corners that are not finite, not in order, or far away.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    if not (np.isfinite((low, high)).all() and (low < high).all()):
        what = "a box needs x0 < x1, y0 < y1, z0 < z1"
        raise InputError(what, "box", "give X0,X1,Y0,Y1,Z0,Z1 in metres")
    if max(-low.min(), high.max()) > LARGEST_DISTANCE:
        what = "a box is at most a kilometre from the sensor"
        raise InputError(what, "box", "give its sides in metres")
    return solid_from_mesh(corners_between(low, high), BOX_FACES, "box")


def corners_between(low: Array, high: Array) -> Array:
    """(8, 3) corners of a box from two (3,), the lowest first, the highest last."""
    return np.where(np.indices((2, 2, 2)).reshape(3, 8).T == 1, high, low)


def normals_of(triangles: Array) -> Array:
    """(F, 3) normals of triangles (F, 3, 3), of twice the area as length."""
    a, b, c = triangles.swapaxes(0, 1)
    return np.cross(b - a, c - a)

"""Shapes that are not the body's: what somebody might give in its place, and what would
be said of how well it is known, if anything."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.bodies import POINTS, Body
from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.shapes import Shape

COARSE: dict[str, Any] = {"shape_std": 0.2}
PLACED = {"pose_std": (0.005, float(np.radians(5.0)))}


def _box(body: Body, rng: np.random.Generator) -> Shape:
    """The solid of the mesh's bounding box."""
    return _placed(body, body.mesh.bounding_box)


def _around(body: Body, rng: np.random.Generator) -> Shape:
    """A box in sensor axes that touches the body, which is tilted in it."""
    low, high = body.shape.hull.min(axis=0), body.shape.hull.max(axis=0)
    return Shape.from_box(*np.stack((low, high), axis=1).ravel(), points=POINTS)


def _generous(body: Body, rng: np.random.Generator) -> Shape:
    """A box in sensor axes, each side 1.2 to 2.5 times as long as needed, the body
    anywhere in it."""
    low, high = body.shape.hull.min(axis=0), body.shape.hull.max(axis=0)
    sides = (high - low) * rng.uniform(1.2, 2.5, 3)
    low = low - (sides - (high - low)) * rng.uniform(size=3)
    return Shape.from_box(*np.stack((low, low + sides), axis=1).ravel(), points=POINTS)


def _unknown(body: Body, rng: np.random.Generator) -> Shape:
    return Shape.unknown()


def _open(body: Body, rng: np.random.Generator) -> Shape:
    """A mesh without most of what faces away from a camera, a fifth to a half of the
    way down; another where that cannot be closed, which is told."""
    whole = body.mesh.copy().subdivide_to_size(float(max(body.mesh.extents)) / 8.0)
    while True:
        mesh, view = whole.copy(), rng.normal(size=3)
        view /= np.linalg.norm(view)
        depth = mesh.triangles_center @ view
        hidden = depth < np.quantile(depth, rng.uniform(0.2, 0.5))
        mesh.update_faces(~(hidden & (mesh.face_normals @ view < -0.3)))
        try:
            return _placed(body, mesh)
        except InputError:
            continue


def _hull(body: Body, rng: np.random.Generator) -> Shape:
    return Shape.from_hull(body.mesh, pose=body.shape.pose, points=POINTS)


def _scaled(factor: float) -> Callable[[Body, np.random.Generator], Shape]:
    def scaled(body: Body, rng: np.random.Generator) -> Shape:
        mesh = body.mesh.copy()
        about = mesh.centroid if rng.random() < 0.5 else np.zeros(3)
        mesh.vertices = about + factor * (mesh.vertices - about)
        return _placed(body, mesh)

    return scaled


def _misplaced(body: Body, rng: np.random.Generator) -> Shape:
    """By 5 mm in a random direction and 5 degrees about a random axis, through the
    origin of the file or its middle."""
    aside, axis = rng.normal(size=(2, 3))
    pose, turn = np.array(body.shape.pose), np.eye(4)
    turn[:3, :3] = Rotation.from_rotvec(
        np.radians(5.0) * axis / np.linalg.norm(axis)
    ).as_matrix()
    middle = body.mesh.centroid if rng.random() < 0.5 else np.zeros(3)
    turn[:3, 3] = middle - turn[:3, :3] @ middle + 0.005 * aside / np.linalg.norm(aside)
    return Shape.from_mesh(body.mesh, pose=pose @ turn, points=POINTS)


def _noisy(body: Body, rng: np.random.Generator) -> Shape:
    """A scan of the surface with 3 mm of noise."""
    return _of_scan(body, _scan(body, rng) + rng.normal(size=(2000, 3)) * 0.003)


def _one_sided(body: Body, rng: np.random.Generator) -> Shape:
    """A scan by a camera on one side: of the surface that faces it."""
    import trimesh

    sampled = trimesh.sample.sample_surface(
        body.mesh, 4000, seed=int(rng.integers(1 << 31))
    )
    points, faces = sampled[0], sampled[1]
    view = rng.normal(size=3)
    facing = body.mesh.face_normals[faces] @ view > 0.0
    return _of_scan(
        body,
        np.asarray(points)[facing] + rng.normal(size=(int(facing.sum()), 3)) * 0.001,
    )


def _scan(body: Body, rng: np.random.Generator) -> Array:
    import trimesh

    return np.asarray(
        trimesh.sample.sample_surface(body.mesh, 2000, seed=int(rng.integers(1 << 31)))[
            0
        ]
    )


def _of_scan(body: Body, cloud: Array) -> Shape:
    return Shape.from_hull(cloud, pose=body.shape.pose, points=POINTS)


def _placed(body: Body, mesh: Any) -> Shape:
    return Shape.from_mesh(mesh, pose=body.shape.pose, points=POINTS)


WRONG: dict[
    str, tuple[Callable[[Body, np.random.Generator], Shape], dict[str, Any]]
] = {
    "box": (_box, COARSE),
    "hull": (_hull, COARSE),
    "larger": (_scaled(1.2), COARSE),
    "smaller": (_scaled(0.8), COARSE),
    "misplaced": (_misplaced, PLACED),
    "noisy scan": (_noisy, COARSE),
    "one side": (_one_sided, COARSE),
    "misplaced, unsaid": (_misplaced, {}),
    "sensor box": (_around, {}),
    "generous box": (_generous, {}),
    "open mesh": (_open, {}),
    "unknown": (_unknown, {}),
}
"""What is given for the body's shape, and the deviations that are stated."""

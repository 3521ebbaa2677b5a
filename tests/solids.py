"""Solids for tests of shapes, and an inside test that shares no code with the
library."""

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from hefting.core.spatial import pose_matrix


def winding(triangles, points):
    """Generalised winding numbers by solid angles (Van Oosterom & Strackee 1983): the
    oracle for "inside"."""
    a, b, c = (triangles[None, :, i] - points[:, None] for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
    dot = np.einsum
    above = dot("pfi,pfi->pf", a, np.cross(b, c))
    below = la * lb * lc + dot("pfi,pfi->pf", a, b) * lc
    below += dot("pfi,pfi->pf", b, c) * la + dot("pfi,pfi->pf", c, a) * lb
    return np.arctan2(above, below).sum(axis=1) / (2 * np.pi)


def rotated(mesh, seed=3):
    turned = mesh.copy()
    turned.apply_transform(
        np.block(
            [[Rotation.random(rng=seed).as_matrix(), np.ones((3, 1))], [np.eye(4)[3:]]]
        )
    )
    return turned


def ell():
    """An L of 40 x 40 x 20 mm with arms 10 mm wide, as two boxes that share a wall."""
    long = trimesh.creation.box(bounds=[[0, 0, 0], [0.04, 0.01, 0.02]])
    short = trimesh.creation.box(bounds=[[0, 0.01, 0], [0.01, 0.04, 0.02]])
    return trimesh.util.concatenate([long, short])


def in_ell(p):
    in_long = (p > 0).all(axis=1) & (p < [0.04, 0.01, 0.02]).all(axis=1)
    return in_long | (
        (p > [0, 0.009, 0]).all(axis=1) & (p < [0.01, 0.04, 0.02]).all(axis=1)
    )


SOLIDS = {
    "box": trimesh.creation.box((0.1, 0.2, 0.05)),
    "sphere": trimesh.creation.icosphere(3, 0.05),
    "cylinder": trimesh.creation.cylinder(0.02, 0.15),
    "ring": trimesh.creation.annulus(0.03, 0.05, 0.02),
    "torus": trimesh.creation.torus(0.05, 0.01),
    "ell": ell(),
    "plate": trimesh.creation.box((0.165, 0.001, 0.02)),
    "needle": trimesh.creation.box((0.3, 0.001, 0.001)),
    "tilted plate": rotated(trimesh.creation.box((0.165, 0.001, 0.02))),
    "tilted ring": rotated(trimesh.creation.annulus(0.03, 0.05, 0.02)),
}
POSE = pose_matrix([0.1, -0.2, 0.05, *Rotation.random(rng=1).as_quat()])

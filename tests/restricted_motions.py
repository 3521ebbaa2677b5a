"""Motions that tell only part of a body: at rest in some poses, and turns about one
axis."""

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.measurements import Measurements
from hefting.core.spatial import PARAMETERS
from hefting.ingest.free_fit import fit_freely
from hefting.ingest.identifiability import identifiability
from random_problems import random_body, with_wrench

SIZE = 0.2
INERTIA = PARAMETERS[4:]
G = 9.80665


def at_rest(*gravity_directions, each=20):
    """Samples at rest with gravity along each of the directions in turn."""
    g = np.repeat(
        G * np.array([np.array(d) / np.linalg.norm(d) for d in gravity_directions]),
        each,
        axis=0,
    )
    return Measurements(0.01 * np.arange(len(g)), g, *np.zeros((5, len(g), 3)))


def turning(axis, gravity=(0.0, 0.0, -1.0), swing=1.0, K=300):
    """Swings of `swing` rad about an axis (3,) through the sensor's origin; `gravity`
    in sensor axes at angle 0."""
    t = 0.01 * np.arange(K)
    n, angular = np.array(axis) / np.linalg.norm(axis), 2.0 * np.pi * 0.7
    angle = swing * np.sin(angular * t)
    speed = swing * angular * np.cos(angular * t)
    acceleration = -swing * angular**2 * np.sin(angular * t)
    g = Rotation.from_rotvec(-angle[:, None] * n).apply(
        G * np.array(gravity) / np.linalg.norm(gravity)
    )
    return Measurements(
        t,
        g,
        np.zeros((K, 3)),
        speed[:, None] * n,
        acceleration[:, None] * n,
        *np.zeros((2, K, 3)),
    )


def judged(motion, bias=False, force=0.05, torque=0.0025, seed=0, mass=1.0, size=SIZE):
    """Identifiability of a random body in `motion`, with noise in the wrench."""
    rng = np.random.default_rng(seed)
    z = with_wrench(motion, random_body(rng, mass), 0.0, rng, force, torque)
    return identifiability(z, fit_freely(z, bias), size)


def rotated(z, R):
    """The motion in sensor axes turned by R (3, 3)."""
    pose = np.eye(4)
    pose[:3, :3] = R
    return z.moved(pose)

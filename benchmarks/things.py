"""Things of several materials as solids with a density: hammers, drills, bottles half
full, dumbbells."""

from collections.abc import Callable
from typing import Any

import numpy as np

from hefting.core.spatial import Array
from hefting.simulation import Assembly, Part

Density = Callable[[Array], Array]
"""Density (N,), in any unit, at points (N, 3) [m] in the axes of the solid."""

ALONG_X = np.array(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))
"""Turns a cylinder along z into one along x."""
STEEL, IRON, WATER, GLASS = 7.8, 7.2, 1.0, 2.5
"""Densities [g/cm³]."""


def hammer(rng: np.random.Generator) -> tuple[Any, Density]:
    """A handle of wood, plastic or glass fibre along z, a steel head across its end."""
    length, width = rng.uniform(0.18, 0.35), rng.uniform(0.022, 0.036)
    across, high = rng.uniform(0.07, 0.14), rng.uniform(0.022, 0.045)
    top = 0.5 * length
    aside = rng.uniform(-0.15, 0.15) * across
    if rng.random() < 0.5:
        handle = Part("cylinder", (0.5 * width, length), 1.0, (0.0, 0.0, 0.0))
    else:
        handle = Part("box", (width, 0.8 * width, length), 1.0, (0.0, 0.0, 0.0))
    if rng.random() < 0.5:
        size = (across, rng.uniform(0.7, 1.2) * high, high)
        head = Part("box", size, 1.0, (aside, 0.0, top))
    else:
        head = Part(
            "cylinder", (0.5 * high, across), 1.0, (aside, 0.0, top), np.array(ALONG_X)
        )
    light = rng.uniform(0.55, 2.0)
    return Assembly("hammer", (handle, head)).mesh(24), lambda x: np.where(
        x[:, 2] > top - 0.5 * high, STEEL, light
    )


def drill(rng: np.random.Generator) -> tuple[Any, Density]:
    """A motor and a chuck along x, a handle of plastic and air below, a battery at its
    foot."""
    radius, length = rng.uniform(0.025, 0.036), rng.uniform(0.11, 0.17)
    chuck, chuck_radius = rng.uniform(0.025, 0.05), rng.uniform(0.4, 0.7) * radius
    drop, side = rng.uniform(0.1, 0.15), rng.uniform(0.028, 0.04)
    foot = (rng.uniform(0.07, 0.12), rng.uniform(0.05, 0.08), rng.uniform(0.03, 0.06))
    back = rng.uniform(-0.3, 0.1) * length
    parts = (
        Part("cylinder", (radius, length), 1.0, (0.0, 0.0, 0.0), np.array(ALONG_X)),
        Part(
            "cylinder",
            (chuck_radius, chuck + 0.02),
            1.0,
            (0.5 * (length + chuck - 0.02), 0.0, 0.0),
            np.array(ALONG_X),
        ),
        Part("box", (side, side, drop), 1.0, (back, 0.0, -0.5 * drop)),
        Part("box", foot, 1.0, (back, 0.0, -drop - 0.4 * foot[2])),
    )
    plastic, motor, battery = rng.uniform((0.3, 2.5, 1.8), (0.9, 5.0, 2.8))
    gearbox = rng.uniform(-0.35, 0.0) * length

    def density(x: Array) -> Array:
        upper = x[:, 2] > -radius
        found = np.where(upper & (x[:, 0] > gearbox), motor, plastic)
        found = np.where(upper & (x[:, 0] > 0.5 * length), STEEL, found)
        return np.where(x[:, 2] < -drop + 0.1 * foot[2], battery, found)

    return Assembly("drill", parts).mesh(24), density


def bottle(rng: np.random.Generator) -> tuple[Any, Density]:
    """A wall of plastic or glass, water from a third to two thirds of the way up, air
    above; it may have frozen as it lay."""
    radius, length = rng.uniform(0.028, 0.05), rng.uniform(0.12, 0.26)
    neck, neck_length = rng.uniform(0.3, 0.5) * radius, rng.uniform(0.02, 0.08)
    parts = (
        Part("cylinder", (radius, length), 1.0, (0.0, 0.0, 0.0)),
        Part(
            "cylinder",
            (neck, neck_length + 0.02),
            1.0,
            (0.0, 0.0, 0.5 * (length + neck_length - 0.02)),
        ),
    )
    thick = rng.uniform(0.002, 0.006)
    wall = rng.choice((WATER, GLASS))
    up = np.array((0.0, 0.0, 1.0)) if rng.random() < 0.7 else rng.normal(size=3)
    up /= np.linalg.norm(up)
    reach = 0.5 * length * abs(up[2]) + radius * float(np.hypot(up[0], up[1]))
    level = rng.uniform(-1.0 / 3.0, 1.0 / 3.0) * reach

    def density(x: Array) -> Array:
        across = np.hypot(x[:, 0], x[:, 1])
        inner = np.where(x[:, 2] < 0.5 * length, radius, neck) - thick
        inside = (across < inner) & (x[:, 2] > thick - 0.5 * length)
        inside &= ~((across > neck) & (x[:, 2] > 0.5 * length - thick))
        return np.where(inside, np.where(x @ up < level, WATER, 0.0012), wall)

    return Assembly("bottle", parts).mesh(24), density


def dumbbell(rng: np.random.Generator) -> tuple[Any, Density]:
    """Two iron heads, one at each end of a grip of tube, wood or plastic."""
    grip, length = rng.uniform(0.012, 0.02), rng.uniform(0.1, 0.16)
    radius, thick = rng.uniform(0.03, 0.06), rng.uniform(0.03, 0.07)
    places = 0.5 * (length + thick) * np.array((-1.0, 1.0))
    parts = [Part("cylinder", (grip, length + 0.02), 1.0, (0.0, 0.0, 0.0))]
    parts += [
        Part("cylinder", (radius, thick), 1.0, (0.0, 0.0, float(z))) for z in places
    ]
    light = rng.uniform(0.5, 4.0)
    return Assembly("dumbbell", tuple(parts)).mesh(24), lambda x: np.where(
        np.abs(x[:, 2]) > 0.5 * length, IRON, light
    )


THINGS: dict[str, Callable[[np.random.Generator], tuple[Any, Density]]] = {
    "hammer": hammer,
    "drill": drill,
    "bottle": bottle,
    "dumbbell": dumbbell,
}

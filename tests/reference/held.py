"""What the cases of estimators are about: measurements of a hammer and of random bodies,
and shapes of which more or less is known."""

from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np

from hammers import noisy, shape
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.spatial import Array
from hefting.shapes import Shape
from hefting.simulation import hammer
from random_problems import random_body, random_motion, with_wrench

BIAS = np.array((2.0, -1.0, 3.0, 0.1, 0.2, -0.1))
TOOL = random_body(np.random.default_rng(20), 0.4, 0.04, 0.05).vector


@cache
def dynamic() -> Measurements:
    """A hammer that is wielded, with the paper's noise."""
    return noisy(11, 250)


@cache
def biased() -> Measurements:
    """The same with a bias, weights, and errors of the motion that last."""
    z, rng = noisy(12, 320), np.random.default_rng(12)
    return replace(
        z,
        force=z.force + BIAS[:3],
        torque=z.torque + BIAS[3:],
        weights=rng.uniform(0.5, 1.5, len(z)),
        motion_noise=MotionNoise(0.05, 0.4, 0.03),
    )


@cache
def slow() -> Measurements:
    """Poses at rest: gravity alone."""
    rng = np.random.default_rng(13)
    motion = random_motion(rng, 30, speed=0.0)
    return with_wrench(motion, hammer().parameters, 0.0, rng, 0.1, 0.005)


@cache
def few() -> Measurements:
    """Five samples of fast motion."""
    rng = np.random.default_rng(14)
    return with_wrench(
        random_motion(rng, 5, 3.0), hammer().parameters, 0.0, rng, 0.05, 0.002
    )


@cache
def coloured() -> Measurements:
    """Noise that lasts over ten samples, larger in the second half, and a gain that is
    wrong there."""
    z, rng = noisy(15, 700, Noise(0.02, 0.001)), np.random.default_rng(15)
    noise = rng.normal(size=(len(z), 6)) * np.repeat((0.1, 0.005), 3)
    for k in range(1, len(z)):
        noise[k] = 0.9 * noise[k - 1] + 0.45 * noise[k]
    size = np.where(np.arange(len(z)) < 350, 1.0, 2.0)[:, None]
    gain = np.where(np.arange(len(z)) < 450, 1.0, 1.02)[:, None]
    wrench = gain * z.wrench + size * noise
    return replace(z, force=wrench[:, :3], torque=wrench[:, 3:])


@cache
def fine() -> Shape:
    """The hammer's shape by many points."""
    return Shape.from_mesh(hammer().mesh(), points=700)


@cache
def parts() -> Shape:
    """The hammer's shape by points of its parts, told by where they are."""
    whole = shape()
    along = whole.positions[:, int(np.argmax(whole.extents))]
    label = np.digitize(along, np.quantile(along, (0.4, 0.8)))
    return Shape(whole.positions, whole.volumes, labels=label)


@cache
def box(known: Literal["object", "bounds"] = "object") -> Shape:
    """A box about the hammer, as its own shape or as what bounds it."""
    ends = np.column_stack((shape().hull.min(axis=0), shape().hull.max(axis=0)))
    return replace(Shape.from_box(*ends.ravel(), points=80), known=known)


def covariance_of_tool() -> Array:
    """Of a tool that was subtracted."""
    F = np.random.default_rng(21).normal(size=(10, 10))
    size = np.concatenate(([1e-3], np.full(3, 1e-4), np.full(6, 1e-5)))
    return (F @ F.T) * np.outer(size, size)

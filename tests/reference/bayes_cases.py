"""Cases of `hefting.estimators.bayes`: its options, and its parts one by one."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from hammers import shape
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.spatial import Array
from hefting.estimators import Bayes
from hefting.estimators.bayes.bounds import (
    BOUNDS_MEMBERS,
    EVEN_COM,
    REACH_MEMBERS,
    bounded_members,
)
from hefting.estimators.bayes.colour import spectrum
from hefting.estimators.bayes.densities import member_covariances
from hefting.estimators.bayes.distortion import Distortions
from hefting.estimators.bayes.mixture import prior_mixture
from hefting.estimators.bayes.posterior import Posterior
from hefting.estimators.bayes.prior import Prior
from hefting.estimators.bayes.projection import projected
from hefting.estimators.bayes.voxels import Voxels
from hefting.estimators.raw_motion import white_motion_noise, white_noise
from hefting.shapes import Shape
from reference.held import (
    TOOL,
    biased,
    box,
    coloured,
    covariance_of_tool,
    dynamic,
    few,
    fine,
    slow,
)

SHARES = np.random.default_rng(40).normal(size=(64, 3))
"""Directions in which each member of a mixture is seen."""
ELSEWHERE = replace(
    Shape.from_box(0.1, 0.15, -0.2, 0.3, 0.02, 0.4, points=60), shape_std=0.1
)
"""Where there is no mass."""


def estimated(measurements: Callable[[], Measurements], **options: Any) -> Any:
    """The estimate, and the posterior with how it was found.

    The accuracy that is claimed is not held: it is that of draws, which depend on the
    signs of a factor.
    """
    estimator = Bayes(**options)
    z = measurements()
    state = estimator.update(estimator.start(), z)
    posterior = estimator.posterior(state)
    return {
        "estimate": replace(estimator.estimate(state), accuracy=None),
        "posterior": of_posterior(posterior),
    }


def of_posterior(posterior: Posterior) -> dict[str, Any]:
    """What is found on the way."""
    last, mixture = posterior.last, posterior.mixture
    return {
        **{name: v for name, v in vars(posterior).items() if name not in OMITTED},
        "weights": mixture.weights,
        "half": mixture.intervals(0.5)["mass"],
        "colour": last.noise.colour,
        "calibration": last.noise.calibration,
        "response": last.noise.response,
        "scale": last.scale,
        "com": last.com,
        "scores": last.scores,
        "wrench": last.wrench,
    }


OMITTED = ("mixture", "last", "prior", "move", "samples")
"""Parts of a posterior that are told by their numbers."""


def of_several() -> dict[str, Any]:
    """Two recordings; and a posterior that goes on from the one before, twice, as a first
    pass ends anywhere within its tolerance."""
    estimator = Bayes(shape(), bias="estimate")
    first, second = (
        estimator.update(estimator.start(), z) for z in (dynamic()[:120], biased())
    )
    before, last = estimator.continued(first, None)
    more = estimator.update(first, dynamic()[120:])
    _, settled = estimator.continued(more, last)
    return {
        "two": estimator.estimate(estimator.merge(first, second)),
        "before": before,
        "continued": estimator.continued(more, settled)[0],
        "from estimate": estimator.estimate(more, before),
    }


def member_numbers(each: Array) -> Array:
    """Each member of a mixture by itself: norms along directions of its covariance (j,
    n, n)."""
    along = SHARES[: each.shape[1]]
    return np.sqrt(np.einsum("ik,jil,lk->jk", along, each, along))


def densities(solid: Callable[[], Shape]) -> dict[str, Any]:
    """Every member of the mixture for a shape, and what it is made of."""
    voxels = Voxels.of(solid())
    diagonal = float(np.linalg.norm(solid().extents))
    units = np.repeat((0.1, 0.01), (3, 6))
    prior = Prior.of(solid())
    members = member_covariances(voxels, diagonal, units)
    exact = Prior.of(solid(), (0.0, 0.0))
    spread = prior.spread @ prior.spread.transpose(0, 2, 1)
    return {
        "voxels": voxels,
        **{f"member {j}": row for j, row in enumerate(member_numbers(members))},
        **{f"spread {j}": row for j, row in enumerate(member_numbers(spread)[:, :2])},
        "log weight": prior.log_weight.tolist(),
        "mean": prior.mean,
        "cells": prior.cells,
        "known mass": prior_mixture(exact, 0.7).intervals(0.95),
        "free mass": prior_mixture(prior, 0.7, False).covariance,
    }


def bounds(table: Array, least_gamma: float) -> dict[str, Any]:
    """Every member of the mixture for a box."""
    means, factors = bounded_members(table, np.array((0.2, 0.3, 0.1)), least_gamma)
    covariances = factors @ factors.transpose(0, 2, 1)
    return {
        "means": [*means],
        "stds": [np.sqrt(Q.diagonal()) for Q in covariances],
        "along": [*member_numbers(covariances)],
    }


def bounded(solid: Callable[[], Shape]) -> dict[str, Any]:
    """The prior of an object inside of a box, or near the sensor."""
    prior = Prior.of_bounds(solid())
    mixture = prior_mixture(prior.about(np.zeros(0), prior.mean[1:4] + 0.05).prior, 0.7)
    return {
        "mean": prior.mean,
        "log weight": [float(weight) for weight in prior.log_weight],
        "offsets": [*prior.offsets[:, 1:]] if prior.offsets is not None else [],
        "about": mixture.intervals(0.95),
        "covariance": mixture.covariance,
    }


def distorted() -> dict[str, Any]:
    """What is wrong with a shape or its pose, and what follows."""
    found = {
        "typical": Distortions.typical(shape()),
        "pose": Distortions.of(box(), (0.01, 0.1), 0.0),
        "shape": Distortions.of(shape(), None, 0.2),
        "both": Distortions.of(box(), (0.02, 0.0), 0.1),
    }
    body = shape().homogeneous.vector
    result: dict[str, Any] = {}
    for name, each in found.items():
        scores = np.linspace(-1.0, 1.0, len(each.shifts))
        move = each.by(scores)
        result[name] = {
            "ways": each,
            "move": move,
            "back": move.back(np.array((0.1, 0.2, 0.3))),
            "effects": each.effects(body, scores),
            "covariance": each.covariance(body),
        }
    prior = Prior.of(shape(), (0.01, 0.1), 0.1)
    placed = prior.about(np.full(len(prior.distortions.shifts), 0.5), np.ones(3) * 0.02)
    weights = np.exp(prior.log_weight)
    means = prior.mean + 0.1 * np.random.default_rng(41).normal(size=(len(weights), 10))
    return result | {
        "about": {"spread": placed.prior.spread, "mean": placed.prior.mean},
        "effects": placed.effects,
        "most likely": placed.most_likely(weights, means * (1.0, *[0.01] * 9)),
        "stated": prior.mean_as_stated(weights, means),
    }


def spectra() -> dict[str, Any]:
    """Noise by time scale, of records of any length."""
    rng = np.random.default_rng(42)
    found: dict[str, Any] = {}
    for J, samples in ((1, 3.0), (4, 20.0), (9, 800.0)):
        degrees = np.maximum(6.0 * samples * 0.5 ** np.arange(1, J + 1) - 2.0, 0.0)
        for slope in (0.0, 0.8):
            energies = (
                degrees * 2.0 ** (slope * np.arange(J)) * rng.uniform(0.8, 1.2, J)
            )
            for free_bias in (False, True):
                name = f"{J} {slope} {free_bias}"
                found[name] = list(spectrum(energies, degrees, samples, free_bias))
    z = dynamic()
    noisy = z.with_noise(Noise(0.1, 0.01, 0.3, 1.0), 3)
    return found | {
        "white": [white_noise(z), white_noise(noisy)],
        "of motion": [white_motion_noise(z), white_motion_noise(noisy)],
    }


def nearest() -> dict[str, Any]:
    """Masses of cells that come nearest to ten numbers."""
    prior = Prior.of(shape())
    mixture = prior_mixture(prior, 0.7, False)
    rng = np.random.default_rng(43)
    found: dict[str, Any] = {}
    for size in (0.3, 3.0):
        F = np.linalg.cholesky(mixture.covariance)
        target = mixture.mean + size * F @ rng.normal(size=10)
        masses, distance, _ = projected(
            target, mixture.covariance, prior.cells, prior.shares, 0.7
        )
        found[str(size)] = [prior.cells @ masses, distance]
    return found


CASES: dict[str, Callable[[], Any]] = {
    "dynamic": partial(estimated, dynamic, shape=shape()),
    "biased": partial(estimated, biased, shape=shape(), bias="estimate"),
    "biased slow": partial(estimated, slow, shape=shape(), bias="estimate"),
    "coloured": partial(estimated, coloured, shape=shape(), bias="estimate"),
    "unknown": partial(estimated, dynamic),
    "unknown slow": partial(estimated, slow),
    "bounds": partial(estimated, biased, shape=box("bounds"), bias="estimate"),
    "box": partial(estimated, few, shape=box(), pose_std=(0.0, 0.0)),
    "fine": partial(estimated, slow, shape=fine()),
    "shape std": partial(estimated, dynamic, shape=shape(), shape_std=0.1),
    "pose std": partial(estimated, slow, shape=shape(), pose_std=(0.01, 0.1)),
    "elsewhere": partial(estimated, dynamic, shape=ELSEWHERE),
    "given noise": partial(estimated, dynamic, shape=shape(), noise=Noise(0.1, 0.005)),
    "given motion noise": partial(
        estimated,
        lambda: replace(dynamic(), motion_noise=MotionNoise(0.05, 0.5, 0.02)),
        shape=shape(),
        noise=np.diag((0.01, 0.02, 0.01, 3e-5, 2e-5, 1e-5)),
    ),
    "too little noise given": partial(
        estimated, coloured, shape=shape(), noise=Noise(0.05, 0.003)
    ),
    "sensor": partial(
        estimated, biased, shape=shape(), sensor_accuracy="2% 0.5N 0.02Nm"
    ),
    "sensor biased": partial(
        estimated,
        coloured,
        shape=shape(),
        sensor_accuracy="1% 0.3N 0.01Nm",
        bias="estimate",
    ),
    "tool": partial(
        estimated,
        biased,
        shape=shape(),
        systematic=covariance_of_tool(),
        carried=TOOL,
        bias="estimate",
    ),
    "weighed": partial(
        estimated, coloured, shape=shape(), mass="0.672kg±1g", bias="estimate"
    ),
    "weighed wrong": partial(estimated, dynamic, shape=shape(), mass="0.9kg±1g"),
    "points": partial(estimated, dynamic, shape=Shape(shape().positions)),
    "one point": partial(estimated, dynamic, shape=Shape(shape().positions[:1])),
    "line": partial(
        estimated, slow, shape=Shape(shape().positions * (0.0, 0.0, 1.0) + 0.01)
    ),
    "common errors": partial(
        estimated,
        dynamic,
        shape=shape(),
        systematic=np.diag((1e-6, 0, 0, 1e-8, *np.zeros(6))),
    ),
    "until": partial(
        estimated, dynamic, shape=shape(), until="mass=5%,com=5mm,inertia=50%"
    ),
    "several": of_several,
    "densities hammer": partial(densities, shape),
    "densities box": partial(densities, box),
    "bounds members": partial(bounds, BOUNDS_MEMBERS, EVEN_COM),
    "bounds members even": partial(bounds, BOUNDS_MEMBERS, 0.0),
    "reach members": partial(bounds, REACH_MEMBERS, 0.0),
    "prior of bounds": partial(bounded, partial(box, "bounds")),
    "prior of reach": partial(bounded, Shape.unknown),
    "distorted": distorted,
    "spectra": spectra,
    "nearest": nearest,
}
"""By name."""

"""Plausibility: what no held object could cause is refused, what is unlikely is said."""

from dataclasses import replace

import numpy as np

from hefting.calibration import FreeFit, fit_freely, lever
from hefting.errors import InputError
from hefting.estimate import Estimate
from hefting.measurements import Measurements
from hefting.shapes import PointMasses
from hefting.spatial import Array

LARGEST = 10.0
"""No robot wields a thing this long [m]."""
HEAVIEST = 1000.0
"""No robot holds this much [kg]."""
DENSEST = 23_000.0
"""No material is heavier [kg/m³] (osmium: 22,590)."""
MISFIT = 3.0
"""A residual this many times that of unconstrained least squares is not noise."""


def check_shape(shape: PointMasses | None) -> None:
    """`InputError` for a shape too long to be held."""
    if shape is not None and float(shape.extents.max()) > LARGEST:
        raise InputError(
            f"the shape is {shape.extents.max():.3g} m long", fix="is its file in millimetres? give --unit mm"
        )


def check_wrench(z: Measurements, fit: FreeFit, shape: PointMasses | None, source: str) -> None:
    """`InputError` for a wrench that only a wrong unit explains, judged by unconstrained least squares."""
    mass = 0.0 if fit.mass_is_open else abs(float(fit.vector[0]))
    if mass > HEAVIEST:
        raise InputError(f"the force would need {mass:.3g} kg", source, "give it in newtons; check --gravity")
    reach = LARGEST
    if shape is not None:
        volume = float(np.prod(shape.extents))
        if 0.0 < DENSEST * volume < mass:
            what = f"the force would need {mass:.3g} kg in a shape of at most {1e6 * volume:.3g} cm³"
            raise InputError(what, source, "give force in newtons; check the shape's unit")
        reach = 1.5 * float(np.linalg.norm(shape.positions, axis=1).max()) + 2.0 * float(np.linalg.norm(shape.extents))
    distance = lever(z, fit.bias is not None)
    if distance > reach:
        what = f"the torque puts the centre of mass {distance:.3g} m from the sensor"
        raise InputError(what, source, "give torque in newton-metres; check the shape's unit and pose")


def com_warnings(fit: FreeFit, shape: PointMasses | None) -> list[str]:
    """A sentence when unconstrained least squares puts the COM well outside the shape."""
    spread = float(np.sqrt(fit.covariance.diagonal()[1:4].max())) / max(abs(float(fit.vector[0])), 1e-12)
    if shape is None or not fit.mass_t > 10.0 or not np.isfinite(spread):
        return []
    com = fit.vector[1:4] / fit.vector[0]
    local = (com - shape.positions.mean(axis=0)) @ shape.pose[:3, :3]
    if float(np.max(np.abs(local) - 0.75 * shape.extents)) <= 3.0 * spread:
        return []
    place = ", ".join(f"{1e3 * x:.0f}" for x in com)
    return [
        f"without the shape the COM would be at ({place}) mm, well outside it: check the shape's pose and unit, the "
        "units of force and torque, and the wrench's sign and bias"
    ]


def gravity_warnings(z: Measurements, fit: FreeFit) -> list[str]:
    """A sentence when gravity the other way round explains a moving recording much better."""
    if not z.linear_acceleration.any():
        return []
    reversed_fit = fit_freely(replace(z, gravity=-z.gravity), fit.bias is not None)
    ratio = reversed_fit.noise.force / fit.noise.force
    if ratio > 0.7:
        return []
    return [
        f"with gravity reversed the force residual would be {reversed_fit.noise.force:.2g} N in place of "
        f"{fit.noise.force:.2g} N: check --gravity"
    ]


def misfit_warnings(estimate: Estimate, residual: Array, z: Measurements, fit: FreeFit) -> list[str]:
    """A sentence when the estimate explains the wrench much worse than unconstrained least squares does."""
    free = np.array((fit.noise.force, fit.noise.torque))
    signal = np.sqrt(np.mean(z.wrench.reshape(-1, 2, 3) ** 2, axis=(0, 2)))
    if not ((residual > MISFIT * free) & (residual > 0.01 * signal)).any():
        return []
    cause = "the shape or its pose does not fit"
    if "c1" in estimate.provenance:
        cause += ", or c1 is too large for this motion"
    if estimate.hull_margin is None:
        cause = "do not trust it"
    return [
        f"{estimate.method} leaves {residual[0]:.2g} N and {residual[1]:.2g} N m of the wrench unexplained, "
        f"unconstrained least squares {free[0]:.2g} and {free[1]:.2g}: {cause}"
    ]

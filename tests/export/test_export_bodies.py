"""Bodies that the tests of the exports share, and what must hold of `Body` itself."""

import re
from dataclasses import dataclass

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import pose_matrix, rotation_matrices
from hefting.export import export
from hefting.export.body import Body

DOUBLE, SINGLE = 1e-12, 3e-7
"""Tolerances: of a reader's own arithmetic (MuJoCo diagonalises), and of single
precision in a quaternion."""

POSE = pose_matrix(
    (0.03, -0.02, 0.11, *(np.array((0.3, -0.5, 0.2, 0.7)) / np.sqrt(0.87)))
)
"""Sensor in flange: turned about no special axis, and shifted, so that any slip of
frame shows."""

SIMULATORS = ("urdf", "mjcf", "sdf", "usd")
CONTROLLERS = (
    *("ur", "xarm", "franka", "kuka", "abb", "fanuc"),
    *("ur-ros", "franka-desk", "kinova", "doosan"),
)
"""Those that take flange axes."""
IN_SENSOR_AXES = ("xarm-ft",)
IN_ANY_AXES = ("ros2-control",)

# kind: mass [kg], sides [m], whether the box is aligned with the sensor. Zero sides:
# flat and rod-like.
KINDS = {
    "box": (0.9, (0.08, 0.12, 0.2), False),
    "aligned": (0.9, (0.12, 0.2, 0.08), True),
    "cube": (1.1, (0.1, 0.1, 0.1), False),
    "cylinder-like": (1.1, (0.1, 0.1, 0.3), False),
    "flat": (0.4, (0.3, 0.2, 0.0), False),
    "flat aligned": (0.4, (0.0, 0.2, 0.3), True),
    "rod": (0.2, (0.0, 0.0, 0.5), False),
    "rod aligned": (0.2, (0.5, 0.0, 0.0), True),
    "light": (1e-3, (0.01, 0.02, 0.03), False),
    "light rod": (1e-3, (0.0, 0.0, 0.02), False),
    "heavy": (50.0, (0.4, 0.5, 0.9), False),
}
CASES = [(kind, seed) for kind in KINDS for seed in range(2)]


@dataclass
class Truth:
    """Mass, COM and tensor about the COM in the frame asked for."""

    mass: float
    com: np.ndarray
    tensor: np.ndarray


def make(kind: str, seed: int, pose: np.ndarray = POSE) -> tuple[Estimate, Truth]:
    """Estimate of a box in sensor axes, and the truth in the frame in which the sensor
    has this pose."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind)])
    mass, sides, aligned = KINDS[kind]
    quaternion = np.array((0.0, 0.0, 0.0, 1.0)) if aligned else rng.normal(size=4)
    R = rotation_matrices(quaternion / np.linalg.norm(quaternion))
    second = R @ np.diag(np.square(sides)) @ R.T * mass / 12
    tensor = np.trace(second) * np.eye(3) - second
    com = rng.uniform(-0.15, 0.15, 3)
    estimate = Estimate(
        "test",
        InertialParameters.from_com(mass, com, tensor),
        samples=100,
        duration=2.0,
    )
    Q = pose[:3, :3]
    return estimate, Truth(mass, Q @ com + pose[:3, 3], Q @ tensor @ Q.T)


def step(size: float) -> float:
    """Last of six significant digits."""
    return float(f"1e{int(f'{size:e}'.split('e')[1]) - 5}")


def check(
    truth: Truth, mass: float, com, tensor, digits: float, kind: str, steps: float = 0.5
) -> None:
    """Equal to within half a step of six digits and `digits`, relative to the mass, to
    1 m, and to the largest moment. `steps` are those of the tensor, in principal axes
    more: two moments that count as equal are each up to 1.5 off, and moments and angles
    are rounded once more each."""
    # A flat or rod-like body is given a thickness that changes moments by up to 2e-6 of
    # the largest.
    # An estimate holds J at the sensor: m |c|² / J is up to 2e3 for the light rod, so
    # eps grows to 1e-12.
    size = np.abs(truth.tensor).max()
    allowed = max(digits, 1e-11) + (3e-6 if "flat" in kind or "rod" in kind else 0)
    np.testing.assert_allclose(
        mass, truth.mass, rtol=digits, atol=0.5 * step(truth.mass)
    )
    largest = float(np.abs(truth.com).max())
    np.testing.assert_allclose(com, truth.com, atol=digits + 0.5 * step(largest))
    np.testing.assert_allclose(
        np.asarray(tensor) / size,
        truth.tensor / size,
        atol=allowed + steps * step(size) / size,
    )


PRINCIPAL_STEPS = 4.0
"""Rounding steps by which a tensor given in principal axes may be off, see `check`."""


def from_principal(moments, quaternion_wxyz) -> np.ndarray:
    """Tensor of principal moments along axes given by a quaternion, by the quaternion
    product q v q*."""
    w, u = quaternion_wxyz[0], np.asarray(quaternion_wxyz[1:])
    # single precision in four components
    assert np.isclose(w * w + u @ u, 1, atol=3e-7)
    axes = [
        v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v)) for v in np.eye(3)
    ]
    return np.sum(
        [m * np.outer(a, a) for m, a in zip(moments, axes, strict=True)], axis=0
    )


def symmetric(xx, yy, zz, xy, xz, yz) -> np.ndarray:
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def groups(pattern: str, text: str) -> tuple[str, ...]:
    """Groups of the only match in `text`."""
    (match,) = re.finditer(pattern, text, re.MULTILINE)
    return match.groups()


def physically_impossible() -> dict[str, InertialParameters]:
    return {
        "the mass is not positive": InertialParameters.from_com(
            -1, (0, 0, 0.1), np.eye(3)
        ),
        "not positive definite": InertialParameters.from_com(
            1, (0, 0, 0.1), np.diag((-1e-3, 1e-3, 1e-3))
        ),
        "triangle inequality": InertialParameters.from_com(
            1, (0, 0, 0.1), np.diag((1e-3, 1e-3, 3e-3))
        ),
        "the mass is not positive ": InertialParameters(np.zeros(10)),
    }


@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_principal_axes_are_right_handed_and_least_turned(kind, seed):
    body = Body.from_parameters(make(kind, seed)[0].parameters, "object", "sensor")
    moments, axes = body.principal()
    size = moments.max()
    assert np.isclose(np.linalg.det(axes), 1)
    assert moments.min() > 0
    np.testing.assert_allclose(
        axes @ np.diag(moments) @ axes.T / size, body.inertia / size, atol=1e-14
    )
    # No renaming of axes can be turned by more than about 63 deg from the frame (the
    # cube's rotation group).
    assert np.degrees(np.arccos((np.trace(axes) - 1) / 2)) < 63
    if kind == "aligned":
        # distinct moments, exact axes up to rounding of J
        np.testing.assert_allclose(axes, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("target", [*SIMULATORS, *CONTROLLERS])
def test_impossible_bodies_are_refused_with_the_reason(target):
    for reason, parameters in physically_impossible().items():
        with pytest.raises(InputError, match=reason.strip()):
            export(Estimate("OLS", parameters, 10), target, POSE)


@pytest.mark.parametrize("target", SIMULATORS)
def test_simulators_refuse_a_point_mass(target):
    estimate = Estimate(
        "test", InertialParameters.from_points([[0.11, 0.2, -0.3]], [0.7]), 1
    )
    with pytest.raises(InputError, match="point mass"):
        export(estimate, target)

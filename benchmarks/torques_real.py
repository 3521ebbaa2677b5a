"""Real joint torques with exact truth: a body is added to the torques of a bare arm.

Torque is linear in the parameters, so a body at the flange adds J' w, J the geometric
Jacobian and w the wrench it needs. Both come from `hefting.simulation`, which shares no
formula with the identification. One part of the run serves as the loaded one, the rest
as the empty one; the arm, its frictions, rotors and offsets are unknown.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, Mask
from hefting.estimators import OLS
from hefting.logs import read_log
from hefting.simulation.arm import Arm, JointMotion
from hefting.simulation.wield import wield
from hefting.torques.dynamics import JointDynamics
from hefting.torques.runs import LoadedRuns
from hefting.torques.samples import TorqueSamples

FRAME = "panda_link8"
"""The flange."""
SHORTEST = 50
"""Samples of a stretch that is used."""


@dataclass(frozen=True, eq=False)
class BareArm:
    """The run of an arm without a payload."""

    dynamics: JointDynamics
    samples: TorqueSamples
    jacobian: Array
    """(K, 6, n) of the flange's origin, force then torque, in its own axes"""
    arm: Arm

    @classmethod
    def read(cls, folder: Path) -> "BareArm":
        """From the folder that HEFTING_TORQUES names."""
        log = read_log(folder / "bare_arm.csv", wrench_needed=False)
        q, tau = log["joint_positions"], log["joint_torques"]
        urdf = folder / "panda_arm.urdf"
        dynamics = JointDynamics.from_urdf(urdf, FRAME)
        samples = TorqueSamples.smoothed(q.time, q.values, tau.time, tau.values)
        arm = Arm.from_urdf(urdf, FRAME)
        return cls(dynamics, samples, jacobian(arm, samples), arm)

    def torque(self, body: InertialParameters) -> Array:
        """(K, n) [N m] that a body at the flange adds."""
        s = self.samples
        motion = self.arm.motion(
            JointMotion(s.time, s.position, s.velocity, s.acceleration)
        )
        return np.einsum("kij,ki->kj", self.jacobian, wield(motion, body).wrench)

    def splits(self) -> dict[str, Mask]:
        """Which samples carry the payload, in four ways."""
        time = self.samples.time - self.samples.time[0]
        first, odd = time < 0.5 * time[-1], np.floor(time) % 2 == 1
        return {"first": first, "second": ~first, "odd": odd, "even": ~odd}


@dataclass(frozen=True)
class Errors:
    """Of one identification."""

    mass: float
    """[kg]"""
    com: Array
    """(3,) [m]"""
    z: Array
    """(4,) of mass and COM, in standard deviations"""


def jacobian(arm: Arm, samples: TorqueSamples) -> Array:
    """(K, 6, n): the flange's velocity for each joint at 1 rad/s, in its own axes."""
    zero = np.zeros_like(samples.position)
    columns = []
    for j in range(arm.n):
        velocity = zero.copy()
        velocity[:, j] = 1.0
        m = arm.motion(JointMotion(samples.time, samples.position, velocity, zero))
        twist = np.stack((m.linear_velocity, m.angular_velocity), axis=1)
        columns.append(np.einsum("kji,kcj->kci", m.rotation, twist).reshape(-1, 6))
    return np.stack(columns, axis=2)


def random_bodies(count: int, seed: int) -> list[InertialParameters]:
    """Boxes of 0.3 to 2 kg some centimetres from the flange."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        mass, sides = rng.uniform(0.3, 2.0), rng.uniform(0.05, 0.25, 3)
        square = sides**2 / 12.0
        R = Rotation.random(rng=rng).as_matrix()
        J = mass * R @ np.diag(square.sum() - square) @ R.T
        com = rng.uniform((-0.05, -0.05, 0.03), (0.05, 0.05, 0.15))
        found.append(InertialParameters.from_com(mass, com, J))
    return found


def identified(
    bare: BareArm, body: InertialParameters, loaded: Mask, arm_known: bool = False
) -> Errors:
    """Errors of least squares for a body in the `loaded` samples; with `arm_known` the
    published arm takes the place of the others."""
    added = bare.samples.torque + bare.torque(body)
    held = replace(bare.samples, torque=added)
    parts = [bare.samples[part] for part in stretches(~loaded)]
    runs = LoadedRuns(
        bare.dynamics,
        tuple(held[part] for part in stretches(loaded)),
        () if arm_known else tuple(parts),
        drift=False,
    )
    found = OLS().estimate(runs.fit().state)
    mass, com = found.mass, found.center_of_mass
    J = np.zeros((4, 10))
    J[0, 0] = 1.0
    J[1:, 0], J[1:, 1:4] = -com / mass, np.eye(3) / mass
    off = np.append(mass - body.mass, com - body.center_of_mass)
    assert found.covariance is not None
    return Errors(
        off[0], off[1:], off / np.sqrt((J @ found.covariance @ J.T).diagonal())
    )


def stretches(mask: Mask) -> list[slice]:
    """Runs of True of at least `SHORTEST`."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False]))))
    pairs = edges.reshape(-1, 2).tolist()
    return [slice(a, b) for a, b in pairs if b - a >= SHORTEST]


def summary(errors: list[Errors]) -> dict[str, float]:
    """Medians of the errors' sizes [g, mm], and the share of |z| up to 2.5."""
    com = np.median(np.abs([each.com for each in errors]), axis=0)
    z = np.abs([each.z for each in errors])
    return {
        "mass [g]": 1e3 * float(np.median(np.abs([each.mass for each in errors]))),
        **{
            f"COM {axis} [mm]": 1e3 * float(value)
            for axis, value in zip("xyz", com, strict=True)
        },
        "|z| <= 2.5": float((z <= 2.5).mean()),
        "|z| <= 1.96": float((z <= 1.96).mean()),
    }

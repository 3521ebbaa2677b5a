"""Simulated recordings of joint torques, of an arm with and without an object, with the
arm's published URDF.

    tau = M(q) ddq + ... (MuJoCo's inverse dynamics, with the payload)
        + rotor ddq
        + (coulomb (1 - softening h) + load |tau of the rigid bodies|) sign(dq)
        + viscous dq + offset + drift h + noise

h = 1 - exp(-t / `warm_up`) is the warmth of the gears, from 0 to 1. Published inertias of
robots predict their torques poorly, so the true links differ from those in the URDF.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError, nearest
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, Array, immutable, tensor_to_vector
from hefting.robots.inertials import ENTRIES
from hefting.simulation.arm import PANDA, UR5E, XARM7, Arm, JointMotion
from hefting.simulation.faults import correlated
from hefting.simulation.joints import wide_smooth
from hefting.simulation.objects import HeldObject
from hefting.simulation.wield import inverse_dynamics, mujoco_version, numbers

RADIUS = 0.06
"""[m] Radius of a link, a rod from one joint to the next."""
LEAST_LENGTH = 0.05
"""[m] Least length of a link."""
WRONG_MASS, WRONG_COM, WRONG_INERTIA = 0.1, 0.008, 0.2
"""Standard deviations of the true links from the published ones: of mass and moments of
inertia relative, of the COM along each axis [m]."""


@immutable
class MassiveArm:
    """An arm with masses of its links and noise of its torques."""

    arm: Arm
    masses: tuple[float, ...]
    """[kg] of the links, published"""
    torque_noise: tuple[float, float]
    """standard deviations [N m] of the torques of the first and the last joint"""

    def __post_init__(self):
        if len(self.masses) != len(self.arm.robot.screws):
            raise InputError(
                f"{len(self.masses)} masses for {len(self.arm.robot.screws)} links"
            )

    @cached_property
    def links(self) -> tuple[InertialParameters, ...]:
        """Published links, in base axes with all joints at zero, each about a point on
        its joint's axis."""
        robot = self.arm.robot
        points = [screw.point for screw in robot.screws]
        ends = [*points[1:], robot.home_position]
        return tuple(
            _rod(mass, end - point)
            for mass, point, end in zip(self.masses, points, ends, strict=True)
        )

    def true_links(self, seed: int) -> tuple[InertialParameters, ...]:
        """Links of the robot of a `seed`, in the same axes."""
        rng = np.random.default_rng([seed, 41])
        return tuple(_changed(link, rng) for link in self.links)

    @property
    def urdf(self) -> str:
        """URDF text with the published links; the last link is ``flange``."""
        return urdf(self.arm, self.links)

    def per_joint(self, first: float, last: float) -> Array:
        """(n,) values from `first` at the base to `last`, in geometric progression."""
        return np.geomspace(first, last, self.arm.n)


def urdf(arm: Arm, links: Sequence[InertialParameters]) -> str:
    """The URDF of an arm, with links as in `MassiveArm.links`."""
    robot = arm.robot
    lines = ['<robot name="arm">', '<link name="base"/>']
    place, parent = np.zeros(3), "base"
    for i, (screw, link) in enumerate(zip(robot.screws, links, strict=True), 1):
        low, high = robot.limits[screw.column] or (-1.0, 1.0)
        speed = 10.0 if arm.joint_speeds is None else arm.joint_speeds[screw.column]
        kind = "prismatic" if screw.slides else "revolute"
        own = f"link{i}"
        lines += [
            f'<joint name="{robot.joints[screw.column]}" type="{kind}">'
            f'<origin xyz="{numbers(screw.point - place)}"/>'
            f'<parent link="{parent}"/><child link="{own}"/>'
            f'<axis xyz="{numbers(screw.axis)}"/>'
            f'<limit lower="{low!r}" upper="{high!r}" effort="1000" '
            f'velocity="{float(speed)!r}"/>'
            "</joint>",
            f'<link name="{own}">{_inertial(link)}</link>',
        ]
        place, parent = screw.point, own
    rpy = Rotation.from_quat(robot.home_orientation).as_euler("xyz")
    lines += [
        '<joint name="flange_joint" type="fixed">'
        f'<origin xyz="{numbers(robot.home_position - place)}" rpy="{numbers(rpy)}"/>'
        f'<parent link="{parent}"/><child link="flange"/></joint>',
        '<link name="flange"/>',
        "</robot>",
    ]
    return "\n".join(lines) + "\n"


def _inertial(link: InertialParameters) -> str:
    values = zip(ENTRIES, tensor_to_vector(link.inertia_at_com).tolist(), strict=True)
    inertia = " ".join(f'{name}="{value!r}"' for name, value in values)
    return (
        f'<inertial><origin xyz="{numbers(link.center_of_mass)}"/>'
        f'<mass value="{float(link.mass)!r}"/><inertia {inertia}/></inertial>'
    )


def _rod(mass: float, along: Array) -> InertialParameters:
    """A cylinder from the origin to the point `along` (3,) [m]."""
    length = max(float(np.linalg.norm(along)), LEAST_LENGTH)
    unit = along / length if np.linalg.norm(along) > 1e-6 else np.array((0.0, 0.0, 1.0))
    across = mass * (3.0 * RADIUS**2 + length**2) / 12.0
    spin = 0.5 * mass * RADIUS**2
    J = across * np.eye(3) + (spin - across) * np.outer(unit, unit)
    return InertialParameters.from_com(mass, 0.5 * along, J)


def _changed(link: InertialParameters, rng: np.random.Generator) -> InertialParameters:
    mass = link.mass * np.exp(WRONG_MASS * rng.standard_normal())
    com = link.center_of_mass + WRONG_COM * rng.standard_normal(3)
    J = link.inertia_at_com * np.exp(WRONG_INERTIA * rng.standard_normal())
    return InertialParameters.from_com(float(mass), com, J)


TORQUE_ARMS = {
    "ur5e": MassiveArm(UR5E, (3.7, 8.4, 2.3, 1.2, 1.2, 0.2), (0.1, 0.05)),
    "panda": MassiveArm(PANDA, (3.1, 2.4, 3.2, 2.5, 3.4, 1.5, 0.7), (0.1, 0.05)),
    "xarm7": MassiveArm(XARM7, (2.4, 1.9, 1.7, 1.8, 1.5, 1.1, 0.3), (0.1, 0.05)),
}
"""Arms with masses, by name: about the makers' values."""


SMOOTH = 0.002
"""[rad/s] Scale v of the sign of friction, tanh(dq / v)."""


@dataclass(frozen=True)
class TorqueFaults:
    """Torques of a joint besides those of rigid bodies; pairs are of the first and the
    last joint, with a geometric progression between (`MassiveArm.per_joint`)."""

    noise: float = 1.0
    """factor of `MassiveArm.torque_noise`"""
    noise_correlation: float = 0.0
    """of the noise over a hundredth of a second"""
    coulomb: tuple[float, float] = (1.5, 0.3)
    """[N m]"""
    load_friction: float = 0.03
    """over the torque of the rigid bodies"""
    viscous: tuple[float, float] = (1.5, 0.2)
    """[N m s/rad]"""
    rotor: tuple[float, float] = (0.5, 0.1)
    """reflected inertia [kg m²]"""
    offset: tuple[float, float] = (0.5, 0.1)
    """standard deviations [N m]"""
    drift: tuple[float, float] = (0.05, 0.02)
    """standard deviations of the change of offsets from cold to warm [N m]"""
    softening: float = 0.1
    """share of the Coulomb friction that vanishes from cold to warm"""
    warm_up: float = 300.0
    """time constant [s]"""
    joint_noise: float = 2e-5
    """standard deviation of joint angles [rad]"""


@immutable
class TorqueRobot:
    """One specimen of a robot: true links, frictions and offsets follow from `seed`."""

    massive: MassiveArm
    faults: TorqueFaults = TorqueFaults()
    seed: int = 0

    def record(
        self,
        joints: JointMotion,
        body: InertialParameters | None,
        start: float = 0.0,
        gravity: ArrayLike = STANDARD_GRAVITY,
        seed: int = 0,
    ) -> Recording:
        """Positions and torques of the joints along a motion that begins at `start` [s]
        after the robot was switched on, with `body` (in the sensor frame) or without.

        The noise depends on both seeds, all else on the robot's own. Raises
        `MissingDependencyError` without MuJoCo, and `InputError` as
        `inverse_dynamics`.
        """
        rng = np.random.default_rng([self.seed, seed, 43])
        links = self.massive.true_links(self.seed)
        rigid = inverse_dynamics(self.massive.arm, joints, links, body, gravity)
        time = start + joints.time
        torque = rigid + self._joint_torques(joints, rigid, time)
        torque = torque + self._noise(time, rng)
        noise = self.faults.joint_noise * rng.standard_normal(rigid.shape)
        names = self.massive.arm.robot.joints
        return Recording(
            {
                "joint_positions": Stream(time, joints.position + noise),
                "joint_torques": Stream(time, torque),
            },
            source="simulation",
            joint_names=names,
        )

    def _joint_torques(self, joints: JointMotion, rigid: Array, time: Array) -> Array:
        """(K, n) friction, rotor and offset torques [N m]."""
        f, each = self.faults, self.massive.per_joint
        rng = np.random.default_rng([self.seed, 42])
        factors = np.exp(0.3 * rng.standard_normal((3, self.massive.arm.n)))
        normal = rng.standard_normal((2, self.massive.arm.n))
        warmth = -np.expm1(-time / f.warm_up)[:, None]
        sign = np.tanh(joints.velocity / SMOOTH)
        coulomb = factors[0] * each(*f.coulomb) * (1.0 - f.softening * warmth)
        friction = (coulomb + f.load_friction * np.abs(rigid)) * sign
        friction += factors[1] * each(*f.viscous) * joints.velocity
        rotor = factors[2] * each(*f.rotor) * joints.acceleration
        offset = each(*f.offset) * normal[0] + each(*f.drift) * normal[1] * warmth
        return friction + rotor + offset

    def _noise(self, time: Array, rng: np.random.Generator) -> Array:
        std = self.faults.noise * self.massive.per_joint(*self.massive.torque_noise)
        white = rng.standard_normal((len(time), len(std)))
        step = (time[-1] - time[0]) / max(len(time) - 1, 1)
        a = self.faults.noise_correlation ** (step / 0.01)
        return std * correlated(white, a)


BETWEEN = 60.0
"""[s] Least time from the start of the empty run to that of the loaded one, in which
gears warm up."""


@immutable
class TorquesSimulated:
    """Result of a scenario."""

    loaded: Recording
    """joint angles and torques with the object"""
    empty: Recording
    """those of an earlier, other motion without it"""
    urdf: str
    """the published arm; its last link is ``flange``"""
    facts: dict[str, Any]
    """as in `hefting.simulation.scenario.Simulated`"""


@immutable
class TorqueScenario:
    """Arm, object and faults to simulate; the same for the same `seed`."""

    held: HeldObject
    arm: str = "ur5e"
    """one of `TORQUE_ARMS`"""
    duration: float = 30.0
    """of each run [s]"""
    rate: float = 100.0
    """[Hz]"""
    gravity: ArrayLike = STANDARD_GRAVITY
    """(3,) in the axes of the arm's base [m/s²]"""
    faults: TorqueFaults = field(default_factory=TorqueFaults)
    seed: int = 0

    def run(self) -> TorquesSimulated:
        """Move the arm in MuJoCo, empty and loaded.

        Raises `MissingDependencyError` without MuJoCo, and `InputError` for another arm
        and for numbers out of range.
        """
        if self.arm not in TORQUE_ARMS:
            what = f"there is no arm '{self.arm}' with torques"
            fix = f"choose one of {', '.join(TORQUE_ARMS)}"
            raise InputError(what + nearest(self.arm, TORQUE_ARMS), fix=fix)
        massive = TORQUE_ARMS[self.arm]
        robot = TorqueRobot(massive, self.faults, self.seed)
        motions = [
            wide_smooth(self.duration, self.rate, 2 * self.seed + k, massive.arm)
            for k in (0, 1)
        ]
        later = max(BETWEEN, 2.0 * self.duration)
        body, gravity = self.held.parameters, self.gravity
        empty = robot.record(motions[0], None, 0.0, gravity, seed=0)
        loaded = robot.record(motions[1], body, later, gravity, seed=1)
        facts = self.held.truth(np.asarray(gravity), False)
        facts["simulation"] = {
            "engine": f"MuJoCo {mujoco_version()}",
            "arm": self.arm,
            "sensor_frame": "flange",
            "duration": self.duration,
            "rate": self.rate,
            "faults": asdict(self.faults),
            "seed": self.seed,
        }
        return TorquesSimulated(loaded, empty, massive.urdf, facts)
